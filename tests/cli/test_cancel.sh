#!/usr/bin/env bash
# An interrupted run stops soon, reports it in one line, and leaves no file.
source "$(dirname "$0")/support.sh"

# listens PROCESS: whether it catches interrupts yet. Until then one would be lost, for a shell's background processes
# ignore them, and the work would run to its end.
listens() {
    local caught
    caught=$(sed -n 's/^SigCgt:[[:space:]]*//p' "/proc/$1/status")
    ((16#${caught:-0} & 2))
}

# used PROCESS: hundredths of a second that it had of all processors
used() {
    local fields
    read -ra fields < <(sed 's/.*) //' "/proc/$1/stat" 2>/dev/null)
    echo $((${fields[11]:-0} + ${fields[12]:-0}))
}

# cancels SIGNAL ARGUMENT...: stops long work half a second after its start. CPU time is limited instead of wall time,
# because other work shares the CPU
cancels() {
    local signal=$1 process tries before after
    shift
    "$program" "$@" >stdout 2>stderr </dev/null &
    process=$!
    for ((tries = 0; tries < 300; tries++)); do
        listens $process && break
        sleep 0.1
    done
    sleep 0.5
    before=$(used $process) after=$before
    kill -s "$signal" $process
    for ((tries = 0; tries < 1000; tries++)); do
        kill -0 $process 2>/dev/null || break
        ((after = $(used $process), after > before)) || after=$before
        sleep 0.1
    done
    ((tries < 1000)) || kill -s KILL $process
    status=0
    wait $process || status=$?
    ((status == 1)) || complain "exit status $status, not 1, after $signal: $*"
    ((after - before <= 500 * $(nproc))) || complain "took $((after - before)) hundredths of a second to stop: $*"
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
