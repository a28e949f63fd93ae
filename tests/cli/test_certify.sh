#!/usr/bin/env bash
# Certificates: output and files, identical for any number of threads, and refusals.
source "$(dirname "$0")/support.sh"

for threads in 1 2; do
    succeeds certify furnace --quality draft --samples 64 --rays 32 --threads $threads \
        --stats furnace$threads.json
    cp stdout furnace$threads
done
cmp -s furnace1 furnace2 || complain "threads change the certificate"
says '^irradiance .* W/m2'
says '^residual .*95 %:'
says '^bound '
says '^estimate .*95 %:'
for key in certificate samples residual_rms residual_ci95 error_bound_rms error_estimate_rms irradiance_rms; do
    grep -q "\"$key\":" furnace1.json || complain "the statistics lack '$key'"
done
succeeds certify furnace --quality draft --samples 64 --rays 32 --seed 5
! cmp -s stdout furnace1 || complain "the seed changes nothing"

for threads in 1 2; do
    succeeds certify cornell-blocks --quality draft --samples 16 --rays 8 --threads $threads \
        --heatmap heat$threads.exr --size 48x40
done
cmp -s heat1.exr heat2.exr || complain "threads change the picture of the error"
succeeds certify furnace --quality draft --samples 16 --rays 8 --heatmap heat.png --size 32x32
[[ -s heat.png ]] || complain "no picture of the error"

succeeds certify furnace --quality draft --error 3%
succeeds certify furnace --quality draft --samples 16 --rays 8 --goal --split --stats goal.json
says '^sampling '
grep -q '"discretisation":' goal.json || complain "the statistics lack the split"
says '^picture .* missing'
grep -q '"goal_certificate":' goal.json || complain "the statistics lack the goal"
printf '0.1,0.2,0.1,0,1,0\n-0.1,0.2,0.1,0,0,1\n' >points.csv
succeeds certify furnace --quality draft --samples 16 --rays 8 --points points.csv --stats points.json
says '^points .* missing'
grep -q '"goal_certificate":' points.json || complain "the statistics lack the points"
refuses 2 'exclude each other' certify furnace --goal --points points.csv
refuses 1 'absent.csv' certify furnace --points absent.csv
succeeds render furnace -o goal.exr --quality draft --size 16x16 --goal
succeeds certify cornell-blocks --quality draft --error 0.001 --max-elements 1000
warns 'budget of elements'
refuses 2 'share from 0.01% to 100%' certify furnace --error 0
refuses 2 'share from' certify furnace --error 200%
refuses 2 'share from' render furnace -o "$out/a.png" --error %

refuses 1 'camera' certify furnace --heatmap "$out/a.png" --camera nobody
refuses 1 'heat.tiff' certify furnace --heatmap "$out/heat.tiff"
refuses 2 'WIDTHxHEIGHT' certify furnace --heatmap "$out/a.png" --size 8x8
refuses 2 'SCENE is missing' certify
refuses 2 '16 to 16777216' certify furnace --samples 0
refuses 2 '16 to 16777216' certify furnace --samples -4
refuses 2 '16 to 16777216' certify furnace --samples 99999999999
refuses 2 '1 to 65536' certify furnace --rays 0
refuses 1 'no such file' certify "$work/absent.glb"
refuses 1 'absent' certify furnace --stats "$work/absent/stats.json"

finish
