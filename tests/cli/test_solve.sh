#!/usr/bin/env bash
# Operator files: their pictures and probes equal those of the scene, and errors in them are reported.
source "$(dirname "$0")/support.sh"

succeeds solve cornell-blocks -o blocks.safetensors --quality draft --stats solve.json
[[ ! -s stdout ]] || complain "solve printed on standard output"
grep -q '"command":.*"solve"' solve.json || complain "no statistics"
for mode in final operator; do
    for scene in cornell-blocks blocks.safetensors; do
        succeeds render $scene -o $scene.exr "${small[@]}" --mode $mode
    done
    cmp -s cornell-blocks.exr blocks.safetensors.exr || complain "another picture in mode $mode"
done
mv blocks.safetensors renamed.glb # known by its content
echo '0.2,0,0.3,0,1,0' >points.csv
for scene in cornell-blocks renamed.glb; do
    succeeds probe $scene --points points.csv -o $scene.csv --quality draft --samples 1024
done
cmp -s cornell-blocks.csv renamed.glb.csv || complain "another reading"
succeeds certify renamed.glb --samples 64 --rays 16
says '^bound'
succeeds info renamed.glb
says '^solved operator'
succeeds info renamed.glb --json
says '"norm_inf"'

refuses 2 'safetensors' solve furnace -o "$out/a.png"
refuses 2 'missing' solve furnace
refuses 1 'folder' solve furnace -o no/such/folder/a.safetensors
refuses 1 'environment' render renamed.glb -o "$out/a.png" --env sky.hdr
refuses 1 'mesh' render renamed.glb -o "$out/a.png" --mesh renamed.glb
head -c 100000 renamed.glb >cut.safetensors
refuses 1 'cut.safetensors.*cut off' render cut.safetensors -o "$out/a.png"
cp renamed.glb changed.safetensors
printf '\x7f' | dd of=changed.safetensors bs=1 seek=500000 conv=notrunc status=none
refuses 1 'changed.safetensors.*checksum' info changed.safetensors
finish
