#!/usr/bin/env bash
# The window of the sample, rendered in software on a virtual display: it shows the same picture as `render`.
# usage: test_window.sh PROGRAM WINDOW
source "$(dirname "$0")/support.sh"
window=$2

skip() {
    echo "skipped: $*"
    exit 77
}

command -v Xvfb >/dev/null || skip "Xvfb is not installed"
open_display 640x640
export LIBGL_ALWAYS_SOFTWARE=1

succeeds bake cornell-blocks -o box.glb --to vertex --basis --quality draft --max-elements 1500
if ! "$window" box.glb box.light.safetensors 3 shown.png 2>stderr; then
    grep -q 'GLX\|EGL\|OpenGL\|GL context' stderr && skip "no OpenGL 3.3: $(cat stderr)"
    complain "the window fails"
fi
succeeds render cornell-blocks -o ours.png --mode operator --quality draft --max-elements 1500 --size 512x512 --spp 4
succeeds compare ours.png shown.png
# the window draws the border of the lamp, which is far beyond white, without smoothing it: that alone is 1 % of the mean
says '^mean_ratio *\(0.9[89]\|1.0[01]\)'
says '^relative_mse *[0-9.]*e-0[3-9]\|^relative_mse *0.00'

# vertex colours and cut-outs of the file with baked light, and a scene without a camera, framed as in `render`
# it. The lamp's border is a larger part of these darker pictures
succeeds scene cornell-blocks -o plain.glb
for box in colored framed; do
    python3 "$here/change_box.py" $box plain.glb $box.glb || complain "the $box box cannot be made"
    succeeds bake $box.glb -o lit.glb --to vertex --basis --quality draft
    "$window" lit.glb lit.light.safetensors 3 shown.png 2>stderr || complain "the $box box is not shown"
    succeeds render $box.glb -o own.png --mode operator --quality draft --size 512x512 --spp 4 --exposure 0
    succeeds compare own.png shown.png
    says '^mean_ratio *\(0.9[6-9]\|1.0[01]\)'
    says '^relative_mse *[0-9.]*e-0[3-9]\|^relative_mse *0.00'
done

"$window" /dev/null box.light.safetensors 2>stderr && complain "an empty scene is shown"
warns 'not a .glb'
"$window" box.glb /dev/null 2>stderr && complain "an empty basis is taken"
warns 'too short'
head -c 100000 box.glb >cut.glb
"$window" cut.glb box.light.safetensors 2>stderr && complain "half a scene is shown"
warns 'cut off'
# light in a lightmap, as baked and at half strength
succeeds bake cornell-blocks -o map.glb --to lightmap --basis --map-size 256 --quality draft --max-elements 1500
"$window" map.glb map.light.safetensors 3 shown.png 2>stderr || complain "a lightmap is not shown"
succeeds compare ours.png shown.png
says '^mean_ratio *\(0.9[89]\|1.0[01]\)'
says '^relative_mse *[0-9.]*e-0[3-9]\|^relative_mse *0.00'
python3 - map.light.safetensors half.light.safetensors <<'PYTHON' || complain "no basis of half the light"
import array, sys
data = open(sys.argv[1], "rb").read()
begin = 8 + int.from_bytes(data[:8], "little")
values = array.array("f", data[begin:])
open(sys.argv[2], "wb").write(data[:begin] + array.array("f", (v / 2 for v in values)).tobytes())
PYTHON
"$window" map.glb half.light.safetensors 3 half.png 2>stderr || complain "a relit lightmap is not shown"
succeeds compare shown.png half.png
says '^median_relative_error *0\.\(49[5-9]\|50[0-5]\|5$\)'
# light that is nowhere, or in another file
"$window" plain.glb box.light.safetensors 2>stderr && complain "a scene without light is shown"
warns 'error: it carries no baked light: .*bake --basis'
"$window" map.glb box.light.safetensors 2>stderr && complain "the basis of vertices is taken for a lightmap"
warns 'not baked with that basis'
"$window" box.glb map.light.safetensors 2>stderr && complain "the basis of another file is taken"
warns 'not baked with that basis'
finish
