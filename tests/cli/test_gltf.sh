#!/usr/bin/env bash
# A glTF file near and far from its origin: pictures, operators, probes and bakes agree; lights answer to their nodes.
source "$(dirname "$0")/support.sh"
command -v python3 >/dev/null || { echo "skipped: python3 is not installed"; exit 77; }

# close A B: the same picture, apart from rounding
close() {
    succeeds compare "$1" "$2"
    awk '/^rmse/ { exit !($2 < 1e-4) }' stdout || complain "$1 and $2 differ by $(head -n 1 stdout)"
}

differ() {
    succeeds compare "$1" "$2"
    awk '/^rmse/ { exit !($2 > 0.01) }' stdout
}

solving=(--quality draft --max-elements 600)
small=(--size 32x24 --spp 1)
far=(448262.5 51 5411932.25)
python3 "$here/make_gltf.py" near.gltf
python3 "$here/make_gltf.py" km22.gltf 22000 0 0
python3 "$here/make_gltf.py" far.gltf "${far[@]}"

# -- supported features

succeeds info far.gltf
says 'bounds: (448260.5 51 5411929.75) to (448264.5 54 5411934.75) m'
says 'crates, instance 2  12 triangles'
says 'bulb  node  middle  point'
says 'lens  node  top  at (448262.5 53.8 5411932.25)'
says 'punctual lights: 3'
warns 'note: 1 nodes (first: .off.) are hidden by KHR_node_visibility'
grep -q warning stderr && complain "an ordinary file is warned of"

# -- pictures of all modes

for name in near far; do
    succeeds solve $name.gltf -o $name.safetensors "${solving[@]}"
    for mode in final operator; do
        succeeds render $name.safetensors -o $name-$mode.exr --mode $mode "${small[@]}"
    done
done
for name in near km22 far; do
    for mode in reference occlusion; do
        succeeds render $name.gltf -o $name-$mode.exr --mode $mode "${small[@]}"
    done
    [[ $name == near ]] || close near-reference.exr $name-reference.exr
done
for mode in final operator occlusion; do
    close near-$mode.exr far-$mode.exr
done
succeeds render far.safetensors -o top.exr --mode operator --camera top "${small[@]}"
refuses 1 'has no camera' render far.safetensors -o "$out/a.exr" --camera bottom "${small[@]}"

# -- objects that move, near and far: places of a script count from where their own file has them

write_body() {
    python3 - "$@" <<'END'
import json, struct, sys
name, place = sys.argv[1], [float(x) for x in sys.argv[2:]]
open("body.bin", "wb").write(struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 1, 0) + bytes([0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]))
json.dump({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "translation": place}],
           "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
           "buffers": [{"byteLength": 60, "uri": "body.bin"}],
           "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
           "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, -1], "max": [1, 1, 0]},
                         {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"}]}, open(name, "w"))
END
}
write_body body-near.gltf 0 0 0
write_body body-far.gltf "${far[@]}"
printf '%s\n' '0 place.object=0.25,0.5,0' '1 place.object=0.5,1,-0.5' >way.txt
for name in near far; do
    succeeds relight $name.safetensors --object body-$name.gltf --script way.txt -o moved-$name%d.exr --mode operator "${small[@]}"
done
close moved-near0.exr moved-far0.exr
close moved-near1.exr moved-far1.exr
differ near-operator.exr moved-near0.exr || complain "the object is not to be seen"

# -- operator files keep places and nodes

for light in left bulb; do
    succeeds relight far.safetensors -o far-$light.exr --light $light=0 --mode operator "${small[@]}"
done
differ far-operator.exr far-left.exr || complain "the light at node 'left' cannot be switched off by itself"
differ far-left.exr far-bulb.exr || complain "lights of one name cannot be switched off together"
refuses 1 "'bulb' of node 'right'" relight far.safetensors -o "$out/a.exr" --light nobody=0
succeeds info far.safetensors
says 'bulb  node  middle  point'
says 'bounds: (448260.5 51 5411929.75)'

# -- points are the file's

printf '0.5,0,0.25,0,1,0\n' >near.csv
printf '448263,51,5411932.5,0,1,0\n' >far.csv
for name in near far; do
    succeeds probe $name.safetensors --points $name.csv -o $name-read.csv
done
grep -q '^448263,51,5411932.5,' far-read.csv || complain "points come back as $(tail -n 1 far-read.csv)"
awk -F, 'FNR == 2 { value[++n] = $7 } END { d = value[1] - value[2]; exit !(d < 1e-4 && d > -1e-4 && value[1] > 0) }' \
    near-read.csv far-read.csv || complain "probes differ: $(tail -qn 1 near-read.csv far-read.csv)"
succeeds bake far.gltf -o probes.json --to probes --spacing 2 "${solving[@]}"
grep -q '"origin":.*\[44826' probes.json || complain "probes are at $(grep origin probes.json)"

# -- baked files are where the file was; instances become nodes, each with light of its own

succeeds bake far.gltf -o baked.glb --to vertex "${solving[@]}" --tolerance 20%
succeeds info baked.glb
says 'bounds: (448260.5 51 5411929.75) to (448264.5 54 5411934.75) m'
says 'crates, instance 2'
grep -a -q EXT_mesh_gpu_instancing baked.glb && complain "a baked file still has instances"


# -- lights of one definition have columns of their own

succeeds bake near.gltf -o parts.glb --to vertex --basis "${solving[@]}" --tolerance 20%
says 'lights  *4'
names='\"left\",\"middle\",\"right\"'
grep -a -q -F "$names" parts.light.safetensors ||
    complain "the basis has the lights $(head -c 400 parts.light.safetensors | tr -c '[:print:]' ' ')"
grep -a -q -F 'light.definition' parts.light.safetensors || complain "the basis does not say what lights have in common"

# -- view: by both names, and at places of a map

lights='0 select light.left\n0 intensity 0\n0 select light.bulb\n'
printf "$lights"'0 screenshot near-0.exr\n1 add desk 0.5 1 0.25\n2 screenshot near-2.exr\n' >near.view
printf "$lights"'0 screenshot far-0.exr\n1 add desk 448263 52 5411932.5\n2 screenshot far-2.exr\n' >far.view
for name in near far; do # of a size that puts the middle of no pixel on the edge of a crate, which roundings may move
    succeeds view $name.safetensors --script $name.view --record $name-view --size 61x47
done
differ near-0.exr near-2.exr || complain "a light that was added does not shine"
close near-0.exr far-0.exr
close near-2.exr far-2.exr
refuses 1 'not a number from -1e9' view near.safetensors --script <(echo '0 add desk 1 2 1e10') --record "$out"

finish
