#!/usr/bin/env bash
# Scenes solved by the library as WebAssembly, in Node and in headless Chromium.
# usage: test_solve.sh PROGRAM SOURCE_FOLDER
set -euo pipefail

program=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

skip() {
    echo "skipped: $*"
    exit 77
}

[[ -d $source/web/node_modules ]] || skip "web/node_modules is absent; ./dev test or 'npm ci' in web installs it"
for tool in node emcc clang chromium apt-get; do
    command -v "$tool" >/dev/null || skip "$tool is not installed"
done
CHROMIUM=$(command -v chromium)
export CHROMIUM

page=$work/page
(cd "$source/web" && npx vite build --outDir "$page" --logLevel warn)
"$source/rt/build_wasm.sh" "$page/resolvent_rt.wasm"
"$source/web/solver/build.sh" "$page" >"$work/build.log" || { tail -n 20 "$work/build.log"; exit 1; }
mkdir "$page/scene"
"$program" scene cornell-blocks -o "$work/plain.glb"
"$program" bake cornell-blocks -o "$page/scene/box.glb" --to lightmap --map-size 64 --basis --quality draft
"$program" render cornell-blocks -o "$page/scene/box-operator.png" --mode operator --quality draft --size 256x256 --spp 16
cp "$page/scene/box-operator.png" "$page/scene/box.png"

# in Node, with threads and without: the same bytes
for threads in 1 2 3; do
    node --no-experimental-fetch "$source/tests/web/solve_node.js" "$page" "$work/plain.glb" "$work/lit-$threads" threads=$threads mapSize=256
    cmp "$work/lit-1.glb" "$work/lit-$threads.glb"
    cmp "$work/lit-1.light.safetensors" "$work/lit-$threads.light.safetensors"
done
node "$source/tests/web/validate.mjs" "$source/web" "$work/lit-1.glb"
# more triangles than asked for
if node --no-experimental-fetch "$source/tests/web/solve_node.js" "$page" "$work/plain.glb" "$work/refused" triangles=10 >"$work/said"; then
    echo "FAILED: a scene that is too large was solved"
    exit 1
fi
grep -q "has 32 triangles; a page solves 10 at most" "$work/said"

node "$source/tests/web/test_solve.mjs" "$source/web" "$page" "$work/plain.glb" ${SCREENSHOTS:+"$SCREENSHOTS"}
