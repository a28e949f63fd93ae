#!/usr/bin/env bash
# Words of the documentation: no dead link, no line of prose over 120 characters, none of the words of words.txt, and no
# spelling mistake that codespell knows (also in the sources).
# usage: words.sh ROOT
set -euo pipefail
cd "$1"
here=tests
bad=0
if ! git rev-parse --is-inside-work-tree >/dev/null 2>&1 || ! command -v python3 >/dev/null; then
    echo "skipped: this is no git repository, or python3 is missing" >&2
    exit 77
fi

mapfile -t pages < <(git ls-files '*.md' ':!docs/site')
python3 $here/links.py "${pages[@]}" || bad=1

# tables, code and links may be longer
for page in "${pages[@]}"; do
    LC_ALL=C.UTF-8 sed 's/](http[^)]*)/]()/g' "$page" | awk -v page="$page" '
        /^```/ { code = !code }
        !code && length($0) > 120 && !/^[|<!]/ && !/^    / { print page ":" NR ": longer than 120 characters"; bad = 1 }
        END { exit bad }' || bad=1
done

while IFS=$'\t' read -r avoid better; do
    [[ -z $avoid || $avoid == \#* ]] && continue
    found=$(grep -nE -e "$avoid" -- README.md CONTRIBUTING.md docs/*.md docs/benchmarks/*.md | sed "s|\$|    (write: $better)|") || continue
    printf '%s\n' "$found"
    bad=1
done <$here/words.txt

if command -v codespell >/dev/null; then
    git ls-files '*.md' '*.c' '*.h' '*.cpp' '*.cu' '*.py' '*.sh' '*.js' dev | grep -v package-lock | xargs codespell || bad=1
else
    echo "skipped: codespell, which is not installed" >&2
fi
exit $bad
