#!/usr/bin/env bash
# A year of weather at sensors: reports in three formats, hourly values, and errors in files.
source "$(dirname "$0")/support.sh"

# weather RECORDS...: an EPW file on standard output
weather() {
    printf 'LOCATION,Here,-,-,-,1,41.98,-87.92,-6.0,201.0\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\n'
    printf 'GROUND TEMPERATURES,0\nHOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,\nCOMMENTS 2,\n'
    printf 'DATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31\n'
    printf '%s,?9,1.0,4.0,73,99500,0,0,218,%s,0,0,0,0,270,2.6\n' "$@"
}
weather 2001,6,21,3,60 0,0,0 2001,6,21,11,60 600,500,150 2001,6,21,12,60 700,600,150 >a.epw
printf '0,0.5,0,0,1,0\n0.1,0.5,0.1,0,0,1\n' >points.csv
quick=(--weather a.epw --quality draft --samples 120 --max-elements 120 --threads 2)

succeeds daylight cornell-blocks "${quick[@]}" --points points.csv -o "$out/a.csv" --hourly "$out/h.csv" --north 0
[[ $(wc -l <"$out/a.csv") == 3 ]] || complain "one line per sensor"
[[ $(awk -F, '{ print NF }' "$out/a.csv" | sort -u) == 28 ]] || complain "place, normal and eleven figures with errors"
grep -q '^0,0.5,0,0,1,0,' "$out/a.csv" || complain "a sensor comes back as it was given"
[[ $(wc -l <"$out/h.csv") == 4 ]] || complain "one line per record"
grep -q '^6,21,10.5,' "$out/h.csv" || complain "the middle of an hour"
grep -q '^6,21,2.5,0,0$' "$out/h.csv" || complain "the night is dark"
succeeds daylight cornell-blocks "${quick[@]}" --points points.csv -o "$out/b.csv" --north 0 --threads 1
cmp -s "$out/a.csv" "$out/b.csv" || complain "same bytes for one thread"
succeeds daylight cornell-blocks "${quick[@]}" --points points.csv -o "$out/a.json" --sky-only
python3 - "$out/a.json" <<'END' || complain "the JSON holds what docs/daylight.md says"
import json, sys
r = json.load(open(sys.argv[1]))
assert r["sky_only"] and r["missing_hours"] == 8757 and len(r["sensors"]) == 2
assert all(k in r["space"] for k in ("mean", "sda_300_50", "ase_1000_250", "target", "minimum", "en_17037"))
assert r["sensors"][0]["mean"]["unit"] == "lux" and r["sensors"][0]["mean"]["standard_error"] >= 0
END
succeeds daylight cornell-blocks "${quick[@]}" --points points.csv -o "$out/a.html" -o "$out/f.csv" --from 9 --to 17
[[ -s $out/f.csv ]] || complain "a report in a second format"
grep -q '</html>' "$out/a.html" || complain "the page is whole"
! grep -qE 'src=|href=|[^a-z](nan|inf)[^a-z]' "$out/a.html" || complain "the page stands alone and has numbers"
succeeds daylight cornell-blocks "${quick[@]}" --points points.csv -o "$out/s.json" --north 0 --shaded furnace --shade-share 1%
grep -q '"shaded_hours":' "$out/s.json" || complain "hours with the shades down"
grep -q '"openings":	"vertical"' "$out/s.json" || complain "openings without panes count as vertical"
succeeds daylight cornell-blocks "${quick[@]}" --points points.csv -o "$out/o.json" --north 0 --openings horizontal
grep -q '"openings":	"horizontal"' "$out/o.json" || complain "openings are horizontal if the user says so"
grep -q '(rooflights)' stdout || complain "the printed report says which values of EN 17037 apply"
cp a.epw b.epw
succeeds daylight cornell-blocks "${quick[@]}" --points points.csv -o "$out/d.csv" --weather b.epw -o "$out/e.csv" --north 0
cmp -s "$out/a.csv" "$out/d.csv" && cmp -s "$out/d.csv" "$out/e.csv" || complain "a report for each weather file"
rm -f "$out"/*
"$program" daylight cornell-blocks "${quick[@]}" --points points.csv -o "$out/c.csv" 2>log >/dev/null
grep -q 'no --north' log || complain "says which north is taken"
grep -q '8757 hours of the year are missing' log || complain "says which hours are missing"
rm -f "$out"/*

refuses 2 'weather' daylight cornell-blocks -o "$out/a.csv"
refuses 2 '\.html, \.json or \.csv' daylight cornell-blocks "${quick[@]}" -o "$out/a.txt"
refuses 2 'shaded' daylight cornell-blocks "${quick[@]}" -o "$out/a.csv" --shade-lux 500
refuses 2 'same number of -o' daylight cornell-blocks "${quick[@]}" -o "$out/a.csv" --weather b.epw
refuses 2 'must be before' daylight cornell-blocks "${quick[@]}" -o "$out/a.csv" --from 12 --to 9
refuses 1 'would overwrite' daylight cornell-blocks "${quick[@]}" -o "$out/a.csv" --hourly a.epw
weather 2001,6,31,3,60 0,0,0 >bad.epw
refuses 1 'bad.epw:9: there is no such date' daylight cornell-blocks "${quick[@]:2}" --weather bad.epw -o "$out/a.csv"
printf 'nothing\n' >bad.epw
refuses 1 'neither EPW' daylight cornell-blocks "${quick[@]:2}" --weather bad.epw -o "$out/a.csv"
refuses 1 'missing.epw' daylight cornell-blocks "${quick[@]:2}" --weather missing.epw -o "$out/a.csv"
refuses 1 'missing.csv' daylight cornell-blocks "${quick[@]}" --points missing.csv -o "$out/a.csv"
finish
