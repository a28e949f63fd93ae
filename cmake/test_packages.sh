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

# passed NAME [FILE]: says so, and what it took, if the room was lit: FILE, or room.png
passed() {
    [[ -s $root/tmp/${2:-room.png} ]]
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

# A picture by Blender itself, after the add-on was installed as users do it.
begin blender "$packages"/resolvent-blender-*.zip
inside "apt-get update && apt-get install -y --no-install-recommends blender python3-numpy"
cat >"$root/tmp/hello.py" <<'PYTHON'
import glob
import bpy
bpy.ops.preferences.addon_install(filepath=glob.glob("/tmp/resolvent-blender-*.zip")[0])
bpy.ops.preferences.addon_enable(module="resolvent_render")
bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = 64
bpy.context.scene.resolvent.quality = "draft"
assert bpy.ops.resolvent.render(mode="operator", filepath="/tmp/room.png") == {"FINISHED"}
PYTHON
inside "blender -b --factory-startup --python-exit-code 3 -P hello.py"
passed "zip for Blender"

# What relights a room was baked by the program of the tarball.
bake="resolvent-*/bin/resolvent bake cornell-blocks -o room.glb --to vertex --basis --quality draft"
begin npm "$packages"/resolvent-rt-*.tgz "$packages"/resolvent-*-linux-*.tar.gz
inside "apt-get update && apt-get install -y --no-install-recommends nodejs npm"
inside "tar xf resolvent-*-linux-*.tar.gz; $bake; npm install --no-audit --no-fund --legacy-peer-deps ./resolvent-rt-*.tgz"
cat >"$root/tmp/hello.mjs" <<'JAVASCRIPT'
import { readFile } from "node:fs/promises";
import { LightBasis, loadModule } from "resolvent-rt";
const room = await LightBasis.create(await loadModule(), (await readFile("room.light.safetensors")).buffer);
const [baked, half] = [1, 0.5].map((strength) => room.relight([[strength, strength, strength]]).reduce((sum, light) => sum + light));
if (!(baked > 0 && Math.abs(half / baked - 0.5) < 1e-3)) throw new Error(`${half} W/m2 at half strength, ${baked} at full`);
JAVASCRIPT
inside "node hello.mjs"
passed "npm package" room.glb

# Debian has Godot 3, in which the add-on's scripts that read bakes run; it itself is for Godot 4.
begin godot "$packages"/resolvent-godot-*.zip "$packages"/resolvent-*-linux-*.tar.gz
inside "apt-get update && apt-get install -y --no-install-recommends godot3-server"
inside "tar xf resolvent-*-linux-*.tar.gz; $bake"
cp -r "$here/integrations/godot/tests/godot3" "$root/tmp/project"
python3 -m zipfile -e "$packages"/resolvent-godot-*.zip "$root/tmp/project"
mv "$root/tmp/project/platform.gd" "$root/tmp/project/addons/resolvent"
cat >"$root/tmp/project/main.gd" <<'SCRIPT'
extends SceneTree
const LightBasis = preload("addons/resolvent/light_basis.gd")

func _init():
	var basis = LightBasis.read("/tmp/room.light.safetensors")
	print("the light of ", basis.names if basis.error == "" else basis.error)
	quit()
SCRIPT
inside "godot3-server --path project -s main.gd | grep -F 'the light of [light]'"
passed "zip for Godot" room.glb
