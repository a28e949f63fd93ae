#!/usr/bin/env bash
# Relighting an operator file: pictures scale with the light, and unknown names are reported.
source "$(dirname "$0")/support.sh"

box=(--size 32x32 --spp 4 --threads 2)
succeeds solve cornell-blocks -o box.safetensors --quality draft --threads 2
succeeds render box.safetensors -o once.exr "${box[@]}"
succeeds relight box.safetensors -o same.exr "${box[@]}"
succeeds compare once.exr same.exr
says '^mean_ratio *1.00000'
succeeds relight box.safetensors --light light=3 -o thrice.exr -o thrice.safetensors "${box[@]}" --stats relight.json
succeeds compare once.exr thrice.exr
says '^mean_ratio *3.0000'
grep -q '"command":.*"relight"' relight.json || complain "no statistics"
succeeds render thrice.safetensors -o again.exr "${box[@]}"
cmp -s thrice.exr again.exr || complain "the file that was kept gives another picture"
succeeds relight box.safetensors --light light=1,1,0,0 --albedo white=0.2,0.2,0.2 -o red.exr "${box[@]}"

# lights that are off in a file can be switched on again, without a warning about missing light
succeeds relight box.safetensors --light light=0 -o dark.safetensors
warns 'no light'
succeeds relight dark.safetensors --light light=1 -o lit.exr "${box[@]}"
! grep -q 'no light' stderr || complain "a light that is switched on is said to be missing"
succeeds compare once.exr lit.exr
says '^mean_ratio *1.0000'

# a lamp that is moved out of the box through its ceiling leaves it dark
succeeds relight box.safetensors --move light=0,0.2,0 -o moved.exr "${box[@]}"
succeeds compare once.exr moved.exr
says '^mean_ratio *0.0'
succeeds relight box.safetensors --move light=0,0,0 -o unmoved.exr "${box[@]}"
cmp -s same.exr unmoved.exr || complain "a light that stays changes the picture"

# as many lights as a scene may have can be named
dozen=()
for k in {1..12}; do dozen+=(--add "lamp$k=0.1,0.2,0.1,1" --light "lamp$k=0"); done
succeeds relight box.safetensors "${dozen[@]}" -o dozen.exr "${box[@]}"
succeeds compare once.exr dozen.exr
says '^mean_ratio *1.00000'

# a sky that turns is the sky that was turned before
succeeds render cornell-spheres -o sky.hdr --size 64x32 --mode reference --spp 16 --threads 2
open=(--size 48x48 --spp 4 --threads 2)
succeeds solve terraces:5000 --env sky.hdr -o open.safetensors --quality draft --threads 2
succeeds relight open.safetensors --env-rotate 75 --env-intensity 2 -o turned.exr "${open[@]}"
succeeds render terraces:5000 --env sky.hdr --env-rotate 75 --env-intensity 2 -o anew.exr --quality draft "${open[@]}"
succeeds compare anew.exr turned.exr
says '^mean_ratio *\(1.000\|0.999\)'
says '^relative_mse *0$\|^relative_mse *[0-9.]*e-0[5-9]\|^relative_mse *[0-9.]*e-1'
succeeds render open.safetensors -o unturned.exr "${open[@]}"
succeeds compare anew.exr unturned.exr
! grep -q '^mean_ratio *2' stdout || complain "the sky did not turn"

# a script: each frame equals the picture with the same settings as options
printf '%s\n' '# evening' '3 light.light=1 albedo.white=0.7,0.7,0.7 move.light=0,0,0' '5 "light.light=0.5,1,0.5,0" move.light=0.1,0,0' >evening.txt
succeeds relight box.safetensors --script evening.txt -o frame%03d.exr "${box[@]}" --mode operator
[[ $(echo frame*) == 'frame003.exr frame004.exr frame005.exr' ]] || complain "frames are $(echo frame*)"
succeeds relight box.safetensors --light light=1,0.75,0.625,0.5 --move light=0.05,0,0 --albedo white=0.7,0.7,0.7 -o between.exr "${box[@]}" --mode operator
cmp -s frame004.exr between.exr || complain "between two lines light changes evenly"
# strengths alone: the file is read once, each frame equals one call with its settings, and statistics cover all frames
printf '%s\n' '0 light.light=1,1,1' '11 light.light=0.2,1,0.5,0.5' >dim.txt
succeeds relight box.safetensors --script dim.txt -o dim%02d.exr "${box[@]}" --stats dim.json
[[ $(ls dim??.exr | wc -l) == 12 ]] || complain "frames are $(echo dim*.exr)"
succeeds relight box.safetensors --light light=0.2,1,0.5,0.5 -o last.exr "${box[@]}" --stats last.json
succeeds relight box.safetensors --light light=0.2,0.1,0.1 -o rgb.exr "${box[@]}"
cmp -s last.exr rgb.exr || complain "three factors are not those of the runtime"
grep -q '"pictures":[[:space:]]*1,' dim.json || complain "frames of one lamp are sums of one picture"
succeeds compare last.exr dim11.exr
# the sum is of a picture under the light as it was, whose further shadow rays may be others in a few pixels
says '^relative_mse *[0-9.]*\(e-0[5-9]\|e-1\)\|^relative_mse *0$'
says '^median_relative_error *[0-9.]*\(e-0[6-9]\|e-1\)\|^median_relative_error *0$'
says '^mean_ratio *\(1.0000\|0.9999\)'
grep -q '"frames":.*12' dim.json && grep -q '"width":.*32' dim.json || complain "statistics are not complete"
for field in mean_irradiance residual_inf truncation_bound; do
    [[ $(grep "$field" dim.json) == "$(grep "$field" last.json)" ]] || complain "statistics: $field is not that of the last frame"
