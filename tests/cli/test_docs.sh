#!/usr/bin/env bash
# The commands of "Start here", and with `whole` those of "An office", do what the pages say they do.
# usage: test_docs.sh PROGRAM PAGE [whole]
source "$(dirname "$0")/support.sh"

page=$2
PATH=$(dirname "$program"):$PATH
sed -n '/^```sh$/,/^```$/{/^```/d;p}' "$page" >commands.sh
# smaller pictures and maps, and coarser elements, are as good a test for every day
[[ -n ${3:-} ]] || sed -i 's/480x270/160x90/;s/--quality draft/& --max-elements 1500/;s/--to lightmap/& --map-size 128/
    s/render cornell-spheres/& --size 64x64/' commands.sh
[[ -s commands.sh ]] || complain "the page holds no commands"
bash -euo pipefail commands.sh >log 2>&1 || {
    complain "a command of the page failed"
    tail -n 5 log
}
for picture in spheres room again evening evening-00 evening-05; do
    [[ -s $picture.png ]] || complain "$picture.png is missing"
done
for file in desk-light.csv baked.glb baked-map.glb baked-map.lightmap.exr probes.json probes.probes.bin; do
    [[ -s $file ]] || complain "$file is missing"
done
docs=$(dirname "$page")
if [[ -n ${3:-} ]]; then
    sed -n '/^```sh$/,/^```$/{/^```/d;p}' "$docs/office.md" | sed "s|samples/office|$docs/../samples/office|" >office.sh
    cp "$docs/../tests/fuzz/seeds/day.epw" chicago.epw
    bash -euo pipefail office.sh >log 2>&1 || {
        complain "a command of the office failed"
        tail -n 5 log
    }
    grep -q 'illuminance: *mean 65[0-9]' log || complain "the desks have another illuminance than the page says"
    for file in isolux.png dimming.csv office.html desks-daylight.csv; do
        [[ -s $file ]] || complain "$file is missing"
    done
fi
# every example of all pages: its command and options exist
mapfile -t examples < <(cat "$docs"/*.md "$docs"/benchmarks/*.md "$docs/../README.md" |
    sed -n 's/"[^"]*"//g; s/ && /\n/g; s/^ *\(mpirun -n [0-9]* \)\{0,1\}\(resolvent [a-z]\)/\2/p' | grep '^resolvent ' | sort -u)
((${#examples[@]} > 30)) || complain "only ${#examples[@]} examples were found"
for example in "${examples[@]}"; do
    read -r _ command rest <<<"$example"
    [[ -s $command.help ]] || "$program" "$command" --help all >"$command.help" || complain "no such command: $example"
    for option in $(grep -oE -- ' --?[a-z][a-z-]*' <<<" $rest"); do
        grep -qE -- "(^|[ ,])$option([ ,=]|\$)" "$command.help" || complain "$option is no option: $example"
    done
done
# pages that it points to
grep -o '](\([^)#]*\)' "$page" | cut -c3- | while read -r target; do
    [[ -e $(dirname "$page")/$target ]] || echo "$target"
done >missing
[[ ! -s missing ]] || complain "links to nothing: $(cat missing)"
finish
