#!/usr/bin/env bash
# The npm package as a tarball: pack.sh OUT_FOLDER
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
out=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cp "$here"/*.js "$here"/*.d.ts "$here/package.json" "$here/README.md" "$here/../../LICENSE" "$work"
"$here/../../rt/build_wasm.sh" "$work/resolvent_rt.wasm"
"$here/../../rt/build_wasm.sh" "$work/resolvent_rt_scalar.wasm" scalar
(cd "$work" && npm pack --silent --pack-destination "$out" >/dev/null)
echo "$out/resolvent-rt-$(sed -n 's/.*"version": "\(.*\)".*/\1/p' "$here/package.json").tgz"
