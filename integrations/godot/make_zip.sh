#!/usr/bin/env bash
# The Godot add-on as one zip, to be unpacked into a project: make_zip.sh OUT_FOLDER
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
out=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r "$here/addons" "$work"
cp "$here/../../LICENSE" "$work/addons/resolvent"
version=$(sed -n 's/^version="\(.*\)"/\1/p' "$here/addons/resolvent/plugin.cfg")
name=resolvent-godot-$version.zip
rm -f "$out/$name"
(cd "$work" && find addons -type f | LC_ALL=C sort | python3 -c '
import sys, zipfile
with zipfile.ZipFile(sys.argv[1], "w", zipfile.ZIP_DEFLATED) as archive:
    for path in sys.stdin.read().split("\n"):
        if path:
            archive.write(path)
' "$out/$name")
echo "$out/$name"
