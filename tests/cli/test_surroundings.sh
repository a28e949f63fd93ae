#!/usr/bin/env bash
# Wherever the program runs: names of folders, locales, no home, no folder for temporary files, folders and files that
# vanish meanwhile, one thread or many, numbers too small to be normal.
source "$(dirname "$0")/support.sh"
seeds=$(cd "$here/../fuzz/seeds" && pwd)
few=(--quality draft --max-elements 80)

# spaces, letters of other scripts, and characters with a meaning in shells and file systems
odd="$work/a folder, Größe 100% 日本 [x] 'quoted'"
mkdir "$odd"
succeeds scene cornell-blocks -o "$odd/the box.glb"
succeeds solve "$odd/the box.glb" -o "$odd/the light.safetensors" "${few[@]}"
succeeds render "$odd/the light.safetensors" -o "$odd/a picture.png" -o "$odd/a picture.exr" --size 16x16 --spp 1
succeeds bake "$odd/the box.glb" -o "$odd/baked 1.glb" --to lightmap --map-size 64 --basis "${few[@]}" --checkpoint "$odd/rows of it"
cp "$seeds"/room.gltf "$odd/room 2.gltf"
succeeds render "$odd/room 2.gltf" -o "$odd/room.png" --size 16x16 --spp 1 "${few[@]}"
printf 'x,y,z,nx,ny,nz\n0,0.5,0,0,1,0\n' >"$odd/points of it.csv"
succeeds probe "$odd/the light.safetensors" --points "$odd/points of it.csv" -o "$odd/read.csv"
for file in "a picture.png" "a picture.exr" "baked 1.glb" "baked 1.lightmap.exr" room.png read.csv; do
    [[ -s $odd/$file ]] || complain "'$file' is missing in a folder of an odd name"
done

# no home, no place for temporary files, hardly an environment; a locale with commas
same() { cmp -s "$1" "$2" || complain "$3: other bytes"; }
plain=(solve "$odd/the box.glb" "${few[@]}")
env -i LSAN_OPTIONS="${LSAN_OPTIONS-}" HOME=/nonexistent TMPDIR=/nonexistent "$program" "${plain[@]}" -o bare.safetensors >stdout 2>stderr ||
    complain "it needs a home or a folder for temporary files"
same bare.safetensors "$odd/the light.safetensors" "without an environment"
if localedef -i de_DE -f UTF-8 "$work/de_DE.UTF-8" >/dev/null 2>&1; then
    LOCPATH=$work LC_ALL=de_DE.UTF-8 "$program" "${plain[@]}" -o commas.safetensors --stats commas.json >stdout 2>stderr ||
        complain "it does not run where numbers have commas"
    same commas.safetensors bare.safetensors "where numbers have commas"
    grep -q '"total":[[:space:]]*[0-9]*\.[0-9]' commas.json || complain "statistics have commas in numbers"
else
    echo "skipped: no locale with commas can be made; the package locales would help"
fi

# one thread or many more than processors
for threads in 1 64; do
    succeeds "${plain[@]}" -o "threads-$threads.safetensors" --threads "$threads"
    succeeds render "$odd/the box.glb" -o "threads-$threads.png" --mode final --size 24x24 --spp 1 --threads "$threads" "${few[@]}"
done
same threads-1.safetensors threads-64.safetensors "64 threads"
same threads-1.png threads-64.png "a picture by 64 threads"

# denormal numbers count as 0
cat >tiny.mtl <<'TEXT'
newmtl tiny
Kd 1e-40 1e-42 0
Ke 1e-41 1e-41 1e-41
TEXT
cat >tiny.obj <<'TEXT'
mtllib tiny.mtl
usemtl tiny
v 0 1e-40 0
v 1 0 1e-44
v 0 0 -1
f 1 2 3
TEXT
succeeds render tiny.obj -o tiny.exr -o tiny.png --size 16x16 --spp 2 --env white "${few[@]}"
succeeds compare tiny.exr tiny.exr --json
! grep -qi nan stdout || complain "numbers that are too small end in NaN"

# halts_when CONDITION ARGUMENT...: begins a run, and halts it once the shell finds that true
halts_when() {
    local condition=$1
    shift
    "$program" "$@" >stdout 2>stderr </dev/null &
    until eval "$condition" 2>/dev/null; do
        kill -0 $! 2>/dev/null || break
        sleep 0.01
    done
    kill -STOP $! 2>/dev/null
}

# goes_on WHAT: the program ends, with at most one line of error
goes_on() {
    kill -CONT $! 2>/dev/null
    status=0
    wait $! || status=$?
    ((status <= 1)) || complain "exit status $status $1"
    [[ $(error_lines | grep -c '^error: ') == "$status" ]] || complain "exit status $status, and not one line of error $1"
    ((status == 0)) || [[ -z $(ls -A "$out") ]] || complain "left $1: $(ls -A "$out")"
}

# halts_with_rows ROWS OUTPUT: solves into a file, and halts once there are first rows. If the work is done before the shell
# gets to see them, longer work is tried
halts_with_rows() {
    local quality
    for quality in draft medium high; do
        rm -rf "$1"
        long=(solve cornell-blocks --quality $quality --threads 1)
        halts_when "[[ -n \$(find '$1' -name '*.rows' -size +0) ]]" "${long[@]}" -o "$2" --checkpoint "$1"
        [[ -e $2 ]] || return
        goes_on "before it was halted"
        rm "$2"
    done
}

# a folder that is gone when the work is done
mkdir "$out/gone"
halts_with_rows work "$out/gone/a.safetensors"
rmdir "$out/gone" || complain "the work was done before the folder could go"
goes_on "where the folder of the output is gone"
((status == 1)) || complain "an output without a folder is a success"

# rows that are cut off while they are mapped
while read -r rows; do
    mv "$rows" "${rows%-0.rows}-7.rows" # another process's: this one does not write to it
done < <(find work -name '*.rows')
halts_when 'grep -q "\.rows" /proc/$!/maps' "${long[@]}" -o "$out/a.safetensors" --checkpoint work --resume
find work -name '*-7.rows' -exec truncate -s 0 {} +
goes_on "where rows are cut off"
((status == 1)) || { succeeds "${long[@]}" -o whole.safetensors && same "$out/a.safetensors" whole.safetensors "where rows are cut off"; }
rm -f "$out"/*

# SIGBUS: a page of a mapped file no longer exists
halts_with_rows again "$out/a.safetensors"
kill -BUS $!
goes_on "where a mapped file is cut off"
((status == 1)) && grep -q 'was truncated while it was being read' stderr || complain "a mapped file is cut off in silence"
finish
