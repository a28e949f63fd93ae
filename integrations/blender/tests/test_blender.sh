#!/usr/bin/env bash
# The add-on in the Blender that is installed: test_blender.sh BUILD quick|all|window|cycles|bench [FOLDER]
# `all` installs the zip of make_zip.sh as users do; `window` opens one in Xvfb; `cycles` compares pictures with those of Cycles;
# `bench` bakes a lightmap with both (TEXELS, TRIANGLES, SAMPLES of Cycles).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=$(cd "$1" && pwd)
kind=$2
skip() {
    echo "skipped: $*"
    exit 77
}
command -v blender >/dev/null || skip "Blender is not installed"
blender -b --factory-startup --python-exit-code 3 --python-expr 'import numpy' >/dev/null 2>&1 ||
    skip "Blender has no numpy"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export BLENDER_USER_SCRIPTS=$work/scripts BLENDER_USER_CONFIG=$work/config OMP_WAIT_POLICY=passive
in_blender() { blender -b --factory-startup --python-exit-code 3 "$@"; }

# Blender's own messages, which are many, are shown only on failure
run() {
    if ! in_blender "$@" >"$work/log" 2>&1; then
        cat "$work/log"
        exit 1
    fi
    grep -E '^(test_|RESULT|failed|all of|    )' "$work/log"
}

if [[ $kind == all ]]; then
    zip=$("$here/../make_zip.sh" "$build" "$work/zip" | tail -n 1)
    echo "$(basename "$zip"): $(stat -c %s "$zip") bytes"
    mkdir -p "$BLENDER_USER_SCRIPTS/addons"
    in_blender --python-expr "
import bpy
bpy.ops.preferences.addon_install(filepath='$zip')
bpy.ops.preferences.addon_enable(module='resolvent_render')
from resolvent_render.program import find_program
assert find_program().startswith('$work'), find_program()
" >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
    PATH=/usr/bin:/bin run -P "$here/test_addon.py" -- "$work/out"
    exit
fi
mkdir -p "$BLENDER_USER_SCRIPTS/addons"
ln -s "$here/../resolvent_render" "$BLENDER_USER_SCRIPTS/addons/resolvent_render"
export PATH=$build/bin:$PATH PYTHONDONTWRITEBYTECODE=1
case $kind in
quick) run -P "$here/test_addon.py" -- "$work/out" quick ;;
window)
    command -v xvfb-run >/dev/null || skip "xvfb-run is not installed"
    mkdir -p "${3:-$work/out}"
    LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -s '-screen 0 1280x800x24' blender --factory-startup --enable-event-simulate \
        --window-geometry 0 0 1280 800 \
        -P "$here/window.py" -- "${3:-$work/out}" >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
    grep -E '^(baked|solved|recoloured|moved|the window)' "$work/log"
    ;;
cycles) run -P "$here/compare_cycles.py" -- "${3:-$work/out}" "${SAMPLES:-128}" ;;
bench) run -P "$here/bench_bake.py" -- "${3:-$work/out}" "${TEXELS:-1024}" "${TRIANGLES:-100000}" "${SAMPLES:-256}" ;;
*) echo "error: '$kind' is none of quick, all, window, cycles, bench" >&2 && exit 2 ;;
esac
