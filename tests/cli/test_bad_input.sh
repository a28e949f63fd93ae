#!/usr/bin/env bash
# Every faulty file gives one clear line and exit status 1, and leaves no file behind.
source "$(dirname "$0")/support.sh"

picture=(-o "$out/a.png" "${small[@]}")

# -- files that are not there, or cannot be

refuses 1 'no such file' render missing.glb "${picture[@]}"
refuses 1 'no such file' info missing.glb
refuses 1 'no/such/folder' render furnace -o no/such/folder/a.png "${small[@]}"
refuses 1 'extension\|end in' render furnace -o "$out" "${small[@]}"
refuses 1 'a.tiff' render furnace -o "$out/a.tiff" "${small[@]}"
refuses 1 'folder' render furnace "${picture[@]}" --stats no/such/folder/a.json
refuses 1 'is a folder' render furnace "${picture[@]}" --stats "$out"
refuses 1 'folder' scene furnace -o no/such/folder/a.glb
refuses 1 'gloss reused' render furnace "${picture[@]}" --gloss reused
refuses 1 'gloss reused' render furnace "${picture[@]}" --gloss reused --mode operator --layers
refuses 1 'gallows' scene gallows -o "$out/a.glb"
refuses 1 'camera.*nobody' render furnace "${picture[@]}" --camera nobody
CUDA_VISIBLE_DEVICES= refuses 1 'error: device: ' render furnace "${picture[@]}" --device cuda
refuses 1 'sky.hdr' render furnace "${picture[@]}" --env sky.hdr
refuses 1 'missing.exr' compare missing.exr missing.exr

# -- fog

for fog in -1 inf nan 1e9 1,2 1,-0.1 1,1,1 1,1,-1 1,1,nan 1:2 x 1,1,0,0 1,; do
    refuses 1 'fog' render furnace "${picture[@]}" --mode reference "--fog=$fog"
done
for height in 0 -1 x 1,nan 1,2,3; do
    refuses 1 'height' render furnace "${picture[@]}" --mode reference --fog 1 "--fog-height=$height"
done
refuses 2 'requires --fog' render furnace "${picture[@]}" --mode reference --fog-height 1
printf '0.5,0.5,0.5,0,1,0\n' >middle.csv
refuses 1 'fog: .*leave it out' render furnace "${picture[@]}" --mode occlusion --fog 1
refuses 1 'planned picture only supports fog in a finite box' render furnace -o "$out/a.png" --size 32x24 --error 10% --fog 1 --fog-height 2
refuses 1 'lower the albedo of the fog' solve furnace -o "$out/a.safetensors" --quality draft --fog 1000
for boundless in "render furnace ${picture[*]}" "render furnace ${picture[*]} --mode operator" \
    "probe furnace --points middle.csv -o $out/a.csv"; do
    refuses 1 'fog: .*mode reference' $boundless --fog 1 --fog-height 2
done
refuses 2 'not an option' certify furnace --fog 1 --fog-height 2
succeeds render furnace -o fog.png "${small[@]}" --quality draft --fog 1,0.5,0.2
succeeds probe furnace --points middle.csv -o fog.csv --quality draft --fog 1,0.5
succeeds probe furnace --points middle.csv -o fog.csv --mode reference --samples 32 --fog 1:2:3,0.5,-0.2 --fog-height 1,0.2
succeeds info furnace --fog 1
says 'fog'

refuses 1 'gather' render furnace "${picture[@]}" --spp 65536 --gather 65536

# -- broken glTF

succeeds scene cornell-blocks -o box.glb
for bytes in 0 3 11 12 19 200 $(($(stat -c %s box.glb) - 1)); do
    head -c "$bytes" box.glb >cut.glb
    refuses 1 'cut.glb' render cut.glb "${picture[@]}"
done
echo '{ "asset": { "version": ' >cut.gltf
refuses 1 'cut.gltf' render cut.gltf "${picture[@]}"
head -c 4000 /dev/zero >zero.glb
refuses 1 'zero.glb' render zero.glb "${picture[@]}"

