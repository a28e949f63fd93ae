#!/bin/bash
# Who may include whom: the rooms of src, and the programs beside it; and that loops leave threads to one room.
set -euo pipefail
cd "$1"

# includes FOLDER...: "FILE HEADER" of every include
includes() {
    grep -rE --include='*.[ch]' --include='*.cu' --include='*.[ch]pp' '^ *# *include *["<]' "$@" |
        sed -E 's/^([^:]*): *# *include *["<]([^">]*)[">].*/\1 \2/'
}

# Rooms include exactly those that the table of src/README.md lists for them, all of them above. What is listed as NAME.h is
# a public header alone, wherever its room stands. A header *_internal.h is its room's own.
rooms() {
    includes src | awk '
        function complain(what) { print what > "/dev/stderr"; wrong = 1 }
        BEGIN { FS = " *[|] *"; owner["image"] = owner["animation"] = "io"; owner["edit"] = "scene"; owner["team"] = owner["device"] = "core" }
        NR == FNR && /^[|] `[a-z]+` [|]/ {
            room = substr($2, 2, length($2) - 2)
            name[++count] = room
            place[room] = count
            listed[room] = $4
            for (i = split($4, list, /, /); i > 0; i--)
                if ($4 != "-") may[room, list[i]] = 1
        }
        NR == FNR { next }
        FNR == 1 { FS = " "; $0 = $0 }
        {
            split($1, path, "/")
            room = path[2]
            seen[room] = 1
            target = alone = ""
            if (match($2, /^[.][.]\/[a-z]+\//)) target = substr($2, 4, RLENGTH - 4)
            else if ($2 ~ /^resolvent\/[a-z]+[.]h$/) {
                alone = substr($2, 11)
                target = substr(alone, 1, length(alone) - 2)
                if (target in owner) target = owner[target]
            }
            if (target != "" && $2 ~ /_internal[.]h$/) complain($1 ": " $2 " is of another room")
            if (target == "" || target == room) next
            includes_found++
            entry = (room, target) in may ? target : alone
            if ((room, entry) in may) used[room, entry] = 1
            else if (!said[room, target]++) complain($1 ": " $2 ": src/README.md lists nothing of " target " for " room)
        }
        END {
            for (room in seen) if (!(room in place)) complain("src/" room " is not in the table of src/README.md")
            for (n = 1; n <= count; n++)
                for (i = split(listed[name[n]], list, /, /); i > 0; i--) {
                    if (list[i] == "-") continue
                    if (list[i] !~ /[.]h$/ && !(list[i] in place && place[list[i]] < n))
                        complain("src/README.md: " list[i] " does not stand above " name[n])
                    if (!((name[n], list[i]) in used))
                        complain("src/README.md: " name[n] " includes nothing of " list[i])
                }
            if (includes_found < 500) complain("only " includes_found + 0 " includes found")
            exit wrong
        }' src/README.md -
}

# Programs include headers of their own folder and public ones; the runtime depends on nothing.
programs() {
    # The program calls its benchmarks, which are commands of it and use what commands share.
    local exceptions="apps/bench.h bench/command.h bench/crew.h bench/device.h bench/options.h bench/output_file.h bench/parallel.h bench/session.h
        bench/stats.h bench/subject.h"
    { find apps bench samples rt include src -name '*.h' && echo && includes apps bench samples rt; } |
        awk -v exceptions="$exceptions" '
        BEGIN { for (i = split(exceptions, list, /[ \n]+/); i > 0; i--) excepted[list[i]] = 1 }
        /^$/ { all_known = 1; next }
        !all_known { known[$1] = 1; next }
        {
            folder = $1
            sub(/\/.*/, "", folder)
            beside = $1
            sub(/[^\/]*$/, "", beside)
            beside = beside $2
            while (sub(/[^\/.]+\/[.][.]\//, "", beside)) continue
            if (("include/" $2) in known && folder != "rt" || ("rt/" $2) in known) next
            if (beside in known && index(beside, folder "/") == 1) next
            if ((folder "/" $2) in excepted) { used[folder "/" $2] = 1; next }
            if (beside in known || ("src/" $2) in known || ("include/" $2) in known ||
                ("apps/resolvent/" $2) in known || ("bench/" $2) in known) {
                print $1 ": " $2 " is neither public nor in " folder > "/dev/stderr"
                wrong = 1
            }
        }
        END {
            for (one in excepted) if (!(one in used)) { print "nothing needs " one > "/dev/stderr"; wrong = 1 }
            exit wrong
        }'
}

# Loops run on the workers of a context, which may be threads of an embedding program (src/core/parallel.h).
loops() {
    ! grep -rn --include='*.[ch]' '# *pragma omp' src apps bench |
        grep -vE '^src/core/parallel\.c:|pragma omp (declare )?simd' |
        sed 's/$/: loops go through src\/core\/parallel.h/' | grep . >&2
}

failed=0
rooms || failed=1
loops || failed=1
programs || failed=1
exit $failed
