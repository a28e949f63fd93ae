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
[[ -s $prefix/share/man/man1/resolvent-render.1 ]]
[[ -s $prefix/share/doc/resolvent/LICENSE ]]

# the pages that manual pages point to are there
sed 's/\\-/-/g' "$prefix"/share/man/man1/*.1 | grep -oE 'docs/[a-z-]+\.md' | sort -u >"$work/pages"
[[ -s $work/pages ]]
while read -r page; do
    [[ -s $prefix/share/doc/resolvent/$page ]]
done <"$work/pages"

# and the pictures and samples that they link to
dead=$(python3 "$source/tests/links.py" "$prefix"/share/doc/resolvent/{,docs/,docs/benchmarks/}*.md |
    grep -E 'figures/|samples/|examples/' || true)
[[ -z $dead ]] || { echo "$dead" && false; }
[[ -s $prefix/share/doc/resolvent/docs/figures/cornell-spheres.png ]]

# completion in bash
COMP_WORDS=("$prefix/bin/resolvent" rend) COMP_CWORD=1
source "$prefix/share/bash-completion/completions/resolvent"
_resolvent
[[ ${COMPREPLY[*]} == render ]]
COMP_WORDS=("$prefix/bin/resolvent" render --expo) COMP_CWORD=2
_resolvent
[[ ${COMPREPLY[*]} == --exposure ]]
COMP_WORDS=("$prefix/bin/resolvent" render --quality m) COMP_CWORD=3
_resolvent
[[ ${COMPREPLY[*]} == medium ]]
COMP_WORDS=("$prefix/bin/resolvent" render cornell-pl) COMP_CWORD=2
_resolvent
[[ ${COMPREPLY[*]} == cornell-plaster ]]

# completion in fish and zsh, where they are installed
if command -v fish >/dev/null; then
    [[ -s $prefix/share/fish/vendor_completions.d/resolvent.fish ]]
    offered=$(PATH=$prefix/bin:$PATH fish -N -c "source $prefix/share/fish/vendor_completions.d/resolvent.fish
        complete -C 'resolvent rend'; complete -C 'resolvent --vers'; complete -C 'resolvent render --expo'
        complete -C 'resolvent render --quality m'; complete -C 'resolvent render cornell-pl'" | cut -f1)
    [[ $offered == $'render\n--version\n--exposure\nmedium\ncornell-plaster' ]]
fi
! command -v zsh >/dev/null || zsh -n "$prefix/share/zsh/vendor-completions/_resolvent"

mkdir "$work/outside"
cp "$source/samples/minimal.c" "$work/outside"
echo '#include <resolvent_rt.h>
int main(void) { return !rsv_rt_status_text(RSV_RT_OK); }' >"$work/outside/engine.c"
cat >"$work/outside/CMakeLists.txt" <<'TEXT'
cmake_minimum_required(VERSION 3.22)
project(outside LANGUAGES C)
find_package(resolvent 0.1 REQUIRED)
add_executable(minimal minimal.c)
target_link_libraries(minimal PRIVATE resolvent::resolvent)
add_executable(engine engine.c)
target_link_libraries(engine PRIVATE resolvent::rt)
TEXT
cmake -S "$work/outside" -B "$work/outside/build" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$work/outside/build" >/dev/null

# the runtime alone has no dependencies
mkdir "$work/engine-only"
cp "$work/outside/engine.c" "$work/engine-only"
cat >"$work/engine-only/CMakeLists.txt" <<'TEXT'
cmake_minimum_required(VERSION 3.22)
project(engine LANGUAGES C)
find_package(resolvent 0.1 REQUIRED COMPONENTS rt)
if(TARGET resolvent::resolvent OR embree_FOUND)
    message(FATAL_ERROR "more than the runtime was found")
endif()
add_executable(engine engine.c)
target_link_libraries(engine PRIVATE resolvent::rt)
TEXT
cmake -S "$work/engine-only" -B "$work/engine-only/build" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$work/engine-only/build" >/dev/null
"$work/engine-only/build/engine"
sed -i 's/COMPONENTS rt/COMPONENTS none/' "$work/engine-only/CMakeLists.txt"
if cmake -S "$work/engine-only" -B "$work/engine-only/build2" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null 2>&1; then
    echo "a component that does not exist was found" >&2
    exit 1
fi

PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name resolvent.pc)")
export PKG_CONFIG_PATH
[[ $(pkg-config --variable=prefix resolvent) -ef $prefix ]]
cc "$source/samples/minimal.c" -o "$work/minimal" $(pkg-config --cflags --libs --static resolvent)

# samples of embedding, by both compilers, as C17 and as C++17
for sample in "$source"/samples/embed/*.c; do
    for compiler in "gcc -std=gnu17" "clang -std=gnu17" "g++ -std=gnu++17 -x c++" "clang++ -std=gnu++17 -x c++"; do
        command -v "${compiler%% *}" >/dev/null || continue
        # shellcheck disable=SC2086 # several words each
        $compiler -Wall -Wextra -Werror -c "$sample" -o "$work/sample.o" $(pkg-config --cflags resolvent)
    done
done

# c_block N: the n-th piece of C in the tour of the API
c_block() { awk -v n="$1" '/^```c$/ { k++; next } /^```$/ { if (k == n) exit } k == n' "$source/docs/api.md"; }
c_block 1 >"$work/tour.c"
cc -Wall -Werror "$work/tour.c" -o "$work/tour" $(pkg-config --cflags --libs --static resolvent)
{
    echo '#include <resolvent/resolvent.h>'
    echo '#include <stdio.h>'
    echo 'rsv_status follow(rsv_context *context, rsv_scene *room, rsv_scene *moved, rsv_solve_desc solve) {'
    echo 'rsv_light *before = NULL, *after = NULL; rsv_status status;'
    c_block 2
    echo 'return status; }'
} >"$work/update.c"
cc -Wall -Werror -c "$work/update.c" -o "$work/update.o" $(pkg-config --cflags resolvent)

cc "$work/outside/engine.c" -o "$work/engine" $(pkg-config --cflags --libs resolvent_rt)
cc -c "$prefix"/share/resolvent/rt/resolvent_rt_file.c -o "$work/loader.o" \
    $(pkg-config --cflags resolvent_rt libcjson)

cd "$work"
outside/build/engine
./engine
outside/build/minimal
mv minimal.png first.png
./minimal
cmp first.png minimal.png
./tour
[[ -s spheres.png ]]

# the packages for Debian and Ubuntu, unpacked elsewhere: one contains the program, the other all that is needed to compile against it
if command -v dpkg-shlibdeps >/dev/null; then
    cpack -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip --config "$build/CPackConfig.cmake" -B "$work" >/dev/null
    program=$(echo "$work"/resolvent_*.deb) development=$(echo "$work"/resolvent-dev_*.deb)
    for package in "$program" "$development"; do
        name=$(dpkg-deb --field "$package" Package)
        [[ $(dpkg-deb --field "$package" Maintainer) =~ ^[^\<]+\ \<[^@]+@[^@]+\.[a-z]+\>$ ]]
        dpkg-deb --contents "$package" >"$work/$name.contents"
        grep -q "/usr/share/doc/$name/copyright" "$work/$name.contents"
    done
    [[ $(dpkg-deb --field "$program" Depends) == *libembree* ]]
    [[ -z $(grep -E '/usr/include/|\.a$|\.pc$|\.cmake$' "$work/resolvent.contents") ]]
    [[ -z $(grep '/usr/bin/' "$work/resolvent-dev.contents") ]]
    for plug_in in mpi:mpi cuda:cuda; do # a package each: the program alone asks for neither MPI nor a GPU
        grep -q "CPACK_COMPONENTS_ALL .*\b${plug_in#*:}\b" "$build/CPackConfig.cmake" || continue
        package=$(echo "$work"/resolvent-"${plug_in#*:}"_*.deb)
        [[ $(dpkg-deb --contents "$package") == */usr/lib*/libresolvent_${plug_in%:*}.so* ]]
        [[ $(dpkg-deb --contents "$package") == */usr/share/doc/resolvent-${plug_in#*:}/copyright* ]]
        [[ $(dpkg-deb --field "$package" Depends) == *"resolvent (= "* ]]
    done
    [[ $(dpkg-deb --field "$program" Depends) != *mpi* ]]
    [[ -z $(grep -E 'libresolvent_(mpi|cuda)' "$work/resolvent.contents") ]]
    for name in embree draco assimp openexr cjson; do
        [[ $(dpkg-deb --field "$development" Depends) == *lib$name-dev* ]]
    done
    [[ $(dpkg-deb --field "$development" Depends) == *zlib1g-dev* ]]
    dpkg-deb --extract "$program" "$work/unpacked"
    "$work/unpacked/usr/bin/resolvent" info furnace >/dev/null
    dpkg-deb --extract "$development" "$work/unpacked"
    PKG_CONFIG_PATH=$(dirname "$(find "$work/unpacked" -name resolvent.pc)")
    cc "$source/samples/minimal.c" -o "$work/packaged" $(pkg-config --cflags --libs --static resolvent)
fi
echo "all passed"
