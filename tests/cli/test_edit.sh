#!/usr/bin/env bash
# Objects edited in the view: the light is that of the edited scene, solved afresh; undo, files, and what is refused.
source "$(dirname "$0")/support.sh"
unset DISPLAY WAYLAND_DISPLAY
quick=(--quality draft --max-elements 700 --size 48x32 --threads 2)
succeeds solve cornell-blocks -o room.safetensors "${quick[@]:0:4}"

cat >edit.txt <<'TXT'
0     show hud
0     show markers
64    screenshot first.exr
65    object "short block"
65    shift 0 0 0.1
66    spin 20
140   screenshot moved.exr
140   save moved.glb
141   grasp 0.4 0.5
141   delete
141   object "short block"
141   duplicate
141   resize 0.5
141   paint 0.1 0.2 0.9
205   screenshot more.exr
205   save more.glb
206   undo
206   undo
206   undo
206   undo
206   undo
206   undo
270   screenshot again.exr
TXT
succeeds view room.safetensors "${quick[@]}" --exposure 0 --script edit.txt --record frames
# cells of 10 cm: solutions of other cells differ by about 1 %
for name in moved more; do
    succeeds info $name.glb
    cp stdout $name.txt
    succeeds render $name.glb -o fresh.exr "${quick[@]}" --mode operator --spp 64
    succeeds compare fresh.exr $name.exr
    says '^mean_ratio *\(1.00\|0.99\)'
    says '^median_relative_error *0.00'
done
grep -q 'objects: 8' moved.txt || complain "moving changed the number of objects"
grep -q 'objects: 8' more.txt && ! grep -q 'tall block' more.txt || complain "no copy in place of the tall block"
grep -q 'base color (0.1 0.2 0.9)' more.txt || complain "nothing was painted"
succeeds compare first.exr again.exr
says '^mean_ratio *\(1.00\|0.99\)'
says '^relative_mse *0.00'
succeeds compare first.exr moved.exr
says '^relative_mse *0.0[4-9]' # edits are seen at all

wrong() { # COMMAND MESSAGE
    printf '0 object "short block"\n1 %s\n3 quit\n' "$1" >bad.txt
    refuses 1 "$2" view room.safetensors "${quick[@]}" --script bad.txt --record "$work/bad"
    rm -rf "$work/bad"
}
wrong 'object sofa' "no object 'sofa'"
wrong 'resize 0' 'above 0'
printf '0 object "short block"\n0 resize 1000000\n0 resize 100000\n' >bad.txt
refuses 1 'reaches to a coordinate' view room.safetensors "${quick[@]}" --script bad.txt --record "$work/bad"
rm -rf "$work/bad"
wrong 'save room.obj' 'does not end in .glb'
wrong undo 'nothing to undo'
printf '0 object "short block"\n0 shift 0 0 0.1\n1 play\n' >bad.txt
refuses 1 'edited scene cannot be played' view room.safetensors "${quick[@]}" --script bad.txt --record "$work/bad"
rm -rf "$work/bad"
for object in floor ceiling 'back wall' 'right wall' 'left wall' 'short block' 'tall block' light; do
    printf '0 object "%s"\n0 delete\n' "$object"
done >bad.txt
refuses 1 'no triangles' view room.safetensors "${quick[@]}" --script bad.txt --record "$work/bad"
rm -rf "$work/bad"
printf '0 delete\n' >bad.txt
refuses 1 'no object is selected' view room.safetensors "${quick[@]}" --script bad.txt --record "$work/bad"
rm -rf "$work/bad"

finish
