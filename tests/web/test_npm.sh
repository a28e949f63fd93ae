#!/usr/bin/env bash
# The npm package, packed and installed into an empty folder: in Node, and in a plain page in headless Chromium.
# usage: test_npm.sh PROGRAM SOURCE_FOLDER [FOLDER_FOR_SCREENSHOTS]
set -euo pipefail

program=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
skip() {
    echo "skipped: $*"
    exit 77
}
for tool in node npm clang wasm-ld; do
    command -v "$tool" >/dev/null || skip "$tool is not installed"
done

tarball=$("$source/web/rt/pack.sh" "$work")
size=$(stat -c %s "$tarball")
echo "$(basename "$tarball"): $size bytes"
((size <= 60 * 1024)) || { echo "FAILED: the tarball has more than 60 KB" && exit 1; }
mkdir "$work/user"
echo '{"name": "user", "type": "module", "private": true}' >"$work/user/package.json"
(cd "$work/user" && npm install --silent --offline --no-audit --no-fund --legacy-peer-deps "$tarball")
! grep -nE '\beval\(|new Function' "$work"/user/node_modules/resolvent-rt/*.js || { echo "FAILED: eval" && exit 1; }

"$program" bake cornell-blocks -o "$work/user/box.glb" --to vertex --basis --quality draft --max-elements 500
"$program" bake cornell-blocks -o "$work/user/plain.glb" --to lightmap --basis --map-size 256 --quality draft --max-elements 500
"$program" bake cornell-blocks -o "$work/user/map.glb" --to lightmap --basis --packed --map-size 256 --quality draft --max-elements 500
cp "$source/tests/web/npm_node.mjs" "$source/tests/web/npm_page.html" "$work/user"
(cd "$work/user" && node npm_node.mjs plain.light.safetensors map.light.safetensors)

if [[ ! -d $source/web/node_modules ]] || ! command -v chromium >/dev/null; then
    echo "skipped: the page, because web/node_modules or chromium is absent"
    exit 0
fi
ln -s "$source/web/node_modules/three" "$work/user/node_modules/three"
cp "$source/samples/page/index.html" "$work/user"
for kind in glb light.safetensors; do cp "$work/user/box.$kind" "$work/user/room-lit.$kind"; done
CHROMIUM=$(command -v chromium) node "$source/tests/web/npm_page.mjs" "$source/web" "$work/user" "${3:-}"
