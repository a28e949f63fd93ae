#!/usr/bin/env bash
# All packages of one build, in one folder: make_packages.sh BUILD OUT_FOLDER
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "$1" && pwd)
rm -rf "$2"
mkdir -p "$2"
out=$(cd "$2" && pwd)

cpack --config "$build/CPackConfig.cmake" -B "$out" >/dev/null
rm -rf "$out/_CPack_Packages"
cp "$here/cmake/Containerfile" "$out"

# runs wherever the C library is as new as here
version=$(sed -n 's/^set(CPACK_PACKAGE_VERSION "\(.*\)")/\1/p' "$build/CPackConfig.cmake")
folder=$out/resolvent-$version-linux-$(uname -m)
cmake --install "$build" --component blender --prefix "$folder" --strip >/dev/null
"$here/cmake/copy_licences.sh" "$folder/lib" "$folder/licences"
cp "$here/LICENSE" "$here/README.md" "$folder"
tar -C "$out" -czf "$folder.tar.gz" "$(basename "$folder")"
rm -rf "$folder"

"$here/integrations/python/make_wheel.sh" "$build" "$out" >/dev/null
"$here/integrations/blender/make_zip.sh" "$build" "$out" >/dev/null
"$here/integrations/godot/make_zip.sh" "$out" >/dev/null
"$here/web/rt/pack.sh" "$out" >/dev/null
ls "$out"
