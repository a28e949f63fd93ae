#!/usr/bin/env bash
# Animated glTF files: lists of animations, pictures at given times, sequences.
source "$(dirname "$0")/support.sh"
quick=(--size 32x32 --spp 2 --quality draft --max-elements 1500)

succeeds scene cornell-blocks -o room.glb
python3 "$here/animate.py" room.glb moving.glb short 0 0 0.2 || complain "cannot animate"

succeeds info moving.glb
says 'slide  0 s to 1 s, 1 channels'
succeeds info moving.glb --json
says '"name":[[:space:]]*"fall"'

succeeds render room.glb -o rest.exr "${quick[@]}"
succeeds render moving.glb -o start.exr "${quick[@]}" --time 0
warns "2 animations: 'slide' is played"
cmp -s rest.exr start.exr || complain "the first moment is not the room at rest"
succeeds render moving.glb -o end.exr "${quick[@]}" --time 7 --clip slide
cmp -s rest.exr end.exr && complain "nothing moved"
succeeds info moving.glb --time 1 --clip all

# frames equal pictures of those moments, whatever is reused from the previous frame, for any number of threads
succeeds render moving.glb -o frame-%02d.exr "${quick[@]}" --frames 0-2 --fps 2 --stats frames.json --threads 1
grep -q '"frames":[[:space:]]*3' frames.json || complain "no number of frames in the statistics"
grep -q '"kept_row_rays_of_all_frames":[[:space:]]*0,' frames.json && complain "no ray was kept"
succeeds render moving.glb -o again-%d.exr "${quick[@]}" --frames 0-2 --fps 2 --threads 2
for k in 0 1 2; do cmp -s frame-0$k.exr again-$k.exr || complain "threads change frame $k"; done
cmp -s frame-00.exr start.exr || complain "frame 0 is another picture than --time 0"
succeeds compare frame-02.exr end.exr
python3 - "$(sed -n 's/^mean_ratio *//p' stdout)" <<'TEXT' || complain "frame 2 is not as bright as --time 1"
import sys
sys.exit(abs(float(sys.argv[1].split()[0]) - 1) > 0.02)
TEXT

# motion blur: the mean of pictures at eight moments
still=(--size 32x32 --mode reference --clip slide)
succeeds render moving.glb -o blur-%d.hdr "${still[@]}" --spp 2 --frames 0-0 --fps 1 --shutter 0.5
k=0
for time in 0.03125 0.09375 0.15625 0.21875 0.28125 0.34375 0.40625 0.46875; do
    succeeds render moving.glb -o moment-$k.hdr "${still[@]}" --spp 2 --seed $k --time $time
    k=$((k + 1))
done
python3 "$here/mean_picture.py" blur-0.hdr moment-?.hdr || complain "--shutter: not the mean of its moments"
refuses 2 'shutter requires' render moving.glb -o "$out/x.exr" --shutter 0.5

# frames of an operator file, which has the document: relit, and as the same light solved at that moment
frames=(--mode operator --size 32x32 --spp 16)
succeeds solve moving.glb -o rest.safetensors --quality draft --max-elements 800
succeeds info rest.safetensors
says 'slide  0 s to 1 s, 1 channels'
succeeds relight rest.safetensors -o lit-%d.exr "${frames[@]}" --frames 0-2 --fps 2 --light light=0.5 --stats lit.json
warns "'slide' is played"
grep -q '"kept_row_rays_of_all_frames":[[:space:]]*0,' lit.json && complain "relight: no ray was kept"
succeeds solve moving.glb -o late.safetensors --quality draft --max-elements 800 --time 1
succeeds relight late.safetensors -o lit.exr "${frames[@]}" --light light=0.5
succeeds compare lit-2.exr lit.exr
says '^relative_mse *0.000'
says '^mean_ratio *\(1.00\|0.99\)'
succeeds compare lit-0.exr lit.exr
says '^relative_mse *0.[1-9]' # the block has moved
succeeds relight rest.safetensors -o open-%d.exr "${frames[@]}" --frames 1-1 --fps 2 --light light=0.5 --shutter 0.01
succeeds compare open-1.exr lit-1.exr
says '^relative_mse *0.00'
says '^mean_ratio *\(1.00\|0.99\)'
refuses 1 'keeps no glTF file' relight late.safetensors -o "$out/x%d.png" --frames 0-1
refuses 1 'do not fit' relight rest.safetensors -o "$out/x%d.png" --frames 0-1 --move light=0.1,0,0
refuses 1 'writes pictures only' relight rest.safetensors -o "$out/x%d.safetensors" --frames 0-1
refuses 1 'with --frames, the name' relight rest.safetensors -o "$out/x.png" --frames 0-1
refuses 1 "no animation 'rise'" relight rest.safetensors -o "$out/x%d.png" --frames 0-1 --clip rise
refuses 2 'clip requires' relight rest.safetensors -o "$out/x.png" --clip slide
refuses 1 'resolvent relight' render rest.safetensors -o "$out/x%d.png" --frames 0-1

