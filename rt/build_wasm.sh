#!/usr/bin/env bash
# The runtime as a WebAssembly module by clang and lld alone, with SIMD, or `scalar`, which gives the same bits.
# usage: build_wasm.sh OUT.wasm [scalar]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
functions=(rsv_rt_status_text rsv_rt_relight rsv_rt_turn rsv_rt_operator_check rsv_rt_solver_begin
    rsv_rt_solver_keep_bounced rsv_rt_solver_update rsv_rt_receivers_check rsv_rt_receive rsv_rt_probe_at
    rsv_rt_sh_irradiance)
kind=(-msimd128)
[[ ${2:-} != scalar ]] || kind=(-DRSV_RT_SCALAR)
object=$(mktemp)
trap 'rm -f "$object"' EXIT
clang --target=wasm32 -std=c99 -O3 "${kind[@]}" -ffreestanding -ffp-contract=off -c "$here/resolvent_rt.c" -o "$object"
# without -O: with it, clang runs whatever wasm-opt is installed, and Debian's refuses SIMD that it is not told of
clang --target=wasm32 -nostdlib -Wl,--no-entry -Wl,--strip-all "${functions[@]/#/-Wl,--export=}" \
    -Wl,--export=__heap_base "$object" -o "$1"