done
# an object on its way, without solving for it
printf '%s\n' 'v 0 0 0' 'v 0.15 0 0' 'v 0 0 -0.15' 'v 0 0.15 0' 'f 1 3 2' 'f 1 2 4' 'f 2 3 4' 'f 1 4 3' >body.obj
printf '%s\n' '0 place.object=-0.4,0.1,-0.1' '1 place.object=-0.2,0.2,-0.1' >way.txt
succeeds relight box.safetensors --object body.obj --script way.txt -o way%d.png "${box[@]}" --mode operator
cmp -s way0.png way1.png && complain "the object stays where it was"
refuses 1 'no object' relight box.safetensors --script way.txt -o "$out/a%d.png"
refuses 2 'mode operator' relight box.safetensors --object body.obj --script way.txt -o "$out/a%d.png"
refuses 1 'a frame number' relight box.safetensors --script evening.txt -o "$out/a.png"
refuses 1 'a frame number' relight box.safetensors --script evening.txt -o "$out/a%d%d.png"
refuses 1 'none.txt' relight box.safetensors --script none.txt -o "$out/a%d.png"
for line in '9 lamp=1' '9 light.light=1,2' '9 env-rotate=x' 'nine light.light=1' '-1 light.light=1' '2 light.light=1' '9 albedo.=1,1,1'; do
    printf '3 light.light=1\n%s\n' "$line" >bad.txt
    refuses 1 'bad.txt:2: ' relight box.safetensors --script bad.txt -o "$out/a%d.png"
done
: >empty.txt
refuses 1 'changes nothing' relight box.safetensors --script empty.txt -o "$out/a%d.png"

refuses 1 'no environment' relight box.safetensors --env-rotate 5 -o "$out/a.png"
refuses 1 "'moon'.*'light'" relight box.safetensors --light moon=2 -o "$out/a.png"
refuses 1 "'gold'.*'white'" relight box.safetensors --albedo gold=1,1,0 -o "$out/a.png"
refuses 1 'environment' relight box.safetensors --env-intensity 2 -o "$out/a.png"
mkdir -p folder.safetensors
refuses 1 'is a folder' relight folder.safetensors -o "$out/a.png"
refuses 1 'folder.safetensors: cannot be read' relight box.safetensors --script folder.safetensors -o "$out/a%d.png"
refuses 1 'not an operator file' relight cornell-blocks -o "$out/a.png"
refuses 1 'No such file' relight none.safetensors -o "$out/a.png"
refuses 1 'camera' relight box.safetensors --camera nobody -o "$out/a.png"
refuses 1 'folder' relight box.safetensors -o no/such/folder/a.safetensors
refuses 2 'NAME=SCALE' relight box.safetensors --light light -o "$out/a.png"
refuses 2 'NAME=SCALE' relight box.safetensors --light light=1,2 -o "$out/a.png"
succeeds relight box.safetensors --add spark=0.3,0.3,0.3,0.1 --light light=0 --light spark=1,1,0.2,0.2 -o spark.exr "${box[@]}" --mode operator
succeeds compare once.exr spark.exr
says '^mean_ratio *0*[0-9.]*[1-9]'
refuses 1 'already' relight box.safetensors --add light=0,0,0,1 -o "$out/a.png"
refuses 2 'NAME=X,Y,Z,I' relight box.safetensors --add spark=1,2,3 -o "$out/a.png"
refuses 1 "'moon'.*'light'" relight box.safetensors --move moon=0,1,0 -o "$out/a.png"
refuses 1 'moved by' relight box.safetensors --move light=0,1e9,0 -o "$out/a.png"
refuses 2 'NAME=X,Y,Z' relight box.safetensors --move light=1 -o "$out/a.png"
refuses 2 'MATERIAL=R,G,B' relight box.safetensors --albedo white=1 -o "$out/a.png"
refuses 2 'missing' relight box.safetensors
finish
