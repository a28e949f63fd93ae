#!/usr/bin/env bash
# A built-in scene written to a file and read back is the same scene.
source "$(dirname "$0")/support.sh"

# The output of --json to four digits, without names of scenes.
facts() {
    succeeds info "$@" --json
    sed -E -e '/"scene":/d' -e 's/([0-9]\.[0-9]{0,4})[0-9]*/\1/g' stdout
}

# there_and_back NAME ARGUMENT...: a scene and the file written from it have the same content
there_and_back() {
    local name=$1
    succeeds scene "$@" -o $name.glb
    [[ $(head -c 4 $name.glb) == glTF ]] || complain "$name.glb is not binary glTF"
    succeeds info "$@"
    says 'triangles'
    says 'cameras: [1-9]'
    facts "$@" >named.txt
    facts $name.glb >read.txt
    diff named.txt read.txt >difference.txt || complain "$name: changes on its way through a file: $(head -n 4 difference.txt)"
}

for name in cornell-blocks cornell-spheres furnace two-rooms gallery:2 terraces:5000 cornell-marble milk; do
    there_and_back $name
done
for name in cornell-glass cornell-plaster cornell-showcase character; do
    there_and_back $name --mesh cornell-spheres.glb
done
succeeds scene cornell-blocks -o again.glb
cmp -s again.glb cornell-blocks.glb || complain "the same scene, written twice, differs"

# -- sizes

succeeds info terraces:20000
says 'terraces:20000: [12][0-9][0-9][0-9][0-9] triangles'
succeeds render gallery:1 -o "$out/one.png" "${small[@]}"
rm "$out/one.png"
refuses 1 'whole number of rooms' info gallery:2.5
refuses 1 'from 5000 to 100000000' render terraces:1e12 -o "$out/a.png"
refuses 1 'no size to choose' info furnace:3
refuses 1 'no built-in' info gallerie:3

# -- bodies

succeeds scene cornell-glass --mesh cornell-spheres.glb -o given.glb
succeeds info given.glb
says ' glass '
succeeds info cornell-marble --mesh cornell-spheres.glb
refuses 1 'takes no mesh' scene furnace --mesh cornell-spheres.glb -o "$out/a.glb"
refuses 1 'not a built-in' info cornell-spheres.glb --mesh cornell-spheres.glb
refuses 1 'nowhere.ply' scene cornell-glass --mesh nowhere.ply -o "$out/a.glb"
echo ply >half.ply
refuses 1 'half.ply' info character --mesh half.ply
finish
