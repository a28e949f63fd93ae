#!/usr/bin/env bash
# The view without hands: recorded frames, files, scripts that are wrong, and a window on a display of its own.
source "$(dirname "$0")/support.sh"
unset DISPLAY WAYLAND_DISPLAY

succeeds solve cornell-blocks -o box.safetensors --quality draft --threads 2
view=(view box.safetensors --threads 2)
cat >tour.txt <<'TXT'
# a light three times as bright, then a moving camera, then every panel and mode
0    show hud
0    show markers
15   screenshot once.exr
16   select light.light
16   intensity 3
60   screenshot thrice.exr
61-62 orbit 3 -1
63   mode occlusion
64   show stereo
65   show stereo
65   mode final
67   mode error
69   add spark 0.3 0.3 0.3
70   mode operator
70   layer direct
71   layer 1
72   panorama around.png
TXT
succeeds "${view[@]}" --size 96x64 --script tour.txt --record first
[[ $(ls first | wc -l) == 73 ]] || complain "frames are $(ls first | wc -l), not 73"
for pair in '0 15' '15 40' '40 61' '61 62' '62 63' '63 64' '64 66' '66 69' '69 70' '70 71'; do
    read -r a b <<<"$pair"
    cmp -s "first/frame-00$(printf %02d "$a").png" "first/frame-00$(printf %02d "$b").png" &&
        complain "frames $a and $b are alike"
done
# at rest, frames converge to the picture of `render`, and a changed light to that of `relight`
succeeds render box.safetensors -o still.exr --mode operator --size 96x64 --spp 16 --threads 2
succeeds compare still.exr once.exr
says '^mean_ratio *\(1.00\|0.99\)'
succeeds compare once.exr thrice.exr
says '^mean_ratio *3.0'
(($(wc -c <around.png) > 20000)) || complain "there is nothing to see around the camera"
# the same frames every time, on any number of threads
succeeds "${view[@]}" --size 96x64 --script tour.txt --frames 30 --record again --threads 1
for frame in 0005 0020 0029; do
    cmp -s first/frame-$frame.png again/frame-$frame.png || complain "frame $frame differs the second time"
done
succeeds "${view[@]}" --size 64x48 --record single
[[ $(ls single) == frame-0000.png ]] || complain "without a script one frame is enough"

# an object that moves, the same way every time
cat >tetrahedron.obj <<'OBJ'
v 0 0 0
v 0.15 0 0
v 0 0 -0.15
v 0 0.15 0
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
OBJ
printf '%s\n' '0 show hud' '0 show markers' '1 place -0.4 0.1 -0.1 30' '2 select object' '2 nudge 0.05 0 0' >roll.txt
for folder in roll roll-again; do
    succeeds "${view[@]}" --size 96x64 --object tetrahedron.obj --script roll.txt --record $folder
done
for pair in '0 1' '1 2'; do
    read -r a b <<<"$pair"
    cmp -s "roll/frame-000$a.png" "roll/frame-000$b.png" && complain "the object stays where it was in frame $b"
done
cmp -s roll/frame-0002.png roll-again/frame-0002.png || complain "the object looks different the second time"
refuses 1 'nothing.obj' "${view[@]}" --object nothing.obj --record "$work/frames"
[[ ! -e $work/frames ]] # no folder is left where there are no frames

# errors in scripts are reported with their line, before anything is solved
wrong() {
    printf '%s\n' '# a comment' '0 orbit 1 1' "$1" >bad.txt
    refuses 1 "bad.txt:3: .*$2" "${view[@]}" --size 32x32 --script bad.txt --record "$work/frames"
}
wrong 'orbit 1 1' 'expected FRAME'
wrong '2-1 orbit 1 1' 'expected FRAME'
wrong '-1 orbit 1 1' 'expected FRAME'
wrong '99999999999 orbit 1 1' 'expected FRAME'
wrong '1' 'expected FRAME'
wrong '1 ' 'command is missing'
wrong '1 place 0 0 0 0' 'no object'
wrong '1 jump' 'jump.*--help'
wrong '1 orbit 1' 'orbit.*a number more'
wrong '1 orbit x 1' 'not a number'
wrong '1 quit now' 'too many'
wrong '1 select light.moon' "no 'light.moon'"
wrong '1 env-rotate 5' 'no environment'
wrong '1 camera nobody' 'no camera'
mkdir -p folder
refuses 1 'folder: cannot be read' "${view[@]}" --script folder --record "$work/frames"
refuses 1 'none.txt' "${view[@]}" --script none.txt --record "$work/frames"
refuses 1 'folder' "${view[@]}" --record no/such/folder
refuses 1 'camera' "${view[@]}" --camera nobody --record "$work/frames"
refuses 2 'SCENE' view
refuses 2 'size' "${view[@]}" --size 0x0
printf '0 screenshot no/such/folder/a.png\n' >bad.txt
refuses 1 'no/such/folder' "${view[@]}" --size 32x32 --script bad.txt --record "$work/frames"

