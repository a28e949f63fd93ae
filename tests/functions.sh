#!/usr/bin/env bash
# functions.sh ROOT: how long functions in C are and how many parameters they have, as clang-format lays them out. Fails where
# one has more than 60 lines, where more than one of 20 has over 25, and where more than `most_wide` have over 6 parameters: older
# code, to be lowered as it is mended. `functions.sh ROOT list` names those.
set -euo pipefail
cd "$1"
most_wide=49
find src include apps bench rt samples -name '*.[ch]' -print0 | sort -z |
    xargs -0 awk -v most_wide="$most_wide" -v list="${2:-}" '
function parameters(text,    depth, count, k, c) {
    sub(/^[^(]*/, "", text)
    for (k = 1; k <= length(text); k++) {
        c = substr(text, k, 1)
        depth += (c == "(") - (c == ")")
        count += c == "," && depth == 1
        if (depth == 0) break
    }
    return count + 1
}
function note(line, head, lines,    wide) {
    functions++
    long += lines > 25
    wide = parameters(head)
    wide_ones += wide > 6
    if (lines > 60) too_long = too_long FILENAME ":" line ": " lines " lines\n"
    if (wide > 6 && list) print FILENAME ":" line ": " wide " parameters"
}
FNR == 1 { head = ""; inside = 0 }
inside && /^}/ {
    inside = 0
    if (head ~ /\(/ && head !~ /=/) note(started, head, FNR - started - 1)
    head = ""
}
inside { next }
/^{$/ { inside = 1; started = FNR; next }
/^$|^\/\/|^#|^}|;$/ { head = ""; next }
/^[^ ].*\) *{.*}$/ { note(FNR, $0, 1); head = ""; next } # all of it on one line
{ head = head $0 }
END {
    printf "%d functions, %d of them over 25 lines, %d with over 6 parameters\n", functions, long, wide_ones
    if (too_long) printf "over 60 lines:\n%s", too_long
    if (20 * long > functions) print "more than one function of 20 has over 25 lines"
    if (wide_ones > most_wide)
        print wide_ones " functions have over 6 parameters, " most_wide " had: give what belongs together a struct"
    exit too_long != "" || 20 * long > functions || wide_ones > most_wide
}'
