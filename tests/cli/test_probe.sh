#!/usr/bin/env bash
# Points come in as anybody writes them; a bad line is named by its number.
source "$(dirname "$0")/support.sh"

draft=(--quality draft --samples 64 --threads 2)

printf 'x,y,z,nx,ny,nz\r\n# the middle of the room\r\n\r\n0.1,0.2,0.1,0,1,0\r\n -0.1 , 0.2,0.1,0,0,1' >points.csv
succeeds probe furnace --points points.csv -o "$out/a.csv" "${draft[@]}" --stats "$out/a.json"
[[ $(head -n 1 "$out/a.csv") == x,y,z,nx,ny,nz,r,g,b,err_r,err_g,err_b ]] || complain "header of the readings"
[[ $(wc -l <"$out/a.csv") == 3 ]] || complain "one line per point"
grep -q '^0.1,0.2,0.1,0,1,0,' "$out/a.csv" || complain "a point comes back as it was given"
[[ $(awk -F, '{ print NF }' "$out/a.csv" | sort -u) == 12 ]] || complain "twelve columns"
grep -q '"command":.*"probe"' "$out/a.json" || complain "statistics of the probe"

printf 'nz,ny,nx,label,z,y,x\n0,1,0,desk,0.1,0.2,0.1\n1,0,0,wall,0.1,0.2,-0.1\n' >named.csv
succeeds probe furnace --points named.csv -o "$out/named.csv" "${draft[@]}"
cmp -s "$out/a.csv" "$out/named.csv" || complain "columns are found by name"
succeeds probe furnace --points "$out/a.csv" -o "$out/again.csv" "${draft[@]}" --threads 1
cmp -s "$out/a.csv" "$out/again.csv" || complain "readings can be read back; same bytes for one thread"
for mode in lookup reference; do
    succeeds probe furnace --points points.csv -o "$out/$mode.csv" "${draft[@]}" --mode $mode
done
succeeds probe furnace --points points.csv -o "$out/goal.csv" "${draft[@]}" --goal
rm -f "$out"/*
refuses 2 'solves nothing' probe furnace --points points.csv -o "$out/a.csv" --mode reference --goal
refuses 1 'would overwrite' probe furnace --points points.csv -o points.csv "${draft[@]}"
[[ $(wc -l <points.csv) == 4 ]] || complain "points were overwritten"

# grids are points of their own, which can be read back
succeeds probe furnace --grid 0.1 --height 0.4 -o "$out/grid.csv" "${draft[@]}"
(($(wc -l <"$out/grid.csv") > 4)) || complain "a grid has several points"
succeeds probe furnace --points "$out/grid.csv" -o "$out/same.csv" "${draft[@]}"
cmp -s "$out/grid.csv" "$out/same.csv" || complain "a grid's points, read from a file, have the same readings"
rm -f "$out"/*
refuses 2 'leave out one' probe furnace --points points.csv --grid 0.1 -o "$out/a.csv"
refuses 2 '--grid M is missing' probe furnace -o "$out/a.csv"
refuses 2 'requires --grid' probe furnace --points points.csv --height 1 -o "$out/a.csv"
refuses 1 'no floor' probe cornell-blocks --grid 0.1 --height 50 -o "$out/a.csv" "${draft[@]}"

# refuses_line NUMBER PATTERN LINE...
refuses_line() {
    local number=$1 pattern=$2
    shift 2
    printf '%s\n' "$@" >bad.csv
    refuses 1 "bad.csv:$number: $pattern" probe furnace --points bad.csv -o "$out/a.csv" "${draft[@]}"
}
good=0,0.2,0,0,1,0
refuses_line 2 'y is not a finite number' $good 0,nan,0,0,1,0
refuses_line 1 'x is not a finite number' inf,0,0,0,1,0
refuses_line 1 'x is not a finite number' 1e39,0,0,0,1,0
refuses_line 3 'z is not a finite number' "# comment" $good 0,0,here,0,1,0
refuses_line 2 'nx is not a finite number' $good 0,0,0,,1,0
refuses_line 1 '5 columns' 0,0,0,0,1
refuses_line 2 '7 columns' $good 0,0,0,0,1,0,7
refuses_line 1 'the header has no column nz' x,y,z,nx,ny $good
refuses_line 2 '6 columns' x,y,z,nx,ny,nz,name $good
refuses_line 1 'the normal' 0,0,0,0,0,0
refuses_line 1 'the normal' 0,0,0,1e30,0,0
refuses_line 1 'x is not a finite number' '0;0;0;0;1;0,0,0,0,0,0'
printf '# nothing\n' >bad.csv
refuses 1 'no points' probe furnace --points bad.csv -o "$out/a.csv" "${draft[@]}"
head -c 100 /dev/zero >bad.csv
refuses 1 'bad.csv' probe furnace --points bad.csv -o "$out/a.csv" "${draft[@]}"
refuses 1 'missing.csv' probe furnace --points missing.csv -o "$out/a.csv" "${draft[@]}"
refuses 1 'folder' probe furnace --points points.csv -o no/such/folder/a.csv "${draft[@]}"
finish
