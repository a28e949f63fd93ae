#!/usr/bin/env bash
# An interrupted run stops soon, says so in one line, and leaves nothing.
source "$(dirname "$0")/support.sh"

# listens PROCESS: whether it catches interrupts yet. Until then one would be lost, for a shell's background processes
# ignore them, and the work would run to its end.
listens() {
    local caught
    caught=$(sed -n 's/^SigCgt:[[:space:]]*//p' "/proc/$1/status")
    ((16#${caught:-0} & 2))
}

# cancels SIGNAL ARGUMENT...: long work, stopped half a second after it began
cancels() {
    local signal=$1 process tries
    shift
    "$program" "$@" >stdout 2>stderr </dev/null &
    process=$!
    for ((tries = 0; tries < 300; tries++)); do
        listens $process && break
        sleep 0.1
    done
    sleep 0.5
    kill -s "$signal" $process
    local started=$SECONDS
    for ((tries = 0; tries < 300; tries++)); do
        kill -0 $process 2>/dev/null || break
        sleep 0.1
    done
    ((tries < 300)) || kill -s KILL $process
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
