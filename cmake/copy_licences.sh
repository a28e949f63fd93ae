#!/usr/bin/env bash
# Licences of the libraries in a folder, as their packages tell them.
# usage: copy_licences.sh LIBRARY_FOLDER OUTPUT_FOLDER
set -euo pipefail
command -v dpkg-query >/dev/null || exit 0
mkdir -p "$2"
architecture=$(dpkg --print-architecture)
for library in "$1"/*.so*; do # those of this machine, not of compilers for others
    package=$(dpkg-query -S "*/$(basename "$library")" 2>/dev/null | sed -n "s/:$architecture: .*//p" | head -n 1) || continue
    [[ -z $package ]] || cp "/usr/share/doc/$package/copyright" "$2/$package.txt" 2>/dev/null || true
done
