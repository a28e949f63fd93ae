#!/usr/bin/env bash
# Installs each of these packages in a clean Debian 12 and lights a room with it; needs root, debootstrap and a network.
# usage: test_packages.sh PACKAGES [ROOT]    ROOT: a folder with such a system, which stays as it is
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
packages=$(cd "$1" && pwd)
skip() {
    echo "skipped: $*"
    exit 77
}
((EUID == 0)) || skip "only root may enter another system"
command -v debootstrap >/dev/null || skip "debootstrap is not installed"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
clean=${2:-$work/clean}
[[ -d $clean ]] || debootstrap --variant=minbase bookworm "$clean" >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }

# begin NAME FILE...: a copy of the clean system, with these files in its /tmp
begin() {
    root=$work/$1
    cp -a "$clean" "$root"
    cp /etc/resolv.conf "$root/etc/resolv.conf"
    cp "${@:2}" "$root/tmp"
}

# inside COMMAND: what a user types there; its output is shown if it fails. /proc is mounted for it alone: without it, no
# program finds the libraries beside it.
inside() {
    unshare --mount --pid --fork --mount-proc="$root/proc" chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive \
        bash -ec "cd /tmp; $1" >"$work/log" 2>&1 || { cat "$work/log" && exit 1; }
}

# passed NAME: says so, and what it took
passed() {
    [[ -s $root/tmp/room.png ]]
    echo "$1: installed and used, $(du -sm "$root" | cut -f1) MB with the system"
    rm -rf "$root"
}
hello="render cornell-blocks --quality draft --size 64x64 --spp 4 -o room.png"

begin container "$packages"/resolvent_*.deb
inside "$(sed -n 's/^RUN //p' "$packages/Containerfile")"
inside "resolvent $hello"
passed "resolvent_*.deb, as the container file does it"

begin tarball "$packages"/resolvent-*-linux-*.tar.gz
inside "tar xf resolvent-*.tar.gz"
inside "resolvent-*/bin/resolvent $hello"
passed "tarball"

begin wheel "$packages"/*.whl "$here/integrations/python/examples/hello_room.py"
inside "apt-get update && apt-get install -y --no-install-recommends python3-pip python3-numpy python3-scipy python3-cffi"
inside "pip install --no-index --break-system-packages ./*.whl"
inside "python3 hello_room.py --picture room.png"
passed "wheel"
