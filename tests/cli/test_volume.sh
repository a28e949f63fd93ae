#!/usr/bin/env bash
# Fog from OpenVDB files. The second argument writes such files; without it, this build does not read them.
source "$(dirname "$0")/support.sh"
maker=${2:-}

refuses 2 'requires --fog' render furnace -o "$out/a.png" --volume ball.vdb
if [[ -z $maker ]]; then
    : >ball.vdb
    refuses 1 'libopenvdb-dev' info furnace --fog 1 --volume ball.vdb
    finish
fi
"$maker" . || complain "no files were made"

# -- a good file

succeeds info furnace --fog 2,0.5 --volume ball.vdb
says 'on a grid of 15 x 15 x 15 points'
says 'from (0.0625 0.0625 0.0625) to (0.9375 0.9375 0.9375)'
succeeds render furnace -o ball.exr "${small[@]}" --fog 2,0.5 --volume ball.vdb
succeeds render furnace -o path.exr "${small[@]}" --mode reference --fog 2,0.5 --volume ball.vdb
succeeds solve furnace -o ball.safetensors --quality draft --threads 2 --fog 2,0.5 --volume ball.vdb
succeeds info ball.safetensors
says 'on a grid of 15 x 15 x 15 points'
succeeds render ball.safetensors -o again.exr --size 32x24 --spp 1 --threads 2
succeeds compare ball.exr again.exr
says 'rmse  *0$'

# -- bad ones

for pair in "half:damaged" "vectors:velocity" "empty:is empty" "none:no grid" "huge:1000 x 1000 x 1000" \
    "endless:background density" "negative:0 or more" "turned:along the axes" "surface:no level set"; do
    file=${pair%%:*}.vdb
    refuses 1 "$file: .*${pair#*:}" render furnace -o "$out/a.png" "${small[@]}" --fog 1 --volume $file
done
refuses 1 'missing.vdb: cannot be opened' info furnace --fog 1 --volume missing.vdb
refuses 1 'damaged or no OpenVDB' info furnace --fog 1 --volume ball.exr
: >nothing.vdb
refuses 1 'damaged or no OpenVDB' info furnace --fog 1 --volume nothing.vdb
refuses 1 'height' info furnace --fog 1 --fog-height 2 --volume ball.vdb
finish
