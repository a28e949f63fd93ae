#!/usr/bin/env bash
# Several processes: the same bytes as one, and no failure leaves anybody waiting.
source "$(dirname "$0")/support.sh"

# Exit status 77 is a test skipped.
if [[ ! -e $(dirname "$program")/libresolvent_mpi.so ]]; then
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
    grep -E '^(error|warning|note|cancelled|[a-z]+: [0-9]+ %)' all >stderr || true
}

# thrive COUNT ARGUMENT...
thrive() {
    together "$@"
    ((status == 0)) || complain "exit status $status of $*"
}

# Rows of every kind, with photons through glass
draft=(--quality draft --max-elements 300 --threads 1)
tiny=(--quality draft --max-elements 200 --threads 1)
succeeds solve cornell-spheres -o one.safetensors "${draft[@]}"
for count in 2 4; do
    thrive $count solve cornell-spheres -o many.safetensors "${draft[@]}" --stats many.json
    cmp -s one.safetensors many.safetensors || complain "other bytes from $count processes"
    [[ ! -s stdout ]] || complain "$count processes printed on standard output"
done
grep -q '"entries"' many.json || complain "no statistics"
succeeds solve furnace -o box.safetensors "${tiny[@]}"
thrive 2 solve furnace -o many.safetensors "${tiny[@]}" --error 30%
cmp -s box.safetensors many.safetensors || complain "other bytes from 2 processes with a target"

thrive 2 info one.safetensors # one process does what is not worth sharing
[[ $(grep -c '^solved operator' stdout) == 1 ]] || complain "not said once"

# More processes than rows
printf 'newmtl lamp\nKe 5 5 5\nKd 0.5 0.5 0.5\n' >corner.mtl
printf '%s\n' 'mtllib corner.mtl' 'v 0 0 0' 'v 1 0 0' 'v 0 1 0' 'v 0 0 1' 'f 1 3 4' 'usemtl lamp' 'f 1 2 3' >corner.obj
few=(solve corner.obj --quality draft --max-elements 6 --threads 1)
succeeds "${few[@]}" -o few1.safetensors --stats few.json
grep -q '"rows":[[:space:]]*[1-7],' few.json || complain "too many rows"
thrive 8 "${few[@]}" -o many.safetensors
cmp -s few1.safetensors many.safetensors || complain "other bytes from 8 processes for fewer rows"
thrive 8 "${few[@]}" -o many.safetensors --petsc "-ksp_type gmres" --eigenvalues 1
says '^eigenvalue 1: '

# Pictures by rows, sequences by frames
for mode in final reference; do
    succeeds render box.safetensors -o one.exr "${small[@]}" --mode $mode
    thrive 3 render box.safetensors -o many.exr "${small[@]}" --mode $mode
    cmp -s one.exr many.exr || complain "another picture from 3 processes in mode $mode"
done
printf '0 light.light=1\n3 light.light=0.5\n' >script.txt
frames=(relight one.safetensors --script script.txt --size 16x12 --spp 1 --threads 1)
succeeds "${frames[@]}" -o frame1-%d.exr
thrive 2 "${frames[@]}" -o frame2-%d.exr
for frame in 0 1 2 3; do
    cmp -s frame1-$frame.exr frame2-$frame.exr || complain "another frame $frame from 2 processes"
done

# begin COMMAND...: two processes that solve, with rows on disk when this returns; mpirun is $launcher
begin() {
    mpirun --oversubscribe --mca mpi_yield_when_idle 1 -n 2 "$@" >stdout 2>all </dev/null &
    launcher=$!
    until [[ -n $(find rows -name '*.rows' -size +0 2>/dev/null) ]]; do sleep 0.02; done
}
# failures: the run fails soon, and leaves no file
ends() {
    SECONDS=0
    wait $launcher && complain "the run went on without one of its processes"
    ((SECONDS < 30)) || complain "it took $SECONDS s to end"
    [[ ! -e killed.safetensors ]] || complain "half a file"
}
# seconds of work after the first rows: on a busy machine, too, it is not done before it is killed
long=(solve cornell-blocks -o killed.safetensors --quality medium --threads 1 --checkpoint rows)

# A killed process ends the run; a run with another number of processes continues with its rows
begin "$program" "${long[@]}"
kill -9 "$(pgrep -P $launcher | tail -n 1)"
ends
grep -q 'signal 9' all || complain "it is not said that a process was killed"
cp -r rows rows1
cp -r rows rows3
succeeds "${long[@]}" -o anew.safetensors --checkpoint other
for count in 1 3; do
    thrive $count "${long[@]}" -o resumed.safetensors --checkpoint rows$count --resume
    warns '^note: checkpoint: [0-9]* rows'
    cmp -s anew.safetensors resumed.safetensors || complain "other bytes after a restart by $count"
done

# A full disk of one process ends all of them, without waiting for the others' work
rm -r rows
SECONDS=0 status=0
mpirun --oversubscribe --mca mpi_yield_when_idle 1 --mca btl tcp,self -n 1 "$program" "${long[@]}" : \
    -n 1 bash -c 'ulimit -f 400; exec "$0" "$@"' "$program" "${long[@]}" >stdout 2>stderr </dev/null || status=$?
((status == 1)) || complain "exit status $status, not 1, with a full disk"
((SECONDS < 30)) || complain "it took $SECONDS s to end with a full disk"
[[ $(grep -c '^error: process 1 of 2: checkpoint: cannot write .*: File too large; once that is fixed' stderr) == 1 ]] ||
    complain "a full disk is not said once"
[[ ! -e killed.safetensors ]] || complain "half a file on a full disk"
thrive 2 "${long[@]}" -o resumed.safetensors --resume
warns '^note: checkpoint: [0-9]* rows'
cmp -s anew.safetensors resumed.safetensors || complain "other bytes after a full disk"

