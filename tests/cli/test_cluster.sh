#!/usr/bin/env bash
# Several processes: the same bytes as one, and no failure leaves anybody waiting.
source "$(dirname "$0")/support.sh"

# Exit status 77 is a test skipped.
if [[ ! -e $(dirname "$program")/libresolvent_dist.so ]]; then
    echo "skipped: the plug-in for MPI and PETSc was not built (./dev cluster)"
    exit 77
fi
if ! command -v mpirun >/dev/null; then
    echo "skipped: there is no mpirun (Debian: openmpi-bin)"
    exit 77
fi
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

# together COUNT ARGUMENT...: as `run`, with so many processes. What mpirun adds of its own is left out.
together() {
    local count=$1
    shift
    status=0
    mpirun --oversubscribe --mca mpi_yield_when_idle 1 -n "$count" "$program" "$@" \
        >stdout 2>all </dev/null || status=$?
    grep -E '^(error|warning|note|cancelled|[a-z]+: [0-9]+ %)' all >stderr
}

# thrive COUNT ARGUMENT...
thrive() {
    together "$@"
    ((status == 0)) || complain "exit status $status of $*"
}

draft=(--quality draft --max-elements 700 --threads 1)
succeeds solve cornell-spheres -o one.safetensors "${draft[@]}"
for count in 2 4; do
    thrive $count solve cornell-spheres -o many.safetensors "${draft[@]}" --stats many.json
    cmp -s one.safetensors many.safetensors || complain "other bytes from $count processes"
    [[ ! -s stdout ]] || complain "$count processes printed on standard output"
done
grep -q '"entries"' many.json || complain "no statistics"

thrive 2 info one.safetensors # one process does what is not worth sharing
[[ $(grep -c '^solved operator' stdout) == 1 ]] || complain "not said once"

together 2 solve no-such-scene -o "$out/a.safetensors"
((status == 1)) || complain "exit status $status, not 1"
[[ $(grep -c '^error: ' stderr) == 1 ]] || complain "not exactly one line of error"
together 2 solve furnace -o "$out/a.safetensors" --no-such-option
[[ $(grep -c '^error: ' stderr) == 1 ]] || complain "not exactly one line on usage"
[[ -z $(ls -A "$out") ]] || complain "failures left files"
finish
