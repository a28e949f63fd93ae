#!/usr/bin/env bash
# The documentation as a site of static pages that need no server: the Markdown by MkDocs, the headers by Doxygen.
# usage: build.sh OUT [pages]    OUT/html/index.html; `pages`: without the headers
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
out=$(mkdir -p "$1" && cd "$1" && pwd)
cd "$root"

# the pages keep their paths, and with them their links
rm -rf "$out/pages" "$out/html"
mkdir "$out/pages"
cp --parents README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md LICENSE docs/*.md docs/figures/* docs/site/style.css \
    docs/site/site.js src/README.md web/rt/README.md samples/README.md samples/*.c samples/*/*.{c,h,py} \
    include/resolvent/*.h integrations/python/examples/*.py "$out/pages"
[[ ! -d docs/benchmarks ]] || cp -r docs/benchmarks "$out/pages/docs"
sed -e "s|^docs_dir:.*|docs_dir: $out/pages|; s|^site_dir:.*|site_dir: $out/html|" \
    -e "s|custom_dir: theme|custom_dir: $root/docs/site/theme|" docs/site/mkdocs.yml >"$out/mkdocs.yml"
mkdocs --quiet build --config-file "$out/mkdocs.yml"
rm -f "$out/html/sitemap.xml" "$out/html/sitemap.xml.gz" "$out/html/404.html"
if [[ ${2:-} == pages ]]; then
    mkdir "$out/html/reference"
    echo '<!doctype html><html lang="en"><title>Headers</title><p>The C headers are left out here.</p>' >"$out/html/reference/index.html"
else
    { cat docs/Doxyfile && echo "OUTPUT_DIRECTORY = $out" && echo "HTML_OUTPUT = html/reference"; } | doxygen - >&2
fi
python3 docs/site/search_index.py "$out/html"
