#!/usr/bin/env bash
# Help goes to standard output; wrong usage gives one line and exit status 2.
source "$(dirname "$0")/support.sh"

succeeds --help
says 'usage: resolvent'
succeeds --version
succeeds help render
says 'usage: resolvent render'
# the first screen has three examples and the common options, and says how to see the rest
says 'resolvent render --help all'
[[ $(grep -c '^  resolvent ' stdout) == 3 ]] || complain "not three examples"
[[ $(wc -l <stdout) -le 45 ]] || complain "the help of render fills more than a screen"
says '  --quality'
! grep -q -- '--gather' stdout || complain "--gather is no common option"
succeeds render --help all
says '  --gather'
succeeds help render all
says '  --gather'
refuses 2 'is not a command' help paint
for command in render solve relight view probe daylight certify compare layers falsecolor sheet scene info bench; do
    succeeds $command --help
    says "usage: resolvent $command"
    says 'examples:'
    refuses 2 "resolvent $command --help" $command --no-such-option
done
for name in cornell-blocks cornell-spheres cornell-glass cornell-marble cornell-plaster cornell-showcase character furnace two-rooms gallery terraces fog-rooms milk; do
    succeeds scene --help
    says $name
done

"$program" info furnace >/dev/full 2>stderr && complain "results lost on a full disk are a success"

refuses 2 'no command'
refuses 2 'is not a command' paint
refuses 2 "did you mean 'render'" rendr
refuses 2 "did you mean '--spp'" render furnace -o "$out/a.png" --spq=3
refuses 1 "did you mean 'furnace'" info furnac
refuses 1 "did you mean 'white'" render furnace -o "$out/a.png" --env wihte
refuses 2 'SCENE is missing' render -o "$out/a.png"
refuses 2 'is missing' render furnace
refuses 2 'one argument too many' render furnace two-rooms -o "$out/a.png"
refuses 2 'needs a value' render furnace -o
refuses 2 'needs a value' render furnace -o "$out/a.png" --camera --layers
refuses 2 'requires --error' render furnace -o "$out/a.png" --max-time 5 --mode operator
refuses 2 'requires --error' render furnace -o "$out/a.png" --max-time 5 --quality draft
refuses 1 '0.5 % and more' render furnace -o "$out/a.png" --error 0.1%
refuses 2 'requires --heatmap' certify furnace --size 64x64
refuses 1 'solves nothing' render furnace -o "$out/a.png" --mode reference --error 1%
refuses 1 "'': there is no such file" info ''
refuses 2 'takes no value' render furnace -o "$out/a.png" --layers=yes
for size in 0x10 10 10x 10x-1 axb 10x10x10 1e9x1 '' 99999999999999999999x1; do
    refuses 2 'WIDTHxHEIGHT' render furnace -o "$out/a.png" --size "$size"
done
refuses 2 'one of operator, final, reference, occlusion, occlusion-screen' render furnace -o "$out/a.png" --mode fast
refuses 2 'a number from' render furnace -o "$out/a.png" --occlusion-distance -1
refuses 2 'one of draft, medium, high' render furnace -o "$out/a.png" --quality=best
refuses 2 'whole number' render furnace -o "$out/a.png" --spp 0
refuses 2 'whole number' render furnace -o "$out/a.png" --spp 1.5
refuses 2 'whole number' render furnace -o "$out/a.png" --seed -1
refuses 2 'whole number' render furnace -o "$out/a.png" --threads 1025
refuses 2 'a number from' render furnace -o "$out/a.png" --exposure nan
refuses 2 'points' probe furnace -o "$out/a.csv"
refuses 2 'A B' compare one.exr
refuses 2 'NAME' scene -o "$out/a.glb"
refuses 2 '.glb' scene furnace -o "$out/a.obj"
refuses 2 'not a benchmark' bench weather
refuses 2 'belong to bench quality' bench trace --plot "$out/a.svg"
refuses 2 'even number' bench quality --reference one.exr
refuses 2 'is missing' layers one.exr
refuses 1 'one.exr' layers one.exr -o "$out/a.png"
refuses 2 'is missing' sheet -o "$out/a.png"
refuses 2 'is missing' sheet one.exr
refuses 1 'one.exr' sheet one.exr -o "$out/a.png"
refuses 2 '268435456 pixels' render cornell-blocks -o "$out/a.png" --size 32768x32768
finish
