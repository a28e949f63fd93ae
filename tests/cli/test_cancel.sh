#!/usr/bin/env bash
# An interrupted run stops soon, says so in one line, and leaves nothing.
source "$(dirname "$0")/support.sh"

# cancels SIGNAL ARGUMENT...: long work, stopped half a second after it began
cancels() {
    local signal=$1 process
    shift
    "$program" "$@" >stdout 2>stderr </dev/null &
    process=$!
    sleep 0.5
    kill -s "$signal" $process
    local started=$SECONDS
    status=0
    wait $process || status=$?
    ((status == 1)) || complain "exit status $status, not 1, after $signal: $*"
    ((SECONDS - started <= 5)) || complain "took $((SECONDS - started)) s to stop: $*"
    [[ $(grep -v ' %' stderr) == cancelled ]] || complain "says more or less than 'cancelled': $*"
    [[ -z $(ls -A "$out") ]] || complain "left $(ls -A "$out"): $*"
}

for ((i = 0; i < 5000; i++)); do echo 0.1,0.2,0.1,0,1,0; done >points.csv
picture=(-o "$out/a.exr" -o "$out/a.png" --stats "$out/a.json" --size 64x4000 --spp 4096 --quality draft)
cancels INT render cornell-spheres "${picture[@]}" --mode reference
cancels TERM render cornell-spheres "${picture[@]}" --gather 1024
cancels INT render cornell-spheres "${picture[@]}" --quality high --mode operator
cancels INT probe cornell-spheres --points points.csv -o "$out/a.csv" --mode reference
finish
