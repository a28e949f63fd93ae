#!/usr/bin/env bash
# Several processes: the same bytes as one, and no failure leaves anybody waiting.
scripts=$(cd "$(dirname "$0")" && pwd)
source "$scripts/support.sh"

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

# Pictures by rows, sequences by frames
for mode in final reference; do
    succeeds render one.safetensors -o one.exr "${small[@]}" --mode $mode
    thrive 3 render one.safetensors -o many.exr "${small[@]}" --mode $mode
    cmp -s one.exr many.exr || complain "another picture from 3 processes in mode $mode"
done
printf '0 light.light=1\n3 light.light=0.5\n' >script.txt
for count in 1 3; do
    thrive $count relight one.safetensors --script script.txt -o "frame$count-%d.exr" --size 16x12 \
        --spp 1 --threads 1
done
for frame in 0 1 2 3; do
    cmp -s frame1-$frame.exr frame3-$frame.exr || complain "another frame $frame from 3 processes"
done

# A killed process ends the run; another number of processes goes on with its rows
mpirun --oversubscribe --mca mpi_yield_when_idle 1 -n 2 "$program" solve cornell-spheres \
    -o killed.safetensors "${draft[@]}" --checkpoint rows >stdout 2>stderr </dev/null &
launcher=$!
until [[ -n $(find rows -name '*.rows' -size +0 2>/dev/null) ]]; do sleep 0.02; done
kill -9 "$(pgrep -P $launcher | tail -n 1)"
SECONDS=0
wait $launcher && complain "the run went on without one of its processes"
((SECONDS < 30)) || complain "it took $SECONDS s to end"
warns 'signal 9'
[[ ! -e killed.safetensors ]] || complain "half a file"
for count in 1 3; do
    thrive $count solve cornell-spheres -o resumed.safetensors "${draft[@]}" --checkpoint rows
    warns '^note: checkpoint: [0-9]* rows'
    cmp -s one.safetensors resumed.safetensors || complain "other bytes after a restart of $count"
done

# PETSc: the solution does not depend on the processes, nor on how the matrix is kept
petsc() { thrive "$1" solve cornell-blocks -o "$2" --quality draft --threads 1 --petsc "-ksp_rtol 1e-8 $3" "${@:4}"; }
petsc 1 petsc.safetensors "-ksp_type gmres" --eigenvalues 2
says '^eigenvalue 2: 0\.'
for options in "-ksp_type bcgs" "-ksp_type gmres -pc_type bjacobi -resolvent_mat_type aij -ksp_tpye x"; do
    petsc 3 other.safetensors "$options"
    if command -v python3 >/dev/null; then
        python3 "$scripts/compare_operators.py" petsc.safetensors other.safetensors >compared ||
            complain "$(cat compared): $options"
    fi
done
grep -q 'Option left: name:-ksp_tpye' all || complain "a misspelt option is not said"
together 2 solve cornell-blocks -o "$out/a.safetensors" --quality draft --petsc "-ksp_type bogus"
((status == 1)) && grep -q '^error: solve: PETSc: .*bogus' stderr || complain "an unknown method"

together 2 solve no-such-scene -o "$out/a.safetensors"
((status == 1)) || complain "exit status $status, not 1"
[[ $(grep -c '^error: ' stderr) == 1 ]] || complain "not exactly one line of error"
together 2 solve furnace -o "$out/a.safetensors" --no-such-option
[[ $(grep -c '^error: ' stderr) == 1 ]] || complain "not exactly one line on usage"
[[ -z $(ls -A "$out") ]] || complain "failures left files"
finish
