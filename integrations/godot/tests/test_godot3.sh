#!/usr/bin/env bash
# The scripts that Godot 3 and 4 share, in Debian's Godot 3: test_godot3.sh PROGRAM
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
program=$1
skip() {
    echo "skipped: $*"
    exit 77
}
command -v godot3 >/dev/null || skip "Godot 3 is not installed"
command -v Xvfb >/dev/null || skip "Xvfb is not installed"
source "$here/../../../tests/cli/support.sh"
open_display 64x64

succeeds bake cornell-blocks -o box.glb --to vertex --basis --quality draft --max-elements 100
succeeds bake cornell-blocks -o map.glb --to lightmap --basis --map-size 64 --quality draft --max-elements 100
succeeds bake cornell-blocks -o probes.json --to probes --spacing 0.5 --quality draft --max-elements 100
sed 's/probes.probes.bin/box.glb/' probes.json >short.json
sed 's/"size":.*/"size": [2, 0, 2],/' probes.json >flat.json
cp -r "$here/godot3" project
mkdir -p project/addons/resolvent
cp "$here"/../addons/resolvent/{light_basis,baked_document,probe_grid}.gd project/addons/resolvent
mv project/platform.gd project/addons/resolvent
export BAKED=$work HOME=$work LIBGL_ALWAYS_SOFTWARE=1
godot3 --path project --audio-driver Dummy --video-driver GLES2 -s main.gd >stdout 2>errors ||
    complain "the scripts fail: $(cat stdout)"
says '^all passed'
grep -q 'SCRIPT ERROR\|Parse Error:' errors &&
    complain "Godot reports errors in a script: $(grep -A1 'SCRIPT ERROR' errors)"
finish
