#!/usr/bin/env bash
# Measured luminaires in scenes: by --luminaire at lights, nodes and objects, by EXT_lights_ies, dimmed, aimed and baked.
source "$(dirname "$0")/support.sh"

# I = 683 cd straight down, falling as the cosine: 1 W/sr
python3 - >lamp.ies <<'PYTHON'
from math import cos, radians
print("IESNA:LM-63-2002\n[LUMINAIRE] cosine\nTILT=NONE\n1 -1 1 91 1 1 2 0 0 0\n1 1 10")
print(*range(91))
print(0)
print(*["%.6f" % (683 * cos(radians(k))) for k in range(91)])
PYTHON
mkdir -p profiles && cp lamp.ies profiles/lamp.ies
# A floor, an empty node 2 m above it, a point light next to that, and a luminaire of the extension that points down.
python3 - <<'PYTHON'
import json, struct
from base64 import b64encode
data = struct.pack("<12f6H", -2, 0, -2, -2, 0, 2, 2, 0, 2, 2, 0, -2, 0, 1, 2, 0, 2, 3)
scene = {
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2, 3]}],
    "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64," + b64encode(data).decode()}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-2, 0, -2], "max": [2, 0, 2]},
                  {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
    "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
    "nodes": [{"mesh": 0, "name": "floor"}, {"name": "hook", "translation": [0, 2, 0]},
              {"name": "bulb", "translation": [0, 2, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"name": "measured", "translation": [0, 2, 0], "rotation": [-0.70710678, 0, 0, 0.70710678],
               "extensions": {"EXT_lights_ies": {"light": 0, "multiplier": 2, "color": [1, 1, 1]}}}],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "name": "bulb", "intensity": 0}]},
                   "EXT_lights_ies": {"lights": [{"uri": "profiles/lamp.ies"}]}},
    "extensionsUsed": ["KHR_lights_punctual", "EXT_lights_ies"]}
