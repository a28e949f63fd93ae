#!/usr/bin/env bash
# The Blender add-on with the program inside, as one zip: make_zip.sh BUILD OUT_FOLDER
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
mkdir -p "$2"
out=$(cd "$2" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
addon=$work/resolvent_render

mkdir "$addon"
cp "$here"/resolvent_render/*.py "$here"/resolvent_render/blender_manifest.toml "$here/LICENSE" "$addon"
cmake --install "$build" --component blender --prefix "$addon/program" --strip >/dev/null
"$here/../../cmake/copy_licences.sh" "$addon/program/lib" "$addon/program/licences"
cp "$here/../../LICENSE" "$addon/program"
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$addon/blender_manifest.toml")
architecture=$(uname -m)
name=resolvent-blender-$version-linux-$architecture.zip
rm -f "$out/$name"
(cd "$work" && python3 - "$out/$name" <<'PYTHON'
import os
import sys
import zipfile

# links become files, in place of what they point to: zip readers, Blender's among them, do not make links
targets = {os.path.realpath(os.path.join(folder, file)) for folder, _, files in os.walk("resolvent_render")
           for file in files if os.path.islink(os.path.join(folder, file))}
with zipfile.ZipFile(sys.argv[1], "w", zipfile.ZIP_DEFLATED) as archive:
    for folder, _, files in sorted(os.walk("resolvent_render")):
        for file in sorted(files):
            path = os.path.join(folder, file)
            if os.path.islink(path) or os.path.abspath(path) not in targets:
                archive.write(path)
PYTHON
)
echo "$out/$name"
