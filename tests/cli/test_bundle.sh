#!/usr/bin/env bash
# The bundle holds all that its programs need but the C library, and works without any environment.
# usage: test_bundle.sh BUILD_FOLDER
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
complain() {
    echo "FAILED: $*"
    failures=$((failures + 1))
}

cmake --install "$1" --component bundle --prefix "$work/bundle" >/dev/null || complain "it cannot be installed"
mv "$work/bundle" "$work/elsewhere"
cd "$work/elsewhere" || exit 1

# shared libraries that the loader finds, except the C library, the loader itself and those of the kernel
for file in bin/* lib/libresolvent_*.so; do
    env -i ldd "$file" | grep -v -e 'linux-vdso' -e 'ld-linux' -e '/lib\(c\|m\|dl\|rt\|pthread\|resolv\)\.so' >needed
    [[ $file != bin/* ]] || ! grep -v "$PWD" needed || complain "$file needs what is not in the bundle"
done
env -i bin/resolvent render furnace -o "$work/a.png" --size 16x12 --quality draft --threads 1 --device emulated \
    >log 2>&1 || complain "it does not render: $(tail -n 1 log)"
code=0
env -i PATH="$PATH" CUDA_VISIBLE_DEVICES= ./run-gpu >log 2>&1 || code=$?
[[ $code == 77 ]] || complain "run-gpu ends with $code where there is no GPU: $(tail -n 1 log)"
((failures == 0)) && echo "all passed"
exit $((failures > 0))
