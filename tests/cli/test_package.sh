#!/usr/bin/env bash
# An outside project in C finds the installed package through CMake and through pkg-config.
# usage: test_package.sh BUILD_FOLDER SOURCE_FOLDER
set -euo pipefail

build=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix=$work/prefix

cmake --install "$build" --prefix "$prefix" >/dev/null
"$prefix/bin/resolvent" --version

mkdir "$work/outside"
cp "$source/samples/minimal.c" "$work/outside"
cat >"$work/outside/CMakeLists.txt" <<'TEXT'
cmake_minimum_required(VERSION 3.22)
project(outside LANGUAGES C)
find_package(resolvent 0.1 REQUIRED)
add_executable(minimal minimal.c)
target_link_libraries(minimal PRIVATE resolvent::resolvent)
TEXT
cmake -S "$work/outside" -B "$work/outside/build" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$work/outside/build" >/dev/null

PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name resolvent.pc)")
export PKG_CONFIG_PATH
[[ $(pkg-config --variable=prefix resolvent) -ef $prefix ]]
cc "$source/samples/minimal.c" -o "$work/minimal" $(pkg-config --cflags --libs --static resolvent)

cd "$work"
outside/build/minimal
mv minimal.png first.png
./minimal
cmp first.png minimal.png
echo "all passed"
