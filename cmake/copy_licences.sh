#!/usr/bin/env bash
# Licences of the libraries in a folder, as their packages tell them.
# usage: copy_licences.sh LIBRARY_FOLDER OUTPUT_FOLDER
set -euo pipefail
command -v dpkg-query >/dev/null || exit 0
mkdir -p "$2"
architecture=$(dpkg --print-architecture)
patterns=()
for library in "$1"/*.so*; do patterns+=("*/${library##*/}"); done
# one question for all of them, as each reads the lists of all packages; of the answers the first for each library, from the
# packages of this machine, not of compilers for others
{ dpkg-query -S "${patterns[@]}" 2>/dev/null || true; } | sed -n "s/:$architecture: .*\//\t/p" |
    awk -F '\t' '!seen[$2]++ { print $1 }' | sort -u | while read -r package; do
    cp "/usr/share/doc/$package/copyright" "$2/$package.txt" 2>/dev/null || true
done
