#!/usr/bin/env bash
# Some pages of the documentation in headless Chromium, looked at by axe-core.
# usage: test_axe.sh WEB_FOLDER SITE_FOLDER
set -euo pipefail
[[ -d $1/node_modules/axe-core ]] && command -v chromium >/dev/null ||
    { echo "skipped: web/node_modules or chromium is absent" && exit 77; }
CHROMIUM=$(command -v chromium) node "$(dirname "$0")/test_axe.mjs" "$1" "$2" index.html docs/start-here.html docs/bake.html \
    docs/gallery.html docs/theory.html docs/photometry.html
