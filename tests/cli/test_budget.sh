#!/usr/bin/env bash
# --max-elements and --max-memory are kept by a coarser solution and a line that says so, or refused in one line.
source "$(dirname "$0")/support.sh"

# value NAME: a number of stats.json
value() { sed -n "s/^.*\"$1\":[[:space:]]*\([0-9]*\).*$/\1/p" stats.json; }

# at_most NAME LIMIT
at_most() { (($(value "$1") <= $2)) || complain "$1 is $(value "$1"), more than $2"; }

succeeds render cornell-blocks -o "$out/a.png" "${small[@]}" --max-elements 400 --stats stats.json
warns 'coarser than requested'
at_most elements 400
succeeds render gallery:1 -o "$out/a.png" "${small[@]}" --quality medium --max-elements 3000 --stats stats.json
at_most elements 3000
succeeds render cornell-blocks -o "$out/a.png" "${small[@]}" --max-elements 100000 --stats stats.json
grep -q 'coarser' stderr && complain "a budget that is large enough is spoken of"
rm -f "$out"/*

# small limits hold, or are refused with the fewest elements that there can be: those are enough, and one fewer is not
for scene in cornell-blocks furnace; do
    refuses 1 'elements is too small' render $scene -o "$out/a.png" "${small[@]}" --max-elements 1
    enough=$(sed -n 's/^.* need at least \([0-9]*\);.*$/\1/p' stderr)
    refuses 1 "need at least $enough;" render $scene -o "$out/a.png" "${small[@]}" --max-elements $((enough - 1))
    for most in "$enough" $((enough + 36)); do
        succeeds render $scene -o "$out/a.png" "${small[@]}" --max-elements "$most" --stats stats.json
        at_most elements "$most"
        (($(value rows) > 0)) || complain "$scene: none of $most elements sees anything"
    done
    rm -f "$out"/*
done

# budgets are used
for case in 'cornell-blocks 25 20' 'cornell-blocks 70 60' 'cornell-blocks 500 450' 'cornell-spheres 50 40' 'furnace 30 25' \
    'terraces:3e4 3000 2000'; do
    read -r scene most least <<<"$case"
    succeeds solve "$scene" -o "$out/a.safetensors" --quality draft --max-elements "$most" --stats stats.json
    at_most elements "$most"
    (($(value elements) >= least)) || complain "$scene: $(value elements) of $most elements"
done
rm -f "$out"/*

refuses 1 'memory budget of 5 MiB is too small' render cornell-blocks -o "$out/a.png" "${small[@]}" --max-memory 5MiB
refuses 1 'memory budget of 40 MiB is too small' render terraces:3e5 -o "$out/a.png" "${small[@]}" --max-memory 40MiB

# reading keeps to it too: a million instances in a file of 1 kB
cat >many.gltf <<'TEXT'
{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [ { "nodes": [ 0 ] } ],
  "extensionsUsed": [ "EXT_mesh_gpu_instancing" ],
  "nodes": [ { "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 1 } } } } ],
  "meshes": [ { "primitives": [ { "attributes": { "POSITION": 0 } } ] } ],
  "accessors": [ { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
                 { "componentType": 5126, "count": 1000000, "type": "VEC3" } ],
  "bufferViews": [ { "buffer": 0, "byteLength": 36 } ],
  "buffers": [ { "byteLength": 36,
                 "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" } ] }
TEXT
for command in "render many.gltf -o $out/a.png" "solve many.gltf -o $out/a.safetensors" "bake many.gltf --to vertex -o $out/a.glb"; do
    refuses 1 'memory budget of 60 MiB is too small to read' $command --max-memory 60MiB
done
for amount in 2 -1GiB 0MiB 1e30TiB nanGiB GiB 1gib '3 GiB'; do
    refuses 2 'amount of memory' render cornell-blocks -o "$out/a.png" --max-memory "$amount"
done
refuses 2 'whole number' probe cornell-blocks --points p.csv -o "$out/a.csv" --max-elements 0

# of the whole program, where sanitizers and their shadows are not part of it
if ! grep -q -a __asan_init "$program"; then
    succeeds render terraces:1e5 -o "$out/a.png" "${small[@]}" --quality medium --max-memory 150MiB --stats stats.json
    warns 'coarser than requested'
    at_most peak_rss_bytes $((150 << 20))
    rm -f "$out"/*
    refuses 1 'allow [0-9]* MiB' render cornell-blocks -o "$out/a.png" "${small[@]}" --max-memory 12MiB
    enough=$(sed -n 's/^.*allow \([0-9]*\) MiB.*$/\1/p' stderr)
    for most in "$enough" $((enough + 6)); do
        succeeds render cornell-blocks -o "$out/a.png" "${small[@]}" --max-memory "${most}MiB" --stats stats.json
        at_most peak_rss_bytes $((most << 20))
    done
fi
rm -f "$out"/*
finish
