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
    [[ $(cat stderr) == cancelled ]] || complain "says more or less than 'cancelled': $*"
    [[ -z $(ls -A "$out") ]] || complain "left $(ls -A "$out"): $*"
}

echo 0.1,0.2,0.1,0,1,0 >point.csv
cancels INT render cornell-spheres -o "$out/a.exr" -o "$out/a.png" --stats "$out/a.json" --mode reference --spp 100000
cancels TERM render cornell-spheres -o "$out/a.exr" --quality draft --size 2000x2000 --spp 4096
cancels INT probe cornell-spheres --points point.csv -o "$out/a.csv" --mode reference --samples 1000000000
finish
