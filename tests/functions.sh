#!/usr/bin/env bash
# functions.sh ROOT: how long functions in C are and how many parameters they have, as clang-format lays them out. Fails where
# one has more than 60 lines or over 6 parameters, and where more than one of 20 has over 25 lines.
set -euo pipefail
cd "$1"
find src include apps bench rt samples -name '*.[ch]' -print0 | sort -z |
    xargs -0 awk '
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
    if (wide > 6) too_wide = too_wide FILENAME ":" line ": " wide " parameters\n"
    if (lines > 60) too_long = too_long FILENAME ":" line ": " lines " lines\n"
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
    printf "%d functions, %d of them over 25 lines\n", functions, long
    if (too_long) printf "over 60 lines:\n%s", too_long
    if (20 * long > functions) print "more than one function of 20 has over 25 lines"
    if (too_wide) printf "over 6 parameters; give what belongs together a struct:\n%s", too_wide
    exit too_long != "" || too_wide != "" || 20 * long > functions
}'
