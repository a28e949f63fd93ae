#!/usr/bin/env bash
# Benchmarks: their output, table and plot. No test depends on the speed of the machine.
source "$(dirname "$0")/support.sh"
few=(--max-elements 300) # enough for tables and plots, whose numbers are not judged here

succeeds bench assemble --repeat 1 --quality draft "${few[@]}" --json
elements=$(sed -n 's/.*"elements":[^0-9]*\([0-9]*\).*/\1/p' stdout)
((elements > 0 && elements <= 300)) || complain "$elements elements are not at most 300"
succeeds bench assemble --repeat 1 --quality draft "${few[@]}"
says 'same packets, traced only'
succeeds bench quality --size 32 --spp 4 --repeat 1 --quality draft --csv curve.csv --plot curve.svg
says '^  final, draft '
! grep -q 'medium' stdout || complain "a better quality than the one asked for was measured"
[[ $(wc -l <curve.csv) == 6 ]] || complain "the table has not one line per picture"
grep -q '</svg>' curve.svg || complain "the plot is incomplete"
! grep -q -e nan -e inf curve.svg curve.csv || complain "the curve holds what is no number"

succeeds bench media fog-rooms --size 16 --spp 4 --quality draft --frames 2 --csv media.csv "${few[@]}"
says '^  frames, 64x36'
says 'a light dimmed'
[[ $(wc -l <media.csv) == 6 ]] || complain "the table of media has not one line per picture"

succeeds bench solvers bright-box --repeat 1 --quality draft --csv solvers.csv --plot solvers.svg "${few[@]}"
says '^  auto .*gmres '
says 'bare gather loop : application'
! grep -q 'not converged' stdout || complain "a solver gave up"
grep -q '^bright-box,two-grid,' solvers.csv || complain "the table lacks a solver"
grep -q '</svg>' solvers.svg || complain "the plot is incomplete"
! grep -q -e nan -e inf solvers.svg solvers.csv || complain "the curves hold what is no number"
succeeds bench moving turning-mirror --frames 2 --csv moving.csv "${few[@]}"
says "'mirror' moves through 2 frames"
grep -q '^turning-mirror,2,' moving.csv || complain "the table lacks the mirror"
succeeds bench fps cornell-blocks --repeat 2 --frames 4 --size 160x90 --csv fps.csv --plot fps.svg "${few[@]}"
says ' 0 allocations'
grep -q '^cornell-blocks,' fps.csv || complain "the table lacks the scene"
grep -q '</svg>' fps.svg || complain "the plot is incomplete"
! grep -q -e nan -e inf fps.svg fps.csv || complain "the bars hold what is no number"
# an operator file as it is, a scene without a camera from inside, and the JSON fields that other programs read
succeeds solve two-rooms --quality draft "${few[@]}" -o rooms.safetensors
succeeds bench fps rooms.safetensors --frames 3 --size 64x36 --json
for key in median_ms worst_ms bare_ms stages_ms; do
    says "\"$key\":"
done
says '"frames":.*3,'

mkdir kept
for run in 1 2; do
    succeeds bench rooms cornell-blocks --quick --size 64x48 --frames 2 --spp 4 --cache kept --strips kept \
        "${few[@]}" --csv rooms.csv --plot rooms.svg --stats rooms.json
done
says '^| cornell-blocks |'
[[ $(ls kept | tr '\n' ' ') == 'cornell-blocks-draft-16x12-4spp-0.exr cornell-blocks-draft-16x12-4spp-1.exr cornell-blocks-draft.safetensors cornell-blocks.png ' ]] ||
    complain "kept is $(ls kept)"
grep -q '^cornell-blocks,' rooms.csv || complain "the table lacks the scene"
grep -q '</svg>' rooms.svg || complain "the plot is incomplete"
! grep -qw -e nan -e inf rooms.svg rooms.csv || complain "the rooms hold what is no number"
for key in moving_mse resting_mse cut_mse flicker switch_ms remnant; do
    grep -q "\"$key\":" rooms.json || complain "the JSON lacks $key"