# closed walls without absorption are refused, as in `relight`
printf '2 albedo walls 1 1 1\n' >white.txt
closed=(view furnace --quality draft --max-elements 100 --size 32x32 --threads 2)
refuses 1 'absorbs nothing.*lower an albedo' "${closed[@]}" --script white.txt --record "$work/frames"
rm -rf "$work/frames"

# no display
refuses 1 '\(no window\|no display\).*--record' "${view[@]}" --frames 1

# without a display at all, but with SDL2: frames come at once, and better light while they do
if ! grep -q 'without SDL2' stderr; then
    export SDL_VIDEODRIVER=dummy
    succeeds view cornell-blocks --frames 2 --size 64x48 --threads 2 --stats first.json
    grep -q '"sketch"' first.json || complain "there is no first frame"
    printf '0-40000 orbit 0.5 0\n' >around.txt
    for frames in 40 400 4000 40000; do # on a busy machine, light comes later
        succeeds view cornell-blocks --quality draft --script around.txt --frames $frames --size 64x48 --threads 2 \
            --stats flight.json
        grep -q '"coarse"\|"draft"' flight.json && break
    done
    grep -q '"sketch"' flight.json && grep -q '"coarse"\|"draft"' flight.json ||
        complain "the flight was not in light: $(cat flight.json)"
    # scripts that need the final light wait for it; quitting earlier does not wait
    printf '%s\n' '0 select light.light' '0 intensity 2' '1 screenshot twice.png' '2 quit' >change.txt
    succeeds view cornell-blocks --quality draft --script change.txt --size 64x48 --threads 2 --stats change.json
    grep -q '"draft"' change.json || complain "the best light was not shown"
    [[ -s twice.png ]] || complain "the picture was not taken"
    succeeds view box.safetensors --frames 3 --size 64x48 --threads 2 --stats solved.json
    grep -q '"frames":[[:space:]]*3' solved.json || complain "an operator file is not shown"
    # a failed solve is reported in one line
    refuses 1 'budget of 1 elements' view cornell-blocks --max-elements 1 --script change.txt --size 64x48 --threads 2
    unset SDL_VIDEODRIVER
    refuses 1 '\(no window\|no display\).*--record' "${view[@]}" --frames 1
fi

# a window, where there are both SDL2 and a server to show it
if grep -q 'without SDL2' stderr || ! command -v Xvfb >/dev/null; then
    echo "the window was not tested: no $(grep -q 'without SDL2' stderr && echo SDL2 || echo Xvfb) here"
    finish
fi
mkdir screen
open_display 640x480 -fbdir screen
printf '%s\n' '0 show hud' '0 show markers' '7 screenshot window.png' '8 quit' >window.txt
succeeds "${view[@]}" --size 96x64 --script window.txt
cmp -s window.png first/frame-0007.png || complain "the window shows another picture than is recorded"
# in a window, one can continue: the light is unchanged, and the next change is applied
printf '%s\n' '5 screenshot gray.exr' '6 albedo walls 1 1 1' '12 screenshot refused.exr' \
    '13 select light.walls' '13 intensity 2' '60 screenshot twice.exr' '61 quit' >white.txt
succeeds "${closed[@]}" --script white.txt
succeeds compare gray.exr refused.exr
says '^mean_ratio *\(1.000\|0.999\)'
succeeds compare gray.exr twice.exr
says '^mean_ratio *\(2.00\|1.99\)'
printf '%s\n' '0-100000 orbit 0.1 0' >window.txt
"$program" "${view[@]}" --size 400x300 --script window.txt >stdout 2>stderr </dev/null &
shown=$!
for ((k = 0; k < 600; k++)); do
    lit=$(tr -d '\0\377' <screen/Xvfb_screen0 | wc -c)
    ((lit > 100000)) && break
    kill -0 $shown 2>/dev/null || break
    sleep 0.1
done
((lit > 100000)) || complain "the screen stays dark: $lit bytes are neither black nor white"
kill -TERM $shown
wait $shown && complain "an interrupted view claims success"
grep -q cancelled stderr || complain "an interrupted view does not say so"
finish
