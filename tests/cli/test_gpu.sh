#!/usr/bin/env bash
# --device: GPU results, with the GPU emulated on the CPU, and messages where there is none.
source "$(dirname "$0")/support.sh"
export CUDA_VISIBLE_DEVICES=

draft=(--quality draft --max-elements 400)

# -- the same pictures

succeeds render cornell-spheres -o here.exr "${small[@]}" --max-elements 400
succeeds render cornell-spheres -o there.exr "${small[@]}" --max-elements 400 --device emulated --stats there.json
grep -q '"device":[[:space:]]*"emulated device"' there.json || complain "the statistics do not name the device"
succeeds compare here.exr there.exr --json
ratio=$(sed -n 's/.*"mean_ratio":[[:space:]]*\([0-9.]*\).*/\1/p' stdout)
[[ $ratio == 1 || $ratio == 1.0000* || $ratio == 0.9999* ]] || complain "mean ratio '$ratio' between devices"

# -- ambient occlusion

for mode in occlusion occlusion-screen; do
    for device in cpu emulated; do
        succeeds render cornell-spheres -o $device.exr "${small[@]}" --mode $mode --device $device
    done
    succeeds compare cpu.exr emulated.exr --json
    ratio=$(sed -n 's/.*"mean_ratio":[[:space:]]*\([0-9.]*\).*/\1/p' stdout)
    [[ $ratio == 1 || $ratio == 1.000* || $ratio == 0.999* ]] || complain "mean ratio '$ratio' between devices, mode $mode"
done

# -- relighting

succeeds solve cornell-blocks -o blocks.safetensors "${draft[@]}" --device emulated --solver chebyshev
for device in cpu emulated; do
    succeeds relight blocks.safetensors -o $device.exr --light light=0.5 --size 32x24 --spp 1 --device $device
done
succeeds compare cpu.exr emulated.exr --json
ratio=$(sed -n 's/.*"mean_ratio":[[:space:]]*\([0-9.]*\).*/\1/p' stdout)
[[ $ratio == 1 || $ratio == 1.0000* || $ratio == 0.9999* ]] || complain "mean ratio '$ratio' between devices"

# -- frames

succeeds solve cornell-blocks -o box.safetensors "${draft[@]}"
echo '0 show hud' >plain.txt # it counts milliseconds
for device in cpu emulated; do
    succeeds view box.safetensors --size 48x32 --script plain.txt --frames 2 --record $device --device $device
done
# at rest, frames of processors go on to mode final; those of devices do not
succeeds compare cpu/frame-0000.png emulated/frame-0000.png --json
ratio=$(sed -n 's/.*"mean_ratio":[[:space:]]*\([0-9.]*\).*/\1/p' stdout)
[[ $ratio == 1 || $ratio == 1.0000* || $ratio == 0.9999* ]] || complain "mean ratio '$ratio' between frames"

# -- the bench

succeeds bench gpu cornell-blocks --quality draft --repeat 1 --device emulated --stats bench.json
says '^| the same, relative to the copy | [0-9.]* % | 60 % |'
says '^| bicgstab to a residual of 1e-05'
says '^| 1000000 receivers relit'
says '^| shadow rays of direct light, .* | [0-9.]* M/s |'
says '^| frames of 192x108 | [0-9.]*/s |'
grep -q '"name":[[:space:]]*"emulated device"' bench.json || complain "the JSON does not name the device"
refuses 1 'which device' bench gpu

# -- figure 8

succeeds bench fig8 cornell-blocks --repeat 1 --device emulated --stats fig8.json
says '^Frames per second on emulated device at 64x36'
says '^| 3096 KB | [0-9]* | [0-9.]* | [0-9.]* | [0-9.]* | [0-9.]* | [0-9.]* |$'
grep -q '"name":[[:space:]]*"emulated device"' fig8.json || complain "the JSON does not name the device"

# -- no device

refuses 1 'device: ' solve cornell-blocks -o no.safetensors "${draft[@]}" --device cuda
succeeds solve cornell-blocks -o auto.safetensors "${draft[@]}" --device auto
grep -q 'note: device: .*computing on the CPU' stderr || complain "--device auto does not say that there is none"
refuses 2 'device' solve cornell-blocks -o no.safetensors --device tpu
refuses 1 'device' render furnace -o no.png "${small[@]}" --mode reference --device auto

finish
