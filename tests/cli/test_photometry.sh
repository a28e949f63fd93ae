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
succeeds solve furnace -o f.safetensors "${draft[@]:0:2}" --max-elements 400 --threads 2
succeeds falsecolor f.safetensors -o "$out/i.png" --size 40x64 --min 0 --max 2000
[[ $(head -c 24 "$out/i.png" | tail -c 8 | od -An -tu1 | tr -s ' ') == ' 0 0 0 136 0 0 0 64' ]] || complain "size of the isolux picture"
rm -f "$out"/*
refuses 1 "no camera 'x'" falsecolor f.safetensors -o "$out/i.png" --camera x

printf '0 point 0.5 0.4\n2 point 0.2 0.8\n' >point.txt
succeeds view furnace --script point.txt --record frames --size 64x48 "${draft[@]:0:2}" --max-elements 400
says 'frame 0: 0.5 0.4: 1366 lux'
says 'frame 2: 0.2 0.8: 1366 lux'

# Glare of views drawn from closed forms: a disk of 20,000 cd/m2 and 2 degrees before 100 cd/m2, 25 degrees up or 20 down.
succeeds render furnace -o eye.exr --projection fisheye --size 200x200 "${draft[@]:0:2}" --max-elements 400 --spp 1
succeeds glare eye.exr
says 'DGP *0.240'
says 'UGR *none'
succeeds render furnace -o candela.exr --projection fisheye --size 200x200 "${draft[@]:0:2}" --max-elements 400 --spp 1 --photometric
succeeds glare candela.exr --efficacy 1
says 'DGP *0.240'
refuses 2 'cannot hold cd/m2' render furnace -o "$out/f.png" --photometric
cat >view.py <<'PYTHON'
import sys
from math import *
size, up, name = 1200, radians(float(sys.argv[1])), sys.argv[2]
with open(name, "wb") as f:
    f.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (size, size))
    for y in range(size):
        for x in range(size):
            a, b = x + 0.5 - size / 2, size / 2 - y - 0.5
            r = hypot(a, b) / (size / 2) * pi / 2
            d = (a / hypot(a, b) * sin(r), b / hypot(a, b) * sin(r), cos(r))
            glares = d[1] * sin(up) + d[2] * cos(up) > cos(radians(2))
            m, e = frexp((20000 if glares else 100) / 683)
            f.write(bytes([int(m * 256)] * 3 + [e + 128]))
PYTHON
cat >check.py <<'PYTHON'
import json, sys
from math import *
up = float(sys.argv[1])
w, L, La = 2 * pi * (1 - cos(radians(2))), 20000, 100
Es = L * pi * sin(radians(2)) ** 2 * cos(radians(up))
Ev = pi * La + Es * (L - La) / L
if up >= 0:
    P = exp((35.2 - 1.22) * 1e-3 * up + 21e-5 * up * up)
else:
    R = tan(radians(-up))
    P = 1 + (0.8 if R < 0.6 else 1.2) * R
ugr = 8 * log10(0.25 / ((Ev - Es) / pi) * L * L * w / P ** 2)
dgp = 5.87e-5 * Ev + 0.0918 * log10(1 + L * L * w / (Ev ** 1.87 * P * P)) + 0.16
dgp *= exp(0.024 * Ev - 4) / (1 + exp(0.024 * Ev - 4)) if Ev < 1000 else 1
found = json.load(sys.stdin)
assert len(found["sources"]) == 1, found
assert abs(found["vertical_lux"] / Ev - 1) < 0.01, (found, Ev)
assert abs(found["ugr"] - ugr) < 0.1, (found, ugr)
assert abs(found["dgp"] - dgp) < 0.003, (found, dgp)
PYTHON
for up in 25 -20; do
    python3 view.py $up view.hdr
    "$program" glare view.hdr --json 2>/dev/null | python3 check.py $up || complain "glare from $up degrees up"
done
refuses 1 'missing.exr' glare missing.exr

printf 'TILT=NONE\r\n1 1000 1 2 1 1 2 0 0 0 1 1 10\r\n0 90\r\n0\r\n100 100\r\n' >lamp.ies
"$program" info lamp.ies >log || complain "a luminaire is told of"
grep -q 'flux *628.319 lm' log || complain "2 pi times 100 cd: $(cat log)"
"$program" info lamp.ies --json | python3 -c 'import json, sys; assert json.load(sys.stdin)["lamp_flux"] == 1000' ||
    complain "a luminaire in JSON"
printf 'TILT=NONE\n1 1000 1 2 1 1 2 0 0 0 1 1 10\n0 90\n0\n100\n' >bad.ies
refuses 1 'bad.ies:6: an intensity is missing' info bad.ies
{ echo IESNA:LM-63-2002; grep -v TILT= lamp.ies; } >bad.ies
refuses 1 'bad.ies:1: there is no line TILT=; add TILT=NONE' info bad.ies
{ cat lamp.ies; echo 5 6; } >bad.ies
"$program" info bad.ies >/dev/null 2>log || complain "numbers too many are no error"
grep -q 'after the last intensity is ignored' log || complain "numbers too many are told of"
finish