done
RSV_ASSETS='' refuses 1 'RSV_ASSETS' bench rooms modern_hall --quick
succeeds bench rooms modern_hall --quick --assets kept
says 'skipped'
refuses 2 'belong to bench rooms' bench fps cornell-blocks --quick

succeeds bench pictures cornell-blocks --quick --size 32x24 --spp 4 "${few[@]}" --cache kept --csv pictures.csv --stats pictures.json
for view in 'first picture' 'second view' 'relit view'; do
    says "^| cornell-blocks | $view | 0.02 |"
    grep -q "^cornell-blocks: $view,0.005," pictures.csv || complain "the table lacks the $view"
done
for key in relative_mse cpu_seconds reference_cpu_seconds; do
    grep -q "\"$key\":" pictures.json || complain "the JSON lacks $key"
done
succeeds bench pictures cornell-spheres "${few[@]}" --size 80x60 --max-time 1
says 'cut short'
refuses 2 'belongs to bench pictures' bench fps cornell-blocks --max-time 1
succeeds bench pictures studio --quick --assets kept
says 'skipped'
RSV_ASSETS='' refuses 1 'RSV_ASSETS' bench pictures studio --quick
refuses 2 'belongs to bench rooms' bench pictures cornell-blocks --strips kept

succeeds bench move cornell-blocks "${few[@]}" --repeat 1 --csv move.csv
says 'one light moved'
grep -q '^cornell-blocks,' move.csv || complain "the table lacks the scene"
! grep -q -e nan -e inf move.csv || complain "the table holds what is no number"
succeeds bench fig8 cornell-blocks "${few[@]}" --repeat 1 --size 90 --csv fig8.csv --plot fig8.svg
says '^| 3096 KB |'
says 'of the smallest'
[[ $(wc -l <fig8.csv) == 5 ]] || complain "the table has not one line per mesh"
grep -q '</svg>' fig8.svg || complain "the plot is incomplete"
! grep -q -e nan -e inf fig8.svg fig8.csv || complain "the bars hold what is no number"

succeeds bench scale terraces:5000 --csv scale.csv --plot scale.svg
says 'bytes per element'
grep -q '^terraces:5000,' scale.csv || complain "the table lacks the scene"
grep -q '</svg>' scale.svg || complain "the plot is incomplete"
! grep -q -e nan -e inf scale.svg scale.csv || complain "the curves hold what is no number"
PATH=$work succeeds bench cluster terraces:5000 --csv cluster.csv --plot cluster.svg
says '^     64 '
says 'no mpirun'
grep -q '^terraces:5000,' cluster.csv || complain "the table lacks the scene"
grep -q '</svg>' cluster.svg || complain "the plot is incomplete"
! grep -q -e nan -e inf cluster.svg cluster.csv || complain "the curves hold what is no number"
succeeds bench levels furnace --quality draft --max-elements 100 --csv levels.csv --plot levels.svg
says 'times those of two'
grep -q '^furnace,0,' levels.csv && grep -q '^furnace,2,' levels.csv ||
    complain "the table lacks one of the methods"
grep -q '</svg>' levels.svg || complain "the plot is incomplete"
! grep -q -e nan -e inf levels.svg levels.csv || complain "the curves hold what is no number"
refuses 2 'belongs to bench assemble, solvers, bake, levels, quality, media, rebake, moving, gpu, fps, rooms and pictures' bench trace --quality draft
refuses 2 'belongs to bench fig8, move and those' bench trace --max-elements 300
refuses 2 'belongs to bench bake, quality, media, fig8, fps, rooms and pictures' bench trace --size 64
refuses 2 'is one number' bench fig8 --size 64x36
refuses 2 '--frames belongs to bench fps, media, rooms and moving' bench trace --frames 3

refuses 2 'belong to bench' bench trace --plot trace.svg

for seed in 1 2; do
    succeeds render cornell-blocks -o small$seed.exr "${small[@]}" --mode reference --seed $seed
done
refuses 1 '256 x 256' bench quality --reference small1.exr --reference small2.exr
finish
