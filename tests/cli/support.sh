# What the tests of the program share. Each test is called with the program's path and sources this.
#
# After `run`: $status, and the files $work/stdout and $work/stderr. Outputs belong in $out, which
# `refuses` wants empty. A failed check is printed and counted, and the test continues.
set -uo pipefail

program=$1
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
out=$work/out
mkdir "$out"
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

complain() {
    echo "FAILED: $*"
    sed 's/^/    stderr: /' stderr | head -n 5
    failures=$((failures + 1))
}

finish() {
    ((failures == 0)) && echo "all passed"
    exit $((failures > 0))
}

run() {
    status=0
    "$program" "$@" >stdout 2>stderr </dev/null || status=$?
}

# succeeds ARGUMENT...
succeeds() {
    run "$@"
    ((status == 0)) || complain "exit status $status, not 0: $*"
}

# Standard error without warnings, notes and progress.
error_lines() { grep -v -e '^warning: ' -e '^note: ' -e '^[a-z0-9 :]*: [0-9]* %' stderr; }

# refuses STATUS PATTERN ARGUMENT...: exits with STATUS, prints one line that matches PATTERN, and writes no file
refuses() {
    local expected=$1 pattern=$2
    shift 2
    run "$@"
    ((status == expected)) || complain "exit status $status, not $expected: $*"
    [[ $(error_lines | wc -l) == 1 ]] || complain "not exactly one line of error: $*"
    error_lines | grep -q -i -e "$pattern" || complain "the message does not speak of '$pattern': $*"
    [[ ! -s stdout ]] || complain "a failure printed on standard output: $*"
    [[ -z $(ls -A "$out") ]] || complain "a failure left $(ls -A "$out"): $*"
    rm -f "$out"/*
}

# says PATTERN: the standard output of the last run matches
says() { grep -q -e "$1" stdout || complain "standard output lacks '$1'"; }

# warns PATTERN: the standard error of the last run matches
warns() { grep -q -i -e "$1" stderr || complain "standard error lacks '$1'"; }

# Pictures small enough for a test.
small=(--size 32x24 --quality draft --spp 1 --threads 2)

# open_display WIDTHxHEIGHT XVFB-OPTION...: a display of the test's own, for SDL
open_display() {
    Xvfb -displayfd 3 -screen 0 "$1x24" "${@:2}" -nolisten tcp 3>display >/dev/null 2>&1 &
    server=$!
    trap 'kill $server 2>/dev/null; rm -rf "$work"' EXIT
    for ((k = 0; k < 100; k++)); do
        [[ -s display ]] && break
        sleep 0.1
    done
    export DISPLAY=:$(cat display) SDL_VIDEODRIVER=x11
}
