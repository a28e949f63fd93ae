#!/bin/bash
# The folders of src include each other in one direction: each only those above it in the table of src/README.md.
set -euo pipefail
cd "$1/src"
arrows=$(grep -r --include='*.[ch]' --include='*.cu' --include='*.cpp' --include='*.hpp' -o '#include "\.\./[a-z]*/' . |
    sed -E 's|^\./([a-z]*)/.*"\.\./([a-z]*)/|\1 \2|' | sort -u)
(($(wc -l <<<"$arrows") > 50)) || { echo "no includes found" >&2; exit 1; }
awk 'NR == FNR { if (match($0, /^\| `[a-z]+`/)) place[substr($0, 4, RLENGTH - 4)] = ++rooms; next }
    !place[$1] || !place[$2] { print $1 " -> " $2 ": not in the table of src/README.md"; wrong = 1; next }
    place[$2] >= place[$1] { print $1 " -> " $2 ": points down the table of src/README.md"; wrong = 1 }
    END { exit wrong }' README.md - <<<"$arrows" >&2
