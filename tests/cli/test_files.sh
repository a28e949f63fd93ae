# Files as people have them: units of light, exposure.
source "$(dirname "$0")/support.sh"
tiny=(--size 32x24 --quality draft --spp 4)

# ---- units ----
succeeds scene cornell-blocks -o box.glb
succeeds info box.glb --light-units photometric --json
grep -q 'emission' stdout || complain "info names no emission"
refuses 2 'one of auto, watt, photometric' render box.glb -o "$out/a.png" --light-units lumen
succeeds solve box.glb -o box.safetensors --quality draft
refuses 1 'light-units' render box.safetensors -o "$out/a.png" "${tiny[@]}" --light-units watt
succeeds render furnace -o "$out/a.png" "${tiny[@]}" --light-units watt
warns 'light-units has no effect'
rm "$out"/*

# ---- sides ----
# a triangle (-4 -4 0) (0 4 0) (4 -4 0), which the camera at z = 3 sees from behind
zero='\0\0\0\0' plus='\0\0\200\100' minus='\0\0\200\300'
printf "$minus$minus$zero$zero$plus$zero$plus$minus$zero" >back.bin
cat >back.gltf <<'TEXT'
{ "asset": { "version": "2.0" }, "buffers": [{ "uri": "back.bin", "byteLength": 36 }],
  "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
  "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
  "materials": [{ "name": "wall" }], "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
  "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }],
  "nodes": [{ "mesh": 0 }, { "camera": 0, "translation": [0, 0, 3] }] }
TEXT
for mode in reference final operator; do
    succeeds render back.gltf -o back.exr --env white --size 16x16 --quality draft --mode $mode
    warns "single-sided surfaces from behind.*'wall'.*--two-sided"
    succeeds render back.gltf -o front.exr --env white --size 16x16 --quality draft --mode $mode --two-sided
    grep -q 'behind' stderr && complain "what is shown from both sides has backs"
done
refuses 1 'two-sided' render box.safetensors -o "$out/a.png" "${tiny[@]}" --two-sided
refuses 2 'one of file, both' render box.glb -o "$out/a.png" --emit front
succeeds info back.gltf --two-sided
says 'wall .*double-sided'

# ---- exposure ----
exposure() { sed -n 's/.*"exposure":[[:space:]]*\([-0-9.]*\).*/\1/p' "$1"; }
ratio() { succeeds compare "$1" "$2" --json && sed -n 's/.*"mean_ratio":[[:space:]]*\([-0-9.e]*\).*/\1/p' stdout; }
within() { awk -v x="$1" -v low="$2" -v high="$3" 'BEGIN { exit !(x >= low && x <= high) }' || complain "$4: $1 is not within $2 .. $3"; }

succeeds render box.glb -o plain.png -o plain.exr "${tiny[@]}" --exposure 0 --stats plain.json
grep -q 'note: exposure' stderr && complain "an exposure that was asked for is said to be chosen"
[[ $(exposure plain.json) == 0 ]] || complain "the statistics do not say the exposure"
succeeds render box.glb -o own.png -o own.exr "${tiny[@]}" --stats own.json
warns 'note: exposure'
cmp -s plain.exr own.exr || complain "the exposure changes what is linear"
# the same box, 683 times as dark
succeeds render box.glb -o dim.png -o dim.exr "${tiny[@]}" --light-units photometric --stats dim.json
within "$(ratio plain.exr dim.exr)" 0.0014 0.0015 "683 lm/W"
more=$(awk -v a="$(exposure own.json)" -v b="$(exposure dim.json)" 'BEGIN { print b - a }')
within "$more" 9.3 9.5 "stops more for a scene 683 times as dark"
within "$(ratio own.png dim.png)" 0.5 2 "a dim scene, as it is shown"
succeeds render box.glb -o again.png "${tiny[@]}" --light-units photometric --exposure "$(exposure dim.json)"
cmp -s dim.png again.png || complain "the exposure that is said gives another picture"
succeeds render cornell-blocks -o built.png "${tiny[@]}" --stats built.json
[[ $(exposure built.json) == 0 ]] || complain "a built-in scene is exposed anew"
grep -q 'note: exposure' stderr && complain "the exposure of a built-in scene is chosen"
succeeds render box.glb -o only.exr "${tiny[@]}" --stats only.json
grep -q '"exposure":[[:space:]]*null' only.json || complain "a picture without .png has an exposure"