# An interrupt stops all, in one line
rm -r rows
begin "$program" "${long[@]}" --quality high
kill -INT $launcher
ends
[[ $(grep -c "^cancelled; the same command continues with the rows saved in 'rows'" all) == 1 ]] ||
    { cp all stderr; complain "not said once how to go on"; }
[[ -n $(find rows -name '*.rows' -size +0) ]] || complain "an interrupt takes the rows away"

# PETSc: the solution depends neither on the number of processes nor on the storage of the matrix
# petsc COUNT SCENE OUTPUT PETSC-OPTIONS ARGUMENT...
petsc() { thrive "$1" solve "$2" -o "$3" "${@:5}" --quality draft --threads 1 --petsc "-ksp_rtol 1e-8 $4"; }
# agrees WHAT: the last two of them
agrees() {
    command -v python3 >/dev/null || return
    python3 "$here/compare_operators.py" petsc.safetensors other.safetensors >compared ||
        complain "$(cat compared): $1"
}
petsc 1 cornell-blocks petsc.safetensors "-ksp_type gmres" --max-elements 300 --eigenvalues 2
says '^eigenvalue 2: 0\.'
for options in "-ksp_type bcgs" "-ksp_type gmres -pc_type bjacobi -resolvent_mat_type aij -ksp_tpye x"; do
    petsc 3 cornell-blocks other.safetensors "$options" --max-elements 300
    agrees "$options"
done
grep -q 'There are options you set that were not used' all && grep -q 'Option left: name:-ksp_tpye' all || complain "a misspelt option is not said"
marble=(--mesh cube.obj --max-elements 100)
for z in 0 1; do for y in 0 1; do for x in 0 1; do echo "v $x $y $z"; done; done; done >cube.obj
printf 'f %s\n' '1 3 4 2' '5 6 8 7' '1 2 6 5' '3 7 8 4' '1 5 7 3' '2 4 8 6' >>cube.obj
petsc 1 cornell-marble petsc.safetensors "" "${marble[@]}"
petsc 2 cornell-marble other.safetensors "-ksp_type bcgs" "${marble[@]}"
agrees "translucent"
together 2 solve furnace -o "$out/a.safetensors" "${tiny[@]}" --petsc "-ksp_type bogus"
((status == 1)) && grep -q '^error: solve: PETSc: .*bogus' stderr || complain "an unknown method"

# Bad input: one line, whoever meets it
together 2 solve no-such-scene -o "$out/a.safetensors"
((status == 1)) || complain "exit status $status, not 1"
[[ $(grep -c '^error: ' stderr) == 1 ]] || complain "not exactly one line of error"
together 2 solve furnace -o "$out/a.safetensors" --no-such-option
[[ $(grep -c '^error: ' stderr) == 1 ]] || complain "not exactly one line on usage"
# differ WHAT COMMAND0 : COMMAND1: two processes that must not work together
differ() {
    local what=$1 first=() status=0
    shift
    while [[ $1 != : ]]; do first+=("$1") && shift; done
    shift
    mpirun --oversubscribe -n 1 "${first[@]}" : -n 1 "$@" >stdout 2>stderr </dev/null || status=$?
    ((status == 1)) || complain "exit status $status, not 1: $what"
    [[ $(grep -c '^error: ' stderr) == 1 ]] || complain "not exactly one line of error: $what"
    grep -q "^error: process 1 of 2: $what" stderr || complain "it is not said: $what"
}
wrong=(-o "$out/a.safetensors" "${tiny[@]}")
sed 's/v 0 0 1/v 0 0 2/' corner.obj >other.obj
differ 'its scene differs from that of process 0' "$program" solve corner.obj "${wrong[@]}" : \
    "$program" solve other.obj "${wrong[@]}"
mkdir version build plug-in
cp "$(dirname "$program")"/libresolvent_mpi.so "$program" version
cp -r version/* build
cp -r version/* plug-in
number=$("$program" --version | cut -d ' ' -f 2)
sed -i "s/${number//./\\.}/${number%?}~/g" version/* plug-in/lib*
sed -i 's/usage: resolvent/usage: Resolvent/' build/resolvent
differ "its program differs from that of process 0 (${number%?}~-" "$program" solve corner.obj "${wrong[@]}" : \
    version/resolvent solve corner.obj "${wrong[@]}"
differ "its program differs from that of process 0 ($number-" "$program" solve corner.obj "${wrong[@]}" : \
    build/resolvent solve corner.obj "${wrong[@]}"
differ "the plug-in for MPI and PETSc is of version" "$program" solve corner.obj "${wrong[@]}" : \
    plug-in/resolvent solve corner.obj "${wrong[@]}"
differ 'its operator file differs from that of process 0' "$program" render box.safetensors -o "$out/a.png" : \
    "$program" render one.safetensors -o "$out/a.png"
differ 'its operator file differs from that of process 0' "$program" relight box.safetensors -o "$out/a.png" : \
    "$program" relight one.safetensors -o "$out/a.png"
[[ -z $(ls -A "$out") ]] || complain "failures left files"

# A frame that cannot be written ends the whole sequence, not only the frames of its process
mkdir lost-1.exr
printf '0 light.light=1\n400 light.light=0.5\n' >long.txt
together 2 relight one.safetensors --script long.txt --size 16x12 --spp 1 --threads 1 -o lost-%d.exr
((status == 1)) || complain "exit status $status, not 1, for a frame that cannot be written"
[[ $(grep -c "^error: process 1 of 2: .*lost-1.exr" stderr) == 1 ]] || complain "a lost frame is not said once"
(($(ls -d lost-* | wc -l) < 200)) || complain "the others went on after a lost frame"
finish
