#!/usr/bin/env bash
# The page with a scene baked just now, in headless Chromium; and the validator's word on baked files.
# usage: test_web.sh PROGRAM SOURCE_FOLDER
set -euo pipefail

program=$1 source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

skip() {
    echo "skipped: $*"
    exit 77
}

[[ -d $source/web/node_modules ]] || skip "web/node_modules is absent; ./dev test or 'npm ci' in web installs it"
for tool in node python3 clang wasm-ld chromium; do
    command -v "$tool" >/dev/null || skip "$tool is not installed"
done
CHROMIUM=$(command -v chromium)
export CHROMIUM

page=$work/page
(cd "$source/web" && npx vite build --outDir "$page" --logLevel warn)
"$source/rt/build_wasm.sh" "$page/resolvent_rt.wasm"
mkdir "$page/scene"
"$program" bake cornell-blocks -o "$page/scene/box.glb" --to vertex --basis --quality draft --max-elements 1500
"$program" render cornell-blocks -o "$page/scene/box-operator.png" --mode operator --quality draft --max-elements 1500 \
    --size 256x256 --spp 16
cp "$page/scene/box-operator.png" "$page/scene/box.png"
hill=(terraces:5000 --env "$page/scene/hill.hdr" --quality draft --max-elements 1500)
node "$source/web/make_sky.mjs" "$page/scene/hill.hdr"
"$program" bake "${hill[@]}" -o "$page/scene/hill.glb" --to vertex --unlit --basis --env-turns 4
"$program" render "${hill[@]}" --env-rotate 90 -o "$page/scene/hill-turned.png" --mode operator --size 256x144 --spp 16
"$program" bake cornell-blocks -o "$page/scene/map.glb" --to lightmap --basis --packed --map-size 512 --quality draft --max-elements 1500
"$program" scene cornell-blocks -o "$page/scene/plain.glb"
# vertices with colours of their own, and a box that no camera looks at
for box in colored framed; do
    python3 "$source/tests/cli/change_box.py" $box "$page/scene/plain.glb" "$work/$box.glb"
    "$program" bake "$work/$box.glb" -o "$page/scene/$box.glb" --to vertex --basis --quality draft --max-elements 800
    "$program" render "$work/$box.glb" -o "$page/scene/$box.png" --mode operator --quality draft --size 256x256 --spp 16 --exposure 0
done
# a scene with the basis of another one, and a file that is none
mkdir "$page/mixed"
cp "$page/scene/box.glb" "$page/mixed/hill.glb"
cp "$page/scene/hill.light.safetensors" "$page/mixed/"
cp "$page/scene/box.png" "$page/mixed/picture.glb"
# a mesh packed by Draco is written plain
"$program" bake "$source/tests/fuzz/seeds/packed.gltf" -o "$work/unpacked.glb" --to lightmap --map-size 128 --quality draft
node "$source/tests/web/validate.mjs" "$source/web" "$page"/scene/{box,hill,map,colored}.glb "$work/unpacked.glb"
# the exposure that is chosen for a picture of that box
"$program" render "$work/framed.glb" -o "$work/exposed.png" --mode operator --quality draft --max-elements 800 \
    --size 128x128 --spp 4 2>"$work/said"
stops=$(sed -n 's/.*exposure \([-+][0-9.]*\) stops.*/\1/p' "$work/said")
node "$source/tests/web/test_page.mjs" "$source/web" "$page" "$stops"
