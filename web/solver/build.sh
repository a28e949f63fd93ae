#!/usr/bin/env bash
# The solver for web pages: build.sh OUT_FOLDER. Needs Debian's package emscripten. Compiles what has changed, in
# build/web-solver: all of it takes four minutes of CPU time. Sources of cJSON, zlib and meshoptimizer are fetched from Debian
# once, into build/web-sources; on another system, put them there.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
mkdir -p "$1" "$root/build"
out=$(cd "$1" && pwd)
build=$root/build/web-solver
sources=$root/build/web-sources

# fetch PACKAGE: its source package, unpacked, without changing what the system's apt knows
fetch() {
    local apt=(-o "Dir::Etc::sourcelist=$sources/apt/sources.list" -o Dir::Etc::sourceparts=-
        -o "Dir::State::lists=$sources/apt/lists" -o "Dir::Cache=$sources/apt/cache" -o APT::Sandbox::User=root)
    [[ -d $sources/$1 ]] && return
    if [[ ! -e $sources/apt/sources.list ]]; then
        mkdir -p "$sources"/apt/{lists,cache/archives}/partial
        echo "deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian bookworm main" \
            >"$sources/apt/sources.list"
    fi
    [[ -n $(ls "$sources"/apt/lists/*Sources* 2>/dev/null) ]] || apt-get "${apt[@]}" -qq update
    (cd "$sources/apt" && apt-get "${apt[@]}" -qq source --download-only "$1" && dpkg-source --no-check -x "$1"_*.dsc "$sources/$1") >/dev/null
}

for package in cjson zlib meshoptimizer; do fetch "$package"; done
# the system's cache of libraries may be read-only, and its optimiser of JavaScript looks for Debian's modules
export EM_CACHE=$root/build/web-cache NODE_PATH=/usr/share/nodejs
[[ -d $EM_CACHE ]] || cp -r /usr/share/emscripten/cache "$EM_CACHE"
emcmake cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_CROSSCOMPILING_EMULATOR="$(command -v node);--no-experimental-fetch" -DRSV_SOURCES="$sources" >/dev/null
cmake --build "$build" --target solver_threads solver_alone --parallel "$(nproc)"
cp "$here/worker.js" "$out/solver_worker.js"
cp "$build"/bin/solver_{threads,alone}.{js,wasm} "$build/bin/solver_threads.worker.js" "$out"
cat "$sources"/cjson/LICENSE "$sources"/meshoptimizer/LICENSE.md /usr/share/doc/{zlib1g-dev,emscripten,nlohmann-json3-dev,libstb-dev}/copyright \
    >"$out/solver_licences.txt"
