#!/usr/bin/env bash
# Makes a wheel of the Python package, offline.
# usage: make_wheel.sh BUILD_FOLDER OUTPUT_FOLDER [PYTHON]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
mkdir -p "$2"
output=$(cd "$2" && pwd)
python=${3:-/usr/bin/python3}
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT

cmake --install "$build" --component python --prefix "$stage" --strip >/dev/null
# wheels hold no links: each library goes by the name that others ask for
for link in "$stage"/resolvent/lib/*; do
    [[ -L $link ]] && mv "$(readlink -f "$link")" "$link"
done
bash "$here/../../cmake/copy_licences.sh" "$stage/resolvent/lib" "$stage/resolvent/licences"
cd "$stage"
"$python" -c 'import sys; from setuptools import build_meta; print(build_meta.build_wheel(sys.argv[1]), file=sys.stderr)' \
    "$output" >log 2>name || {
    cat log name >&2
    exit 1
}
echo "$output/$(tail -n 1 name)"
