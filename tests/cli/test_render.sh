#!/usr/bin/env bash
# Pictures: all modes and formats, the same bytes for any number of threads, statistics, comparison.
source "$(dirname "$0")/support.sh"

draft=(--size 48x32 --quality draft --max-elements 500 --spp 2)
for mode in final operator reference; do
    certificate=--certificate
    [[ $mode == final ]] || certificate=
    for threads in 1 2; do
        succeeds render cornell-spheres -o "$mode$threads.exr" -o "$mode$threads.png" "${draft[@]}" \
            --mode $mode --threads $threads --layers --stats "$mode$threads.json" $certificate
        [[ ! -s stdout ]] || complain "render printed on standard output"
    done
    for format in exr png; do
        cmp -s "${mode}1.$format" "${mode}2.$format" || complain "$mode: threads change the $format"
    done
done

keys=(elements entries rays rays_per_second time_s load bvh assemble solve render total iterations norm_inf
    peak_rss_bytes residual_inf truncation_bound solver solver_reason spectral_radius neumann_terms order_count direct_elements stop_reason mode quality
    width height spp threads seed warnings certificate samples residual_rms residual_ci95 error_bound_rms
    error_estimate_rms irradiance_rms)
for key in "${keys[@]}"; do
    grep -q "\"$key\":" final2.json || complain "the statistics lack '$key'"
done
grep -q '"certificate":[[:space:]]*null' operator2.json || complain "a certificate that nobody asked for"
grep -q '"stop_reason":.*"converged"' final2.json || complain "the solution did not converge"
! grep -q '"elements":[[:space:]]*0,' final2.json || complain "no elements"

for solver in two-grid gmres southwell; do
    succeeds render furnace -o $solver.exr --size 16x16 --quality draft --spp 1 --solver $solver \
        --stats $solver.json
    grep -q "\"solver\":[[:space:]]*\"$solver\"" $solver.json || complain "--solver $solver was not heard"
done

succeeds compare final1.exr operator1.exr
says '^mean_ratio '
says '^median_relative_error '
succeeds compare final1.exr final2.exr --layer direct --json
says '"rmse":[[:space:]]*0,'
refuses 1 "has no layer 'rainbow'" compare final1.exr final2.exr --layer rainbow
succeeds solve cornell-spheres -o solved.safetensors --quality draft --max-elements 500
succeeds render solved.safetensors -o calm.exr "${draft[@]}" --noise 5%
! cmp -s calm.exr final1.exr || complain "--noise changes nothing"
refuses 1 "leave out" render furnace -o no.exr --mode reference --noise 2%
for threads in 1 3; do
    succeeds render solved.safetensors -o filtered$threads.exr "${draft[@]}" --denoise --threads $threads
done
cmp -s filtered1.exr filtered3.exr || complain "the filter depends on the number of threads"
! cmp -s filtered1.exr final1.exr || complain "--denoise changes nothing"
refuses 2 "exclude each other" render furnace -o no.exr --denoise --no-denoise
refuses 2 "exclude each other" render furnace -o no.exr --denoise --mode reference
refuses 2 "exclude each other" render furnace -o no.exr --denoise --layers
medium=(--size 16x16 --quality medium)
succeeds render solved.safetensors -o even.exr "${medium[@]}" --spp 9
succeeds render solved.safetensors -o zero.exr "${medium[@]}" --noise 0
succeeds render solved.safetensors -o usual.exr "${medium[@]}"
cmp -s even.exr zero.exr || complain "--spp does not mean as many rays everywhere"
! cmp -s usual.exr zero.exr || complain "noisy pixels get no more rays"
succeeds compare reference1.exr final1.exr --twin reference1.exr
says without_noise
succeeds compare reference1.exr reference1.exr
says '^mean_ratio *1.000000'

succeeds render cornell-spheres -o seed.exr "${draft[@]}" --seed 7
! cmp -s seed.exr final1.exr || complain "the seed changes nothing"
succeeds render solved.safetensors -o bright.png -o bright.hdr "${draft[@]}" --exposure=2
! cmp -s bright.png final1.png || complain "the exposure changes nothing"
[[ -s bright.hdr ]] || complain "no .hdr"
succeeds render solved.safetensors -o flat.png "${draft[@]}" --layers
warns '\.exr'

succeeds layers operator1.exr -o sheet.png --columns 2 --count 3
[[ $(cut -d' ' -f1 stdout | xargs) == 'emission direct bounce1' ]] || complain "not the orders' names"
refuses 1 'has no layers' layers sheet.png -o "$out/nothing.png"

# -- occlusion, differences and sheets

for mode in occlusion occlusion-screen; do
    succeeds render cornell-blocks -o $mode.exr "${small[@]}" --mode $mode --occlusion-distance 0.2
done
succeeds compare occlusion.exr occlusion-screen.exr -o difference.exr --gain 4
succeeds compare occlusion.exr occlusion.exr
says '^rmse  *0$'
succeeds sheet occlusion.exr occlusion-screen.exr difference.exr -o sheet.exr --columns 2
succeeds render cornell-blocks -o larger.exr --size 40x24 --mode occlusion --spp 1
refuses 1 'larger.exr' sheet occlusion.exr larger.exr -o "$out/a.png"
# -- surroundings without a file

cat >card.obj <<'TEXT'
v -1 0 1
v 1 0 1
v 1 0 -1
v -1 0 -1
f 1 2 3 4
TEXT
succeeds render card.obj -o dark.png "${draft[@]}"
grep -q 'env sky' stderr || complain "a scene without light names no way to light it"
for name in white sky; do
    succeeds render card.obj -o $name.png "${draft[@]}" --env $name
    ! grep -q 'no light' stderr || complain "--env $name does not light the scene"
done
refuses 1 'night' render card.obj -o night.png "${draft[@]}" --env night

finish