# gltf POSITIONS [ACCESSOR_COUNT [MATERIAL [EXTRA]]]: one triangle of nine floats, given in hexadecimal
gltf() {
    local bytes
    bytes=$(printf '%s' "$1" | sed 's/../\\x&/g')
    cat <<TEXT
{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [ { "nodes": [ 0 ] } ], "nodes": [ { "mesh": 0 } ],
  "meshes": [ { "name": "shard", "primitives": [ { "attributes": { "POSITION": 0 }, "material": 0 } ] } ],
  "materials": [ ${3:-{ \"name\": \"chalk\" \}} ],
  "accessors": [ { "bufferView": 0, "componentType": 5126, "count": ${2:-3}, "type": "VEC3",
                   "min": [ 0, 0, 0 ], "max": [ 1, 1, 1 ] } ],
  "bufferViews": [ { "buffer": 0, "byteLength": 36 } ],
  "buffers": [ { "byteLength": 36, "uri": "data:application/octet-stream;base64,$(printf "$bytes" | base64 -w 0)" } ] }
TEXT
}
zero=00000000 one=0000803f nan=0000c07f infinity=0000807f
triangle=$zero$zero$zero$one$zero$zero$zero$one$zero
gltf ${nan}${triangle:8} >nan.gltf
refuses 1 'nan.gltf' render nan.gltf "${picture[@]}"
gltf ${infinity}${triangle:8} >infinity.gltf
refuses 1 'infinity.gltf' render infinity.gltf "${picture[@]}"
gltf $triangle 300 >outside.gltf
refuses 1 'outside.gltf' render outside.gltf "${picture[@]}"
gltf $zero$zero$zero$zero$zero$zero$zero$zero$zero >point.gltf
refuses 1 'nothing\|triangle' render point.gltf "${picture[@]}"
echo '{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [ { "nodes": [ 0 ] } ], "nodes": [ { } ] }' >empty.gltf
refuses 1 'nothing\|mesh' render empty.gltf "${picture[@]}"

gltf $triangle | sed 's/"scene": 0/"extensionsRequired": [ "ACME_magic" ], &/' >magic.gltf
refuses 1 'magic.gltf.*ACME_magic' render magic.gltf "${picture[@]}"
gltf $triangle | sed 's/{ "mesh": 0 }/{ "name": "dot", "mesh": 0, "scale": [ 0, 0, 0 ] }/' >dot.gltf
refuses 1 'dot.gltf.*triangle' render dot.gltf "${picture[@]}"
warns 'dot.*scale'
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 5 +X 7\n\x80\x80\x80\x81' >cut.hdr
refuses 1 'cut.hdr' render furnace "${picture[@]}" --env cut.hdr

# -- other formats

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n' >outside.obj
refuses 1 'outside.obj' render outside.obj "${picture[@]}"
printf 'ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nend_header\n0\n' >cut.ply
refuses 1 'cut.ply.*cut off' info cut.ply
for kind in obj ply fbx dae stl; do
    : >void.$kind
    refuses 1 "void.$kind" info void.$kind
done
mkfifo pipe.obj
refuses 1 'regular file' info pipe.obj
echo hello >hello.txt
refuses 1 'hello.txt.*\.obj' info hello.txt

# -- poor but usable files: a picture, and a warning about what is missing

gltf $triangle >dark.gltf
succeeds render dark.gltf "${picture[@]}"
warns 'light'
warns 'framing'
[[ -s $out/a.png ]] || complain "no picture of a dark scene"
rm -f "$out"/*
gltf $triangle 3 '{ "name": "snow", "pbrMetallicRoughness": { "baseColorFactor": [ 1, 1, 1, 1 ], "metallicFactor": 0 },
    "emissiveFactor": [ 1, 1, 1 ] }' >white.gltf
succeeds render white.gltf "${picture[@]}"
gltf $triangle 3 '{ "name": "fog", "extensions": { "KHR_materials_ior": { "ior": 0.5 } } }' >thin.gltf
printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x81' >one.hdr
succeeds render thin.gltf "${picture[@]}" --env one.hdr
warns 'fog.*ior'
rm -f "$out"/*
lights='"extensions": { "KHR_lights_punctual": { "lights": [ { "type": "spot", "spot": { "outerConeAngle": 0 } } ] } }'
gltf $triangle | sed "s/\"scene\": 0/$lights, &/
    s/{ \"mesh\": 0 }/{ \"mesh\": 0, \"extensions\": { \"KHR_lights_punctual\": { \"light\": 0 } } }/" >needle.gltf
succeeds render needle.gltf "${picture[@]}"
rm -f "$out"/*
finish