# one for all frames, and for changed lights: that of the light as it was solved
succeeds solve box.glb -o dim.safetensors --quality draft --light-units photometric
printf '0 light.light=1\n2 light.light=0.01\n' >fade.txt
succeeds relight dim.safetensors --script fade.txt -o f%d.png --mode operator "${tiny[@]:0:2}" --stats fade.json
within "$(exposure fade.json)" "$(exposure dim.json | awk '{ print $1 - 0.3 }')" "$(exposure dim.json | awk '{ print $1 + 0.3 }')" "exposure of frames"
within "$(ratio f0.png f2.png)" 0 0.1 "a light that fades"
succeeds relight dim.safetensors --light light=0.01 -o single.png --mode operator "${tiny[@]:0:2}"
cmp -s f2.png single.png || complain "a frame and the same picture alone are exposed differently"
# the operator of a built-in scene knows that it is one, even relit
succeeds solve cornell-blocks -o built.safetensors --quality draft
succeeds relight built.safetensors --light light=0.01 -o relit.safetensors -o relit.png --mode operator "${tiny[@]:0:2}"
grep -q 'note: exposure' stderr && complain "a built-in scene that was solved is exposed anew"
succeeds render relit.safetensors -o relit2.png "${tiny[@]:0:2}"
grep -q 'note: exposure' stderr && complain "a built-in scene that was relit is exposed anew"

# the window
printf '0 show hud\n0 show markers\n' >bare.txt
view=(view dim.safetensors --script bare.txt --frames 1 --size 32x24)
succeeds "${view[@]}" --record frames
warns 'note: exposure'
within "$(ratio f0.png frames/frame-0000.png)" 0.4 2.5 "a frame of the window"
succeeds "${view[@]}" --record dark --exposure 0
within "$(ratio frames/frame-0000.png dark/frame-0000.png)" 0 0.3 "a frame at exposure 0"

# ---- films ----
for mode in reference final operator; do
    succeeds render cornell-blocks -o around.exr --projection equirectangular --mode $mode --size 32x16 --quality draft --spp 4
    succeeds render cornell-blocks -o circle.exr --projection fisheye --mode $mode --size 16x16 --quality draft --spp 4
    succeeds render cornell-blocks -o soft.exr --fstop 0.5 --focus 1 --mode $mode --size 16x16 --quality draft --spp 4
done
succeeds render cornell-blocks -o around.exr --projection equirectangular --quality draft --spp 1
succeeds render cornell-blocks -o twice.exr --projection equirectangular --size 512x256 --quality draft --spp 1
cmp -s around.exr twice.exr || complain "a picture of all directions is not twice as wide as high"
refuses 2 'number from' render cornell-blocks -o "$out/a.png" --fstop 0
refuses 2 'requires --fstop' render cornell-blocks -o "$out/a.png" --focus 2
refuses 1 '--fstop is not supported' render cornell-blocks -o "$out/a.png" --fstop 2 --projection fisheye
refuses 1 'pinhole' render cornell-blocks -o "$out/a.png" --fstop 2 --mode occlusion
refuses 2 'one of perspective, equirectangular, fisheye' render cornell-blocks -o "$out/a.png" --projection flat

# ---- contents of files, and errors in them ----
succeeds info back.gltf --check
says 'likely mistakes: 2'
says "there is no light"
says "single-sided surfaces (mostly 'wall'"
succeeds info back.gltf --check --json
grep -q '"kind":[[:space:]]*"no_light"' stdout || complain "the findings lack no_light"
grep -q '"kind":[[:space:]]*"backs"' stdout || complain "the findings lack backs"
grep -q '"notes"' stdout || complain "the findings lack the notes"
succeeds info back.gltf --json
grep -q '"mistakes"' stdout && complain "mistakes are looked for unasked"
succeeds info "$here/../fuzz/seeds/meshopt.gltf"
says '^    emission: .*1 x 1\|^    emission: .*[0-9] x [0-9]'

# ---- packed meshes ----
# seeds of the fuzzer: a square twice, all metal, packed by meshopt, textured by WebP
sed 's/"materials":\[{/&"pbrMetallicRoughness":{"metallicFactor":0},/' "$here/../fuzz/seeds/meshopt.gltf" >packed.gltf
for target in vertex "lightmap --map-size 64"; do
    # shellcheck disable=SC2086 # several words each
    succeeds bake packed.gltf -o plain.glb --to $target --quality draft --max-elements 100 --env white
    grep -a -q 'EXT_meshopt_compression' plain.glb && complain "a baked file names the compression that it has lost"
    succeeds info packed.gltf --json
    sed -n '/"bounds/,/]/p' stdout >packed.bounds
    succeeds info plain.glb --json
    sed -n '/"bounds/,/]/p' stdout | cmp -s - packed.bounds || complain "what was packed comes out elsewhere"
done
finish
