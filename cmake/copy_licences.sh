#!/usr/bin/env bash
# Licences of the libraries in a folder, as their packages tell them.
# usage: copy_licences.sh LIBRARY_FOLDER OUTPUT_FOLDER
set -euo pipefail
command -v dpkg-query >/dev/null || exit 0
mkdir -p "$2"
for library in "$1"/*.so*; do
    package=$(dpkg-query -S "*/$(basename "$library")" 2>/dev/null | head -n 1 | cut -d: -f1) || continue
    [[ -z $package ]] || cp "/usr/share/doc/$package/copyright" "$2/$package.txt" 2>/dev/null || true
done