json.dump(scene, open("room.gltf", "w"))
scene["extensions"]["EXT_lights_ies"]["lights"][0]["uri"] = "profiles/none.ies"
json.dump(scene, open("torn.gltf", "w"))
PYTHON
printf '0,0,0,0,1,0\n' >below.csv
draft=(--quality draft --threads 2)
# lux_of EXPECTED ARGUMENTS... : the reading 2 m below
lux_of() {
    local expected=$1
    shift
    succeeds probe "$@" --points below.csv -o "$out/lux.csv" --photometric --mode lookup --threads 2
    awk -F, -v wanted="$expected" 'NR > 1 && ($7 < 0.98 * wanted || $7 > 1.02 * wanted) { print $7; exit 1 }' \
        "$out/lux.csv" >log || complain "$(cat log) lux instead of $expected: $*"
    rm -f "$out"/*
}
lux_of 341.5 room.gltf --quality draft
lux_of 512.2 room.gltf --quality draft --luminaire hook=lamp.ies
lux_of 512.2 room.gltf --quality draft --luminaire 'bul*=lamp.ies'
lux_of 683 room.gltf --quality draft --luminaire hook=lamp.ies --luminaire bulb=lamp.ies
lux_of 170.8 torn.gltf --quality draft --luminaire hook=lamp.ies
"$program" info torn.gltf >/dev/null 2>log
grep -q "none.ies" log || complain "a luminaire that is missing is named"
"$program" info room.gltf >log || complain "lights are listed"
grep -q "luminaire .*'cosine', 4291 lm" log || complain "lumens: $(cat log)"

# dimmed and aimed, in operator files and bakes
succeeds solve room.gltf -o room.safetensors "${draft[@]}" --luminaire hook=lamp.ies
succeeds relight room.safetensors --light measured=0.25 --light hook=0 -o half.safetensors --threads 2
lux_of 85.4 half.safetensors
succeeds relight room.safetensors --light hook=0 --aim measured=1,-1,0 -o aimed.safetensors --threads 2
lux_of 241.5 aimed.safetensors
for file in room half aimed; do
    succeeds bake $file.safetensors -o $file-baked.glb --to vertex --threads 2
done
lux_of 512.2 room-baked.glb --quality draft
lux_of 85.4 half-baked.glb --quality draft
lux_of 241.5 aimed-baked.glb --quality draft
# half of what two luminaires give straight below, and more than they can give
printf 'x,y,z,nx,ny,nz,lux\n0,0.5,0,0,1,0,455.3\n0.5,0.5,0.5,0,1,0,300\n' >wanted.csv
succeeds fit room.safetensors --wanted wanted.csv -o factors.csv --readings readings.csv --relit fitted.safetensors --threads 2
says 'KKT residual'
[[ $(head -n 1 factors.csv) == name,r,g,b,lumens && $(wc -l <factors.csv) -ge 3 ]] || complain "factors: $(cat factors.csv)"
printf '0,0.5,0,0,1,0\n' >half.csv
succeeds probe fitted.safetensors --points half.csv -o fitted.csv --photometric --threads 2
paste -d, <(sed -n 2p readings.csv) <(sed -n 2p fitted.csv) |
    awk -F, '{ exit !($8 > 0.995 * $15 && $8 < 1.005 * $15) }' || complain "a forward check: $(cat readings.csv fitted.csv)"
printf 'x,y,z,nx,ny,nz,r,g,b,weight\n0,0.5,0,0,1,0,0.3,0.2,0.1,1\n' >colors.csv
succeeds fit room.safetensors --wanted colors.csv -o factors.csv --keep hook --at-least --most 2 --threads 2
succeeds fit room.safetensors --wanted <(printf 'x,y,z,nx,ny,nz,lux\n0,0.5,0,0,1,0,1e6\n') -o factors.csv --threads 2
says 'most by .* lux at (0 0.5 0)'
refuses 1 'no target readings' fit room.safetensors --wanted below.csv -o "$out/f.csv"
refuses 1 'lux is not a finite number' fit room.safetensors --wanted <(printf 'x,y,z,nx,ny,nz,lux\n0,0,0,0,1,0,much\n') -o "$out/f.csv"
refuses 2 'above --most' fit room.safetensors --wanted wanted.csv -o "$out/f.csv" --least 2
refuses 1 "no light 'moon'" fit room.safetensors --wanted wanted.csv -o "$out/f.csv" --keep moon
# UGR of an observer before surroundings of 683 cd/m2: a panel that hangs, and one behind the eye
sed 's/^1 -1 1 91 1 1 2 .*/1 -1 1 91 1 1 2 0.6 0.6 0/' lamp.ies >panel.ies
python3 - <<'PYTHON'
import json
scene = json.load(open("room.gltf"))
del scene["extensions"], scene["extensionsUsed"]
scene["scenes"][0]["nodes"] = [0, 1, 2]
scene["nodes"] = [{"mesh": 0, "translation": [0, -500, 0]}, {"name": "hook", "translation": [0.5, 1.5, -3]},
                  {"name": "behind", "translation": [0.5, 1.5, 3]}]
json.dump(scene, open("open.gltf", "w"))
PYTHON
printf '0,0,0,0,0,-1\n' >eye.csv
succeeds glare open.gltf --observers eye.csv -o ugr.csv --env white "${draft[@]}" --luminaire hook=panel.ies \
    --luminaire behind=panel.ies
python3 - <<'PYTHON' || complain "UGR: $(cat ugr.csv)"
from math import *
x, y, z = 0.5, 1.5, 3
r2 = x * x + y * y + z * z
cosine = y / sqrt(r2)
tau, sigma = degrees(acos(y / hypot(x, y))), degrees(acos(z / sqrt(r2)))
P = exp((35.2 - 0.31889 * tau - 1.22 * exp(-2 * tau / 9)) * 1e-3 * sigma +
        (21 + 0.26667 * tau - 0.002963 * tau ** 2) * 1e-5 * sigma ** 2)
L, w = 683 / 0.36, 0.36 * cosine / r2
ugr = 8 * log10(0.25 / 683 * L * L * w / P ** 2)
found = open("ugr.csv").read().split("\n")[1].split(",")
assert found[9] == "1" and abs(float(found[6]) - ugr) < 0.02, (found, ugr)
assert abs(float(found[7]) / 683 - 1) < 0.01, found
PYTHON
refuses 2 'OUT.csv is missing' glare open.gltf --observers eye.csv
refuses 1 'cannot be turned' relight room.safetensors --aim bulb=0,0,0 -o "$out/a.png"
refuses 1 "there is no light or object named 'lamp'" render room.gltf -o "$out/a.png" --luminaire lamp=lamp.ies
refuses 1 'NAME=FILE' render room.gltf -o "$out/a.png" --luminaire lamp
refuses 1 'is it really IES LM-63' render room.gltf -o "$out/a.png" --luminaire hook=below.csv
refuses 1 'luminaire' render room.safetensors -o "$out/a.png" --luminaire hook=lamp.ies
finish
