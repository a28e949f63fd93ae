#!/usr/bin/env bash
# The runtime for one of the targets it promises; skipped where its compiler is absent.
# usage: test_target.sh SOURCE_FOLDER freestanding|arm|windows|wasm
set -euo pipefail

runtime=$1/rt tests=$1/tests/runtime
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
flags=(-std=c99 -O2 -Wall -Wextra -Wshadow -Werror -ffp-contract=off -I "$runtime")
largest_module=32768

need() {
    command -v "$1" >/dev/null && return
    echo "skipped: $1 is not installed"
    exit 77
}

# Nothing is left to link, whatever the optimiser makes of loops.
freestanding() {
    local level
    echo 'void _start(void) { for (;;) ; }' >"$work/start.c"
    for level in -O0 -O2 -O3; do
        cc "${flags[@]}" $level -ffreestanding -fno-stack-protector -nostdlib -static \
            "$work/start.c" "$runtime/resolvent_rt.c" -o "$work/alone"
    done
}

arm() {
    need aarch64-linux-gnu-gcc
    need qemu-aarch64
    aarch64-linux-gnu-gcc "${flags[@]}" -static "$runtime/resolvent_rt.c" "$tests"/*.c -o "$work/twins"
    qemu-aarch64 "$work/twins"
}

windows() {
    need x86_64-w64-mingw32-gcc
    x86_64-w64-mingw32-gcc "${flags[@]}" -ffreestanding -c "$runtime/resolvent_rt.c" -o "$work/rt.o"
}

wasm() {
    need clang
    need wasm-ld
    "$runtime/build_wasm.sh" "$work/rt.wasm"
    local bytes
    bytes=$(stat -c %s "$work/rt.wasm")
    echo "$bytes bytes"
    ((bytes <= largest_module))
    if clang --version | grep -q 'version 14'; then # the one that docs/runtime.md speaks of
        grep -q "a module of $(awk "BEGIN { printf \"%.1f\", $bytes / 1000 }") KB" "$1/docs/runtime.md"
    fi
    need node
    node "$tests/wasm.mjs" "$work/rt.wasm"
}

"$2" "$1"