# in the view: playing, and jumping to a time
printf '%s\n' '0 show hud' '0 show markers' '0 exposure 0' '1 play' '4 pause' '10 scrub 1' '30 screenshot played.exr' >play.txt
view=(view moving.glb --quality draft --size 96x64 --script play.txt --frames 31)
succeeds "${view[@]}" --record played --threads 2
for pair in '0001 0003' '0008 0012'; do
    read -r a b <<<"$pair"
    cmp -s played/frame-$a.png played/frame-$b.png && complain "nothing moves from frame $a to $b"
done
succeeds render moving.glb -o there.exr --size 96x64 --spp 16 --mode operator --quality draft --time 1
succeeds compare there.exr played.exr
says '^mean_ratio *\(1.0[01]\|0.9[89]\)'
# within a budget, objects wait for their turn; in the end all is as without
python3 "$here/animate.py" room.glb blocks.glb block 0 0 0.1 || complain "cannot animate"
printf '%s\n' '0 show hud' '0 show markers' '1 scrub 0.5' '4 scrub 1' '70 screenshot late.exr' >scrub.txt
view=(view blocks.glb --quality draft --max-elements 700 --size 48x32 --exposure 0 --script scrub.txt --frames 71)
succeeds "${view[@]}" --record rest
mv late.exr rest.exr
if SDL_VIDEODRIVER=dummy "$program" "${view[@]}" --budget 0.01 --stats late.json >stdout 2>stderr; then
    grep -q '"late_steps":[[:space:]]*[1-9]' late.json || complain "nothing waited: $(cat late.json)"
    succeeds compare rest.exr late.exr
    says '^mean_ratio *\(1.00\|0.99\)'
    says '^median_relative_error *0.00'
else
    grep -q 'without SDL2' stderr || complain "the view failed: $(cat stderr)"
fi
sed 's/"path": "translation"/"path": "scale"/; s/\[0, 0, 0\] + to/[1, 1, 1] + to/' "$here/animate.py" >shrink.py
python3 shrink.py room.glb shrink.glb short 0 0 0 || complain "cannot animate"
printf '%s\n' '0 show hud' '1 scrub 0.5' '2 scrub 1' >scrub.txt
refuses 1 'different triangles.*solve the scene again' view shrink.glb --quality draft --max-elements 700 --size 48x32 \
    --script scrub.txt --frames 4 --record "$work/x"
rm -rf "$work/x"
refuses 2 "'0' is not a number from 0.01" view blocks.glb --budget 0

printf '0 play\n' >play.txt
refuses 1 'only glTF files are played' view cornell-blocks --quality draft --size 32x32 --script play.txt --record "$out/x"

refuses 1 "has no animation 'rise'" render moving.glb -o "$out/x.exr" "${quick[@]}" --time 0 --clip rise
refuses 1 'holds no animation' render room.glb -o "$out/x.exr" "${quick[@]}" --time 0
refuses 1 'only glTF files are animated' render cornell-blocks -o "$out/x.exr" "${quick[@]}" --time 0
refuses 1 'must contain a frame number' render moving.glb -o "$out/x.exr" --frames 0-2
refuses 2 'clip requires' render moving.glb -o "$out/x.exr" --clip slide
refuses 2 'exclude each other' render moving.glb -o "$out/x%d.exr" --frames 0-1 --time 3
refuses 2 "'5-2' is not A-B" render moving.glb -o "$out/x%d.exr" --frames 5-2
refuses 2 "'-3' is not A-B" render moving.glb -o "$out/x%d.exr" --frames=-3
refuses 2 'fps requires' render moving.glb -o "$out/x.exr" --fps 3
refuses 2 'not supported with --frames' render moving.glb -o "$out/x%d.exr" --frames 0-1 --error 3%
succeeds solve moving.glb -o "$work/moving.safetensors" --quality draft --max-elements 800 --time 0.5
refuses 1 'for one moment' render moving.safetensors -o "$out/x.exr" --time 0

finish
