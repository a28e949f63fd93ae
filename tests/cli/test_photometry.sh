#!/usr/bin/env bash
# Lux of probes, and pictures in false colours. In the furnace, irradiance is 2 W/m2 on all sides of any point: 1366 lux.
source "$(dirname "$0")/support.sh"

printf '0.1,0.1,0.1,0,1,0\n0.3,0.2,0.1,1,0,0\n' >points.csv
draft=(--quality draft --samples 256 --max-elements 400 --threads 2)
succeeds probe furnace --points points.csv -o "$out/a.csv" "${draft[@]}" --photometric --cylindrical
[[ $(head -n 1 "$out/a.csv") == x,y,z,nx,ny,nz,lux,err_lux,cylindrical,err_cylindrical ]] || complain "header of the lux"
awk -F, 'NR > 1 { for (k = 7; k <= 9; k += 2) if ($k < 1365 || $k > 1367) exit 1 }' "$out/a.csv" || complain "1366 lux"
"$program" probe furnace --points points.csv -o "$out/a.csv" "${draft[@]}" --photometric 2>/dev/null >log
grep -q 'mean 1366 .*uniformity 1.000' log || complain "figures of the grid: $(cat log)"
succeeds probe furnace --points points.csv -o "$out/b.csv" "${draft[@]}" --photometric --mode reference
rm -f "$out"/*
refuses 2 'photometric' probe furnace --points points.csv -o "$out/a.csv" "${draft[@]}" --cylindrical

succeeds render furnace -o f.exr --size 40x30 "${draft[@]:0:2}" --max-elements 400 --spp 1
succeeds falsecolor f.exr -o "$out/f.png"
succeeds falsecolor f.exr -o "$out/g.png" --log --max 1000 --min 1 --lines 4
succeeds falsecolor f.exr -o "$out/h.exr" --lines 0 --efficacy 179
[[ $(head -c 24 "$out/f.png" | tail -c 8 | od -An -tu1 | tr -s ' ') == ' 0 0 0 136 0 0 0 64' ]] || complain "room for the scale"
rm -f "$out"/*
refuses 1 'not below the top' falsecolor f.exr -o "$out/f.png" --max 1 --min 2
refuses 1 'not above 0' falsecolor f.exr -o "$out/f.png" --log --min 0
refuses 1 'missing.exr' falsecolor missing.exr -o "$out/f.png"
refuses 2 'missing' falsecolor f.exr

printf 'TILT=NONE\r\n1 1000 1 2 1 1 2 0 0 0 1 1 10\r\n0 90\r\n0\r\n100 100\r\n' >lamp.ies
"$program" info lamp.ies >log || complain "a luminaire is told of"
grep -q 'flux *628.319 lm' log || complain "2 pi times 100 cd: $(cat log)"
"$program" info lamp.ies --json | python3 -c 'import json, sys; assert json.load(sys.stdin)["lamp_flux"] == 1000' ||
    complain "a luminaire in JSON"
printf 'TILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 10\n0 90\n0\n100\n' >bad.ies
refuses 1 'bad.ies:6: an intensity is missing' info bad.ies
finish
