#!/usr/bin/env bash
# Bakes of operator files: those of the scene that was solved, in its own file, which need not be there any more.
source "$(dirname "$0")/support.sh"

number() { sed -n "s/^[[:space:]]*\"$2\":[[:space:]]*\([^,]*\),\{0,1\}\$/\1/p" "$1" | head -n 1; }
few=(--quality draft --max-elements 300)
change() { python3 "$here/change_document.py" "$@" || complain "the document cannot be changed: $*"; }

# a file with separate buffers and images, lights that share a name or a definition, and a lamp that is one of two primitives
succeeds scene cornell-blocks -o plain.glb
python3 - <<'TEXT' || complain "the test file cannot be made"
import json, os, struct, zlib
raw = open("plain.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g, binary = json.loads(raw[20:20 + n]), raw[28 + n:]
os.mkdir("parts")
open("parts/box 1+1.bin", "wb").write(binary)
g["buffers"][0] = {"byteLength": len(binary), "uri": "parts/box%201%2B1.bin"}
def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
open("parts/red.png", "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", 1, 1, 8, 2, 0, 0, 0)) +
    chunk(b"IDAT", zlib.compress(b"\0\xa0\x10\x10")) + chunk(b"IEND", b""))
g["images"] = [{"uri": "parts/red.png", "name": "red"}]
g["textures"] = [{"source": 0}]
red = next(m for m in g["materials"] if m["name"] == "red")
red["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
# the lamp becomes a second primitive of the ceiling
mesh = {m["name"]: m for m in g["meshes"]}
mesh["ceiling"]["primitives"] += mesh["light"]["primitives"]
node = {m["name"]: m for m in g["nodes"]}
del node["light"]["mesh"]
g["nodes"][0]["extras"] = {"designer": "J. D\u00f6"}
g["extensionsUsed"].append("KHR_lights_punctual")
g["extensions"] = {"KHR_lights_punctual": {"lights": [
    {"type": "point", "intensity": 0.02, "color": [1, 0.9, 0.8]}, {"name": "torch", "type": "spot", "intensity": 0.1,
     "spot": {"outerConeAngle": 0.7}}]}}
for name, light, x in ("first", 0, -0.1), ("second", 0, -0.4), ("stand", 1, -0.3):
    g["nodes"].append({"name": name, "translation": [x, 0.4, -0.2], "rotation": [-0.7071068, 0, 0, 0.7071068],
                       "extensions": {"KHR_lights_punctual": {"light": light}}})
    g["scenes"][0]["nodes"].append(len(g["nodes"]) - 1)
json.dump(g, open("box.gltf", "w"))
TEXT
succeeds bake box.gltf -o scene.glb --to vertex "${few[@]}" --basis
succeeds bake box.gltf -o scene-map.glb --to lightmap --map-size 128 "${few[@]}" --operator
succeeds bake box.gltf -o scene.json --to probes --spacing 0.3 "${few[@]}"
succeeds solve box.gltf -o box.safetensors "${few[@]}"
mkdir away && mv box.gltf parts away
mkdir again
succeeds bake box.safetensors -o again/scene.glb --to vertex --basis
succeeds bake box.safetensors -o again/scene-map.glb --to lightmap --map-size 128 --operator
succeeds bake box.safetensors -o again/scene.json --to probes --spacing 0.3
for file in again/*; do
    cmp -s "$file" "${file#again/}" || complain "$file is not what is baked from the scene"
done
(($(ls again | wc -l) == 7)) || complain "there are other files than from the scene: $(ls again)"
succeeds bake box.safetensors -o "$out/none.glb" --to vertex --dry-run
[[ -z $(ls -A "$out") ]] || complain "a dry run wrote something"
refuses 1 'no rows to save' bake box.safetensors -o "$out/x.glb" --to vertex --checkpoint "$out/rows"
refuses 1 'its own environment' bake box.safetensors -o "$out/x.glb" --to vertex --env white
refuses 1 'would overwrite' bake box.safetensors -o scene.glb --to vertex --stats box.safetensors

# relit: the bake shows the new light, colours and positions; solving the baked file again gives the same scene
succeeds relight box.safetensors --light light=0.5,1,0.8,0.6 --albedo green=0.2,0.3,0.8 --move light=0.2,-0.05,0.1 \
    --light first=0.5 --move second=0.05,-0.1,0 --light torch=2,1,0.5,0.5 --add lantern=-0.2,0.3,0.1,0.05 -o relit.safetensors \
    -o relit.png --mode operator --size 64x64 --exposure 0
succeeds bake relit.safetensors -o "$out/none.glb" --to vertex --stats relit.json --dry-run
scale=$(number relit.json light_scale) # by which nothing is clipped
succeeds bake relit.safetensors -o relit.glb --to vertex --unlit --light-scale "$scale"
succeeds bake relit.safetensors -o relit-map.glb --to lightmap --map-size 128
succeeds info relit-map.glb
for line in 'green .*base color (0.2 0.3 0.8)' 'light .*emits (8.5 4.8 1.2)' 'first  point  W/sr (0.01 0.009 0.008)' \
    'second  point  W/sr (0.02 0.018 0.016)' 'torch .*spot  W/sr (0.2 0.1 0.1)' 'lantern  point  W/sr (0.05 0.05 0.05)'; do
    says "$line"
done
succeeds render relit-map.glb -o anew.png --mode operator --size 64x64 --quality draft --exposure 0
succeeds compare relit.png anew.png --json
awk -v r="$(number stdout mean_ratio)" 'BEGIN { exit !(r > 0.97 && r < 1.03) }' ||
    complain "the relit file, solved anew, is $(number stdout mean_ratio) times as bright"
exposure=$(awk -v s="$scale" 'BEGIN { print log(s) / log(2) }')
succeeds render relit.glb -o baked.png --exposure "$exposure" --size 64x64 --quality draft
succeeds compare relit.png baked.png --json
awk -v r="$(number stdout mean_ratio)" 'BEGIN { exit !(r > 0.97 && r < 1.03) }' ||
    complain "the relit file is $(number stdout mean_ratio) times as bright as the light in it"
python3 - <<'TEXT' || complain "what was not relit is not as it was"
import json, struct
before = json.load(open("away/box.gltf"))
raw = open("relit-map.glb", "rb").read()
after = json.loads(raw[20:20 + struct.unpack("<I", raw[12:16])[0]])
named = lambda g, kind, name: next(x for x in g[kind] if x.get("name") == name)
for name in "white", "red":
    a, b = named(before, "materials", name), named(after, "materials", name)
    b["extensions"].pop("MOZ_lightmap")
    assert a == {k: v for k, v in b.items() if v != {}}, (a, b)
assert after["nodes"][0] == before["nodes"][0] and after["images"][0]["name"] == "red"
assert all(a == b for a, b in zip(before["nodes"], after["nodes"]) if a["name"] not in ("first", "second", "stand"))
roots = after["scenes"][0]["nodes"]
moved = [n for k, n in enumerate(after["nodes"]) if k >= len(before["nodes"])]
assert sorted(n["name"] for n in moved) == ["ceiling", "lantern", "second"], moved
assert all(k in roots for k in range(len(before["nodes"]), len(after["nodes"])))
assert "extensions" not in named(after, "nodes", "second")
TEXT

# files without a document, and scenes without a file, are written as they are
succeeds solve cornell-blocks -o built.safetensors "${few[@]}"
succeeds bake cornell-blocks -o built.glb --to vertex "${few[@]}"
succeeds bake built.safetensors -o again/built.glb --to vertex
cmp -s built.glb again/built.glb || complain "a built-in scene is baked otherwise from its operator file"
succeeds solve plain.glb -o left-out.safetensors "${few[@]}" --no-document
! grep -qa document.glb left-out.safetensors || complain "a document that is to be left out is in the file"
succeeds bake left-out.safetensors -o left-out.glb --to vertex
change without box.safetensors old.safetensors
succeeds bake old.safetensors -o old.glb --to vertex
warns 'textures and vertex colours are not written'
[[ -z $(ls | grep '\.glb\..*\|[0-9]\.glb$') ]] || complain "files are left behind: $(ls)"

# attributes of a mesh's own that have fewer values than it has vertices were read beyond their end
python3 - <<'TEXT' || complain "no attribute can be added"
import json, struct
raw = open("plain.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g, binary = json.loads(raw[20:20 + n]), raw[28 + n:]
g["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": 8})
g["accessors"].append({"bufferView": len(g["bufferViews"]) - 1, "componentType": 5126, "count": 1, "type": "VEC2"})
g["meshes"][0]["primitives"][0]["attributes"]["_HEAT"] = len(g["accessors"]) - 1
binary += bytes(8)
g["buffers"][0] = {"byteLength": len(binary), "uri": "heat.bin"}
open("heat.bin", "wb").write(binary)
json.dump(g, open("heat.gltf", "w"))
TEXT
refuses 1 'holds 1 values for' bake heat.gltf -o "$out/x.glb" --to lightmap --map-size 64 "${few[@]}"

# documents that are damaged, or belong to another scene
succeeds solve plain.glb -o plain.safetensors "${few[@]}"
for case in 'cut:cut off' 'text:damaged' 'no-buffers:damaged' 'cycle:two parents\|reached twice' 'odd-mesh:does not exist' 'rename:another scene' \
    'far-triangle:another scene' 'far-instance:another scene' 'twice:another scene' 'half:is missing' 'far-view:.'; do
    change "${case%%:*}" box.safetensors bad.safetensors
    refuses 1 "${case#*:}" bake bad.safetensors -o "$out/x.glb" --to vertex
    refuses 1 "${case#*:}" bake bad.safetensors -o "$out/x.glb" --to lightmap --map-size 64
done
change other box.safetensors bad.safetensors plain.safetensors
refuses 1 'another scene' bake bad.safetensors -o "$out/x.glb" --to vertex
change cut box.safetensors bad.safetensors
succeeds probe bad.safetensors --points <(printf 'x,y,z,nx,ny,nz\n-0.2,0.3,-0.2,0,0,1\n') -o readings.csv
finish
