#!/usr/bin/env bash
# Out of memory anywhere in the program, or in the libraries it uses: one line of error, or the program continues.
# RSV_FAULTS=1 in the environment tries every call of malloc, and not one in so many.
# usage: test_memory.sh PROGRAM FAILING_MALLOC
source "$(dirname "$0")/support.sh"
malloc=$2
export OMP_NUM_THREADS=1

# survives STRIDE ARGUMENT...
survives() {
    local stride=$1 calls call
    shift
    RSV_FAIL=count LD_PRELOAD=$malloc succeeds "$@"
    calls=$(sed -n 's/^calls: //p' stderr)
    ((calls > 1000)) || complain "only $calls calls of malloc: $*"
    [[ -z ${RSV_FAULTS:-} ]] || stride=1
    # the last few calls are the ray tracer's threads that end themselves: nothing catches what they throw
    for ((call = 0; call < calls - 10; call += stride)); do
        rm -f "$out"/*
        status=0
        RSV_FAIL=$call timeout 60 env LD_PRELOAD="$malloc" "$program" "$@" >stdout 2>stderr </dev/null || status=$?
        ((status <= 1)) || complain "exit status $status where call $call of malloc fails: $*"
        ((status == 0)) || [[ -z $(ls -A "$out") ]] || complain "a failure at call $call left $(ls -A "$out")"
        ((status == 0)) || grep -qE '^(error: |libgomp: Out of memory)' stderr || complain "call $call fails in silence"
    done
}

fewest=(--quality draft --max-elements 60)
survives 97 render cornell-spheres -o "$out/a.png" --size 12x12 --spp 1 "${fewest[@]}"
succeeds scene cornell-blocks -o blocks.glb
survives 211 bake blocks.glb --to vertex -o "$out/a.glb" "${fewest[@]}"
finish
