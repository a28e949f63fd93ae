#!/usr/bin/env bash
# Baked files: they show what `render` shows, and keep everything else of the original file.
source "$(dirname "$0")/support.sh"

number() { sed -n "s/^[[:space:]]*\"$2\":[[:space:]]*\([^,]*\),\{0,1\}\$/\1/p" "$1" | head -n 1; }

# an unlit file read back shows base colour times COLOR_0: the solved light over its scale
succeeds bake cornell-blocks -o box.glb --to vertex --unlit --basis --quality draft --max-elements 1500 --stats box.json
exposure=$(awk -v s="$(number box.json light_scale)" 'BEGIN { print log(s) / log(2) }')
succeeds render box.glb -o baked.png --exposure "$exposure" --size 96x96 --spp 16 --quality draft
succeeds render cornell-blocks -o own.png --mode operator --size 96x96 --spp 16 --quality draft --max-elements 1500
succeeds compare own.png baked.png --json
ratio=$(number stdout mean_ratio)
awk -v r="$ratio" 'BEGIN { exit !(r > 0.98 && r < 1.02) }' || complain "the baked box is $ratio times as bright"
[[ -s box.light.safetensors ]] || complain "no basis was written"

# animations, extras and extensions that nobody knows come out as they went in
succeeds scene cornell-blocks -o plain.glb
python3 - <<'TEXT' || complain "the test file cannot be made"
import json, struct
raw = open("plain.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g, binary = json.loads(raw[20:20 + n]), raw[28 + n:]
times = len(binary)
binary += struct.pack("<8f", 0, 1, 0, 0, 0, 0, 1, 0)
g["buffers"][0] = {"byteLength": len(binary), "uri": "kept.bin", "name": "all"}
g["bufferViews"] += [{"buffer": 0, "byteOffset": times, "byteLength": 8}, {"buffer": 0, "byteOffset": times + 8, "byteLength": 24}]
v, a = len(g["bufferViews"]), len(g["accessors"])
g["accessors"] += [{"bufferView": v - 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
                   {"bufferView": v - 1, "componentType": 5126, "count": 2, "type": "VEC3"}]
g["animations"] = [{"name": "rise", "samplers": [{"input": a, "output": a + 1}],
                    "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}]
g["extensionsUsed"].append("ACME_unknown")
g["extensions"] = {**g.get("extensions", {}), "ACME_unknown": {"answer": 42.125, "list": [1, {"deep": None}, 0.6157673895359039]}}
g["nodes"][0]["extras"] = {"designer": "J. D\u00f6", "tags": ["a", "b"]}
g["materials"][0]["extras"] = {"price": 1e-7}
g["scenes"][0]["name"] = "room"
g["asset"]["extras"] = {"licence": "CC0"}
g["extensions"]["KHR_xmp_json_ld"] = {"packets": [{"@context": {}, "dc:title": "box"}]}
open("kept.bin", "wb").write(binary)
json.dump(g, open("kept.gltf", "w"))
TEXT
succeeds bake kept.gltf -o "$out/kept.glb" --to vertex --quality draft --max-elements 300 --tolerance 20%
python3 - "$out/kept.glb" <<'TEXT' || complain "something of the file was lost"
import json, struct, sys
before = json.load(open("kept.gltf"))
raw = open(sys.argv[1], "rb").read()
after = json.loads(raw[20:20 + struct.unpack("<I", raw[12:16])[0]])
for key in "animations", "nodes", "scenes", "materials", "cameras", "extensions", "extensionsUsed":
    assert before.get(key) == after.get(key), key
assert after["asset"]["extras"]["licence"] == "CC0"
old = len(before["accessors"])
assert before["accessors"] == after["accessors"][:old]
assert before["asset"]["version"] == after["asset"]["version"]
assert after["buffers"][0]["name"] == "all" and "uri" not in after["buffers"][0]
TEXT
rm -f "$out"/*
# the metadata of the file is copied to its probes
succeeds bake kept.gltf -o kept.json --to probes --quality draft --max-elements 300 --spacing 1
python3 - <<'TEXT' || complain "probes lost the metadata of the file"
import json
before, after = json.load(open("kept.gltf")), json.load(open("kept.json"))
assert after["asset"] == before["asset"]
assert after["KHR_xmp_json_ld"] == before["extensions"]["KHR_xmp_json_ld"]
TEXT

# original vertex colours are kept, with alpha. Primitives with baked light are marked; those with their own colours are not
python3 "$here/change_box.py" colored plain.glb colored.glb || complain "the box cannot be coloured"
succeeds bake colored.glb -o colors.glb --to vertex --quality draft --max-elements 300 --tolerance 20%
python3 - "$here" <<'TEXT' || complain "colours of vertices, or marks of what is lit, are lost"
import json, struct, sys
sys.dont_write_bytecode = True
sys.path.append(sys.argv[1])
from change_box import color, read_floats
raw = open("colors.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g, binary = json.loads(raw[20:20 + n]), raw[28 + n:]
first = 0
for mesh in g["meshes"]:
    p, = mesh["primitives"]
    metal = mesh["name"] == "metal"
    assert p.get("extras", {}).get("resolvent_first_receiver") == (None if metal else first), mesh["name"]
    assert ("_COLOR" in p["attributes"]) != metal
    if metal: continue
    a = g["accessors"][p["attributes"]["POSITION"]]
    first += a["count"]
    assert all(g["accessors"][p["attributes"][name]]["type"] == "VEC4" for name in ("COLOR_0", "_COLOR"))
    places = read_floats(g, binary, p["attributes"]["POSITION"], 3)
    own = read_floats(g, binary, p["attributes"]["_COLOR"], 4)
    lit = read_floats(g, binary, p["attributes"]["COLOR_0"], 4)
    for place, a_color, light in zip(places, own, lit):
        had = color(place, a["min"], a["max"])
        assert all(abs(x - y) < 0.003 for x, y in zip(a_color, had)), (a_color, had)
        assert light[3] == a_color[3] and all(x <= y for x, y in zip(light, a_color))
TEXT
# when a primitive is metal in the next bake, its mark is removed
python3 - <<'TEXT' || complain "the floor cannot become metal"
import json, struct
raw = open("colors.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g = json.loads(raw[20:20 + n])
next(m for m in g["meshes"] if m["name"] == "floor")["primitives"][0]["material"] = len(g["materials"]) - 1
open("metal.glb", "wb").write(raw[:20] + json.dumps(g, separators=(",", ":")).encode().ljust(n) + raw[20 + n:])
TEXT
succeeds bake metal.glb -o metals.glb --to vertex --quality draft --max-elements 300 --tolerance 20%
(($(grep -ao resolvent_first_receiver colors.glb | wc -l) == 8)) || complain "not all that is lit is marked"
(($(grep -ao resolvent_first_receiver metals.glb | wc -l) == 7)) || complain "what carries light no more is marked"

succeeds bake plain.glb -o "$out/none.glb" --to vertex --quality draft --max-elements 300 --tolerance 20% --dry-run
says '^vertices '
[[ -z $(ls -A "$out") ]] || complain "a dry run wrote something"
# a box whose walls were modelled inside out, of double-sided materials, shows the light within all the same
python3 - <<'TEXT' || complain "the box cannot be turned inside out"
import json, struct
raw = open("plain.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g, binary = json.loads(raw[20:20 + n]), bytearray(raw[28 + n:])
for mesh in g["meshes"]:
    for p in mesh["primitives"]:
        material = g["materials"][p["material"]]
        if material.get("emissiveFactor"): continue
        material["doubleSided"] = True
        a = g["accessors"][p["indices"]]
        at = g["bufferViews"][a["bufferView"]].get("byteOffset", 0) + a.get("byteOffset", 0)
        kind = f"<{a['count']}{ {5121: 'B', 5123: 'H', 5125: 'I'}[a['componentType']] }"
        v = struct.unpack_from(kind, binary, at)
        struct.pack_into(kind, binary, at, *[v[k + (0, 2, 1)[c]] for k in range(0, len(v), 3) for c in range(3)])
        del p["attributes"]["NORMAL"]
g["buffers"][0] = {"byteLength": len(binary), "uri": "turned.bin"}
open("turned.bin", "wb").write(binary)
json.dump(g, open("turned.gltf", "w"))
TEXT
succeeds bake turned.gltf -o turned.glb --to vertex --quality draft --max-elements 1500
python3 - <<'TEXT' || complain "a box turned inside out is dark"
import json, struct
def mean(path):
    raw = open(path, "rb").read()
    n = struct.unpack("<I", raw[12:16])[0]
    g, binary = json.loads(raw[20:20 + n]), raw[28 + n:]
    total = count = 0
    for p in (p for mesh in g["meshes"] for p in mesh["primitives"] if "COLOR_0" in p["attributes"]):
        a = g["accessors"][p["attributes"]["COLOR_0"]]
        view = g["bufferViews"][a["bufferView"]]
        total += sum(struct.unpack_from(f"<{3 * a['count']}f", binary, view.get("byteOffset", 0))[1::3])
        count += a["count"]
    return total / count * g["asset"]["extras"]["resolvent"]["light_scale"]
plain, turned = mean("box.glb"), mean("turned.glb")
assert 0.8 * plain < turned < 1.25 * plain, (plain, turned)
TEXT
# a lightmap: irradiance in a texture and in a separate file, with generated texture coordinates
succeeds bake two-rooms -o map.glb --to lightmap --quality draft --max-elements 800 --map-size 256 --basis --operator --directional --stats map.json
for axis in x y z; do
    [[ -s map.lightmap-$axis.exr ]] || complain "map.lightmap-$axis.exr is missing"
done
for odd in '--to vertex --directional:lightmap' '--to lightmap --unlit:vertex' '--to probes --map-size 64:lightmap' '--to vertex --spacing 1:probes'; do
    refuses 2 "requires --to ${odd##*:}" bake two-rooms -o "$out/a.glb" ${odd%:*}
done
refuses 1 'no environment to rotate' bake two-rooms -o "$out/a.glb" --to lightmap --basis --env-turns 4
for key in elements residual_inf warnings peak_rss_bytes; do
    grep -q "\"$key\"" map.json || complain "the statistics lack $key"
done
python3 - <<'TEXT' || complain "the operator knows other texels than the map"
import json
def header(path):
    raw = open(path, "rb").read()
    return json.loads(raw[8:8 + int.from_bytes(raw[:8], "little")])
operator, basis = header("map.operator.safetensors"), header("map.light.safetensors")
assert operator["receiver.element"]["shape"] == operator["receiver.weight"]["shape"] == [basis["basis.value"]["shape"][1], 3]
assert operator["__metadata__"]["receivers"] == basis["__metadata__"]["receivers"] == "texel"
TEXT
succeeds info map.operator.safetensors
refuses 2 'operator requires --to vertex' bake two-rooms -o "$out/a.json" --to probes --operator
refuses 2 'require --to vertex or lightmap' bake two-rooms -o "$out/a.json" --to probes --light-scale 2
# clipping is reported; the texture with shared exponents is not clipped
succeeds bake plain.glb -o "$out/clipped.glb" --to lightmap --quality draft --max-elements 300 --map-size 64 --light-scale 0.01 --ktx2
says '^light scale 0.01 W'
says '^clipped     [1-9].* of the texels'
python3 - "$out/clipped" <<'TEXT' || complain "the KTX file is not what it should be"
import struct, sys
raw = open(sys.argv[1] + ".lightmap.ktx2", "rb").read()
assert raw[:12] == b"\xabKTX 20\xbb\r\n\x1a\n"
form, size, width, height = struct.unpack_from("<4I", raw, 12)
descriptor, length = struct.unpack_from("<2I", raw, 48)
at, count = struct.unpack_from("<2Q", raw, 80)
assert (form, size) == (123, 4) and 0 < width <= 64 and count == 4 * width * height and len(raw) == at + count
assert struct.unpack_from("<I", raw, descriptor)[0] == length and at == descriptor + length and at % 4 == 0
code = [struct.unpack_from("<I", raw, at + 4 * k)[0] for k in range(width * height)]
assert max((c & 511) * 2.0 ** ((c >> 27) - 24) for c in code) > 0.02 * 3.14159
TEXT
# in lux: 683 times as much, in a document that stays as it is
succeeds bake plain.glb -o "$out/lux.glb" --to lightmap --quality draft --max-elements 300 --map-size 64 --light-scale 0.01 --photometric
says '^light scale 6.83 cd/m2: 1 in the file is an illuminance of 21.46 lux'
cmp -s "$out/lux.glb" "$out/clipped.glb" || complain "lux are in the document"
succeeds compare "$out/lux.lightmap.exr" "$out/clipped.lightmap.exr" --json
awk -v r="$(number stdout mean_ratio)" 'BEGIN { exit !(683 * r > 0.9999 && 683 * r < 1.0001) }' || complain "the map is not in lux"
rm -f "$out"/*
refuses 2 'photometric requires' bake two-rooms -o "$out/a.json" --to probes --photometric
python3 "$here/change_box.py" marble plain.glb marble.glb || complain "no box can be made of marble"
run bake marble.glb -o "$out/a.glb" --to vertex --operator --quality draft --max-elements 300
((status == 1)) || complain "an operator for run time takes marble"
warns 'cannot hold translucent materials'
awk -v c="$(number map.json coverage)" -v s="$(number map.json largest_seam)" 'BEGIN { exit !(c > 0.7 && s < 0.01) }' ||
    complain "coverage $(number map.json coverage), seams $(number map.json largest_seam)"
[[ -s map.lightmap.exr && -s map.light.safetensors ]] || complain "a file is missing beside the map"
python3 - <<'TEXT' || complain "the map is not in the file as it should be"
import json, struct
raw = open("map.glb", "rb").read()
g = json.loads(raw[20:20 + struct.unpack("<I", raw[12:16])[0]])
lit = [m for m in g["materials"] if "MOZ_lightmap" in m.get("extensions", {})]
assert lit and all(m["extensions"]["MOZ_lightmap"]["intensity"] > 0 for m in lit)
assert all("TEXCOORD_1" in p["attributes"] for mesh in g["meshes"] for p in mesh["primitives"]
           if "MOZ_lightmap" in g["materials"][p["material"]].get("extensions", {}))
view = g["bufferViews"][g["images"][-1]["bufferView"]]
open("map.png", "wb").write(raw[28 + struct.unpack("<I", raw[12:16])[0] + view.get("byteOffset", 0):][:view["byteLength"]])
open("intensity", "w").write(str(lit[0]["extensions"]["MOZ_lightmap"]["intensity"]))
TEXT
# its codes are sRGB: decoded, as `compare` reads them, times the intensity they are the map in full
succeeds compare map.lightmap.exr map.png --json
ratio=$(number stdout mean_ratio)
awk -v r="$ratio" -v i="$(cat intensity)" 'BEGIN { exit !(r * i > 0.97 && r * i < 1.01) }' ||
    complain "decoded codes are $ratio of the map, at an intensity of $(cat intensity)"
# baked again, its second texture coordinates are kept; invalid ones are reported and replaced
succeeds bake map.glb -o again.glb --to lightmap --quality draft --max-elements 300 --map-size 256 --dry-run
! grep -q 'new ones are made' stderr || complain "texture coordinates of our own are refused"
python3 - <<'TEXT' || complain "the texture coordinates cannot be spoilt"
import json, struct
raw = open("map.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g, binary = json.loads(raw[20:20 + n]), raw[28 + n:]
lit = [p for mesh in g["meshes"] for p in mesh["primitives"] if "TEXCOORD_1" in p["attributes"]]
def write(name, change):
    data = bytearray(binary)
    for p in lit:
        a = g["accessors"][p["attributes"]["TEXCOORD_1"]]
        at = g["bufferViews"][a["bufferView"]].get("byteOffset", 0) + a.get("byteOffset", 0)
        for k in range(a["count"]):
            uv = struct.unpack_from("<2f", data, at + 8 * k)
            struct.pack_into("<2f", data, at + 8 * k, *change(k, *uv))
    g["buffers"][0] = {"byteLength": len(data), "uri": name + ".bin"}
    open(name + ".bin", "wb").write(data)
    json.dump(g, open(name + ".gltf", "w"))
write("outside", lambda k, u, v: (u + 1, v))
write("overlapping", lambda k, u, v: ((k % 2), (k // 2 % 2)))
write("flat", lambda k, u, v: (0.5, 0.5))
# a triangle of no area among others
p = lit[0]
a = g["accessors"][p["indices"]]
at = g["bufferViews"][a["bufferView"]].get("byteOffset", 0) + a.get("byteOffset", 0)
size = {5121: 1, 5123: 2, 5125: 4}[a["componentType"]]
data = bytearray(binary)
data[at + size:at + 3 * size] = 2 * data[at:at + size]
g["buffers"][0] = {"byteLength": len(data), "uri": "sliver.bin"}
open("sliver.bin", "wb").write(data)
json.dump(g, open("sliver.gltf", "w"))
TEXT
few=(--to lightmap --quality draft --max-elements 300 --map-size 128 --dry-run)
for case in 'outside:leave the unit square' 'overlapping:overlap' 'flat:have no area'; do
    succeeds bake "${case%%:*}.gltf" -o "$out/x.glb" "${few[@]}"
    warns "second texture coordinates ${case#*:}; new ones are made"
    says '^coverage    [6-9][0-9]'
done
succeeds bake sliver.gltf -o "$out/x.glb" "${few[@]}"
# many lights: what their basis takes is said before the work
python3 - >many.gltf <<'PYTHON'
import base64, json, struct
corners = struct.pack("<9f", 0, 0, 0, 0, 0, 1, 1, 0, 0)
lights = [{"type": "point", "name": f"lamp {k}", "intensity": 1} for k in range(40)]
nodes = [{"translation": [0.02 * k, 1, 0.3], "extensions": {"KHR_lights_punctual": {"light": k}}} for k in range(40)]
print(json.dumps({"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
    "extensions": {"KHR_lights_punctual": {"lights": lights}}, "nodes": nodes + [{"mesh": 0}], "scenes": [{"nodes": list(range(41))}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 1]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "data:;base64," + base64.b64encode(corners).decode()}]}))
PYTHON
succeeds bake many.gltf -o many.glb --to vertex --basis --packed --quality draft --max-elements 50
warns 'basis of 40 lights is computed light by light'
warns 'basis of 40 lights at [0-9]* receivers takes about [0-9.]* MB in its file'

# two floors, the right one darker: its texture coordinates lie upon the other's or collapse, and are made anew; or both touch
# on the border, and each keeps its light
python3 - <<'TEXT' || complain "the floors cannot be written"
import json, struct
lit = [(-2, 0, -2), (0, 0, -2), (0, 0, 2), (-2, 0, 2)]
dark = [(x + 5, -1, z) for x, y, z in lit]
lamp = [(x + 1, 3, z / 2) for x, y, z in lit]
def write(name, place, uv):
    index = [k // 6 * 4 + (0, 2, 1, 0, 3, 2)[k % 6] for k in range(6 * len(place) // 4)]
    parts = [struct.pack(f"<{3 * len(place)}f", *sum(place, ())), struct.pack(f"<{2 * len(uv)}f", *sum(uv, ())),
             struct.pack(f"<{len(index)}I", *index),
             struct.pack("<12f", *sum(lamp, ())), struct.pack("<6I", 0, 1, 2, 0, 2, 3)]
    at = [sum(len(p) for p in parts[:k]) for k in range(5)]
    limits = lambda p: {"min": [min(v[a] for v in p) for a in range(3)], "max": [max(v[a] for v in p) for a in range(3)]}
    accessor = lambda view, type, component, count, **more: {
        "bufferView": view, "type": type, "componentType": component, "count": count, **more}
    json.dump({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0}, {"mesh": 1}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 1}, "indices": 2,
                                    "material": 0}]},
                   {"primitives": [{"attributes": {"POSITION": 3}, "indices": 4, "material": 1}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}},
                      {"pbrMetallicRoughness": {"metallicFactor": 0}, "emissiveFactor": [1, 1, 1]}],
        "accessors": [accessor(0, "VEC3", 5126, len(place), **limits(place)),
                      accessor(1, "VEC2", 5126, len(uv)), accessor(2, "SCALAR", 5125, len(index)),
                      accessor(3, "VEC3", 5126, 4, **limits(lamp)),
                      accessor(4, "SCALAR", 5125, 6)],
        "bufferViews": [{"buffer": 0, "byteOffset": a, "byteLength": len(p)} for a, p in zip(at, parts)],
        "buffers": [{"byteLength": sum(map(len, parts)), "uri": name + ".bin"}]}, open(name + ".gltf", "w"))
    open(name + ".bin", "wb").write(b"".join(parts))
rectangle = lambda x, y, right, low: [(x, y), (right, y), (right, low), (x, low)]
for name, right in (("touching", rectangle(.5, 0, 1, 1)), ("strip", rectangle(.48, 0, 1, 1)),
                    ("point", rectangle(.7, .7, .7, .7)), ("line", rectangle(.7, 0, .7, 1))):
    write(name, lit + dark, rectangle(0, 0, .5, 1) + right)
corners = [(x / 10, y / 10) for x in range(10) for y in range(10)]
tiles = lambda side: sum([rectangle(x, y, x + side, y + side) for x, y in corners], [])
write("pieces", [(4 * round(x, 1), 0, 4 * round(y, 1)) for x, y in tiles(.1)], tiles(.08))
TEXT
for case in strip:overlap 'point:collapse triangles' 'line:collapse triangles'; do
    succeeds bake "${case%%:*}.gltf" -o "$out/x.glb" "${few[@]}"
    warns "second texture coordinates ${case#*:}.*; new ones are made"
done
succeeds bake pieces.gltf -o "$out/x.glb" "${few[@]}" --map-size 32
warns 'second texture coordinates are in too many pieces for the map; new ones are made'
succeeds bake touching.gltf -o touching.glb --to lightmap --quality draft --map-size 64 --basis
! grep -q 'new ones are made' stderr || complain "texture coordinates that touch are refused"
python3 - <<'TEXT' || complain "light runs over from one floor into the other"
import json, struct
raw = open("touching.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g, binary = json.loads(raw[20:20 + n]), raw[28 + n:]
def start(view):
    return g["bufferViews"][view].get("byteOffset", 0)
def read(accessor, width):
    a = g["accessors"][accessor]
    at = start(a["bufferView"]) + a.get("byteOffset", 0)
    return [struct.unpack_from(f"<{width}f", binary, at + 4 * width * k) for k in range(a["count"])]
primitive = g["meshes"][0]["primitives"][0]
size = struct.unpack_from(">2I", binary, start(g["images"][-1]["bufferView"]) + 16)
lit = g["materials"][primitive["material"]]["extensions"]["MOZ_lightmap"]["texCoord"]
places = list(zip(read(primitive["attributes"]["POSITION"], 3), read(primitive["attributes"][f"TEXCOORD_{lit}"], 2)))
raw = open("touching.light.safetensors", "rb").read()
n = struct.unpack("<Q", raw[:8])[0]
first = 8 + n + json.loads(raw[8:8 + n])["basis.value"]["data_offsets"][0]
def light(x):
    """In the middle of the side at x, filtered."""
    ends = [uv for p, uv in places if p[0] == x]
    at = [sum(uv[a] for uv in ends) / len(ends) * size[a] - .5 for a in range(2)]
    low = [min(int(at[a]), size[a] - 2) for a in range(2)]
    u, v = at[0] - low[0], at[1] - low[1]
    texel = lambda x, y: struct.unpack_from("<f", raw, first + 12 * (y * size[0] + x))[0]
    row = lambda y: texel(low[0], y) * (1 - u) + texel(low[0] + 1, y) * u
    return row(low[1]) * (1 - v) + row(low[1] + 1) * v
assert light(0) > .35 and light(3) < .12, (light(0), light(3))
TEXT
run bake two-rooms -o "$out/x.glb" --to lightmap --quality draft --max-elements 300 --map-size 16
((status == 1)) || complain "51 charts fit into 16 x 16 texels"
warns 'do not fit'
[[ -z $(ls -A "$out") ]] || complain "a map that does not fit was written"
# probes in a furnace: radiance is the same in all directions, and `probe` reads pi times that
succeeds bake furnace -o probes.json --to probes --spacing 0.25 --quality draft
says '^probes      4 x 4 x 4, 64 valid'
printf 'x,y,z,nx,ny,nz\n0.4,0.5,0.6,0,0,1\n' >points.csv
succeeds probe furnace --points points.csv -o readings.csv --quality draft
python3 - <<'TEXT' || complain "the probes do not hold the furnace's light"
import csv, json, struct
grid = json.load(open("probes.json"))
data = open(grid["data"], "rb").read()
count = grid["coefficients"]["shape"][0]
sh = struct.unpack(f"<{count * 27}f", data[:count * 108])
assert data[grid["valid"]["byteOffset"]:] == b"\1" * count
irradiance = float(list(csv.reader(open("readings.csv")))[1][6])
for probe in range(count):
    mean = 0.88622693 * sh[27 * probe]
    assert abs(mean - irradiance) < 0.02 * irradiance, (mean, irradiance)
    assert all(abs(sh[27 * probe + k]) < 0.05 * irradiance for k in range(3, 27))
TEXT
# the contributions of the lights to probes add up to the baked light, although each uses its own random numbers
refuses 1 'no environment to write' bake cornell-blocks -o "$out/a.json" --to probes --sky
succeeds bake cornell-blocks -o parts.json --to probes --basis --env sky --env-rotate 90 --sky --spacing 0.3 --quality draft --max-elements 500
python3 - <<'TEXT' || complain "the parts of probes do not add up to what was baked"
import array, json, struct
grid = json.load(open("parts.json"))
baked = array.array("f", open(grid["data"], "rb").read()[:grid["coefficients"]["byteLength"]])
raw = open("parts.light.safetensors", "rb").read()
start = 8 + struct.unpack("<Q", raw[:8])[0]
begin, end = json.loads(raw[8:start])["basis.value"]["data_offsets"]
part = array.array("f", raw[start + begin:start + end])
lights = len(part) // len(baked)
assert lights > 1 and max(baked) > .1
assert open("parts.hdr", "rb").read(2) == b"#?"
for k, value in enumerate(baked):
    assert abs(sum(part[k::len(baked)]) - value) < 1e-5 * max(baked), k
TEXT
# within blocks no light is, though their materials are double-sided
succeeds scene cornell-blocks -o blocks.glb
python3 - <<'TEXT' || complain "the blocks cannot be made double-sided"
import json, struct
raw = open("blocks.glb", "rb").read()
n = struct.unpack("<I", raw[12:16])[0]
g = json.loads(raw[20:20 + n])
for m in g["materials"]:
    m["doubleSided"] = True
g["buffers"][0] = {"byteLength": len(raw) - 28 - n, "uri": "double.bin"}
open("double.bin", "wb").write(raw[28 + n:])
json.dump(g, open("double.gltf", "w"))
TEXT
for scene in blocks.glb double.gltf; do
    succeeds bake $scene -o probes-blocks.json --to probes --spacing 0.2 --quality draft --max-elements 300
    grep '^probes' stdout >"${scene%.*}.count"
done
cmp -s blocks.count double.count ||
    complain "as double-sided blocks there are $(cat double.count), as others $(cat blocks.count)"
# input files are never overwritten
cp kept.bin kept.before
succeeds bake kept.gltf -o kept.json --to probes --spacing 1 --quality draft --max-elements 300
cmp -s kept.bin kept.before ||
    complain "the scene's buffer was written over"
refuses 1 'would overwrite' bake furnace -o y.glb --to lightmap --quality draft --stats y.lightmap.exr
refuses 2 'json' bake furnace -o "$out/x.glb" --to probes
refuses 2 '--to' bake cornell-blocks -o "$out/x.glb"
refuses 2 'glb' bake cornell-blocks -o "$out/x.png" --to vertex
refuses 2 'tolerance' bake cornell-blocks -o "$out/x.glb" --to vertex --tolerance 0
python3 - >mirror.gltf <<'TEXT'
import base64, json, struct
corners = base64.b64encode(struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)).decode()
print(json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "materials": [{"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64," + corners}]}))
TEXT
refuses 1 'no surface reflects diffusely' bake mirror.gltf -o "$out/x.glb" --to vertex --quality draft
refuses 1 'no surface reflects diffusely' bake mirror.gltf -o "$out/x.glb" --to lightmap --quality draft
succeeds bake "$here/../fuzz/seeds/packed.gltf" -o unpacked.glb --to vertex --quality draft --max-elements 50
grep -qa KHR_draco unpacked.glb && complain "a packed mesh stayed packed"
succeeds render unpacked.glb -o unpacked.png --size 16x16 --quality draft
refuses 1 'nowhere' bake nowhere.glb -o "$out/x.glb" --to vertex

# for a scene that is not a glTF file, the temporary glTF file is removed, however the program ends
mkdir killed
printf '%s\n' 'mtllib a.mtl' 'usemtl m' 'v 0 0 0' 'v 2 0 0' 'v 2 0 2' 'v 0 0 2' 'f 1 4 3 2' >killed/a.obj
printf '%s\n' 'newmtl m' 'Kd .5 .5 .5' >killed/a.mtl
succeeds bake killed/a.obj -o "$out/a.glb" --to vertex --quality draft --max-elements 300 --env white
rm -f "$out"/*
(cd killed && timeout -s KILL 2 "$program" bake a.obj -o a.glb --to vertex --quality high --env white >said 2>&1; true)
[[ $(ls -A killed | grep -v -e '^a[.]glb$' -e '^[.]resolvent') == $'a.mtl\na.obj\nsaid' ]] || complain "a bake that was killed left $(ls -A killed)"
finish
