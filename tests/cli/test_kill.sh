#!/usr/bin/env bash
# Runs killed at random moments leave no incomplete file, and the next run ends with the same bytes.
# test_kill.sh PROGRAM [KILLS [SEED]]
source "$(dirname "$0")/support.sh"
kills=${2:-8}
RANDOM=${3:-1}

succeeds scene furnace -o box.glb
quick=(--quality draft --max-elements 200 --threads 1)
solve=(solve cornell-blocks --quality draft --max-elements 400 --threads 1)
bake=(bake box.glb --to vertex "${quick[@]}")

# milliseconds COMMAND...: how long it takes
milliseconds() {
    local start=${EPOCHREALTIME/[.,]/}
    succeeds "$@"
    echo $(((${EPOCHREALTIME/[.,]/} - start) / 1000))
}
solve_time=$(milliseconds "${solve[@]}" -o whole.safetensors)
bake_time=$(milliseconds "${bake[@]}" -o whole.glb)

# kill_and_resume EXTENSION LENGTH COMMAND...: killed within its first LENGTH milliseconds (or done before), then run
# again
kill_and_resume() {
    local result=$out/result.$1 after=$((RANDOM * $2 / 32768)) resume=()
    shift 2
    "$program" "$@" -o "$result" --checkpoint rows >stdout 2>stderr </dev/null &
    sleep "$((after / 1000)).$(printf '%03d' "$((after % 1000))")"
    kill -KILL $! 2>/dev/null && ((killed++))
    wait $! 2>/dev/null
    [[ ! -e $result ]] || cmp -s "$result" "whole.${result##*.}" ||
        complain "half a file after $after ms: $*"
    [[ -n $(find rows -mindepth 1 -type d 2>/dev/null) ]] && resume=(--resume)
    succeeds "$@" -o "$result" --checkpoint rows "${resume[@]}"
    grep -q 'are known already' stderr && ((helped++))
    cmp -s "$result" "whole.${result##*.}" || complain "other bytes when resumed after $after ms: $*"
    rm -rf rows "$out"
    mkdir "$out"
}

killed=0 helped=0
for ((k = 0; k < kills; k += 2)); do
    kill_and_resume safetensors "$solve_time" "${solve[@]}"
    kill_and_resume glb "$bake_time" "${bake[@]}"
done
echo "$killed of $kills killed, $helped went on with rows"
((helped > 0)) || complain "no run went on with the rows of another"

# An interrupted run says how to go on
"$program" "${solve[@]}" --quality high -o "$out/a.safetensors" --checkpoint rows >stdout 2>stderr </dev/null &
until [[ -n $(find rows -name '*.rows' -size +0 2>/dev/null) ]]; do sleep 0.02; done
kill -TERM $!
wait $! && complain "an interrupted run succeeds"
[[ $(grep -v -e ' %' -e '^warning' stderr) == "cancelled; the same command continues with the rows saved in 'rows'" ]] ||
    complain "does not say how to go on"
[[ -z $(ls -A "$out") ]] || complain "an interrupted run left $(ls -A "$out")"
refuses 1 "holds no rows of this scene" solve furnace "${quick[@]}" -o "$out/a.safetensors" --checkpoint rows --resume
refuses 2 'checkpoint' "${bake[@]}" -o "$out/a.glb" --resume

# A full disk ends the run; once there is room, the same command continues with the rows that were saved
full=(bake cornell-blocks --to vertex "${quick[@]}" --max-elements 1000 --checkpoint full)
(
    ulimit -f 400
    refuses 1 "checkpoint: cannot write 'full/.*': File too large; once that is fixed" "${full[@]}" -o "$out/full.glb"
    exit $failures
) || failures=$((failures + $?))
succeeds "${full[@]}" -o resumed.glb --resume
warns '^note: checkpoint: [0-9]* rows'
succeeds "${full[@]}" -o whole.glb --checkpoint other
cmp -s whole.glb resumed.glb || complain "other bytes after a full disk"
finish
