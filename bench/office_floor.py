#!/usr/bin/env python3
"""Writes a floor of an office building as glTF: what `resolvent daylight` is timed on.

usage: office_floor.py OUT.glb [--rooms 20] [--triangles 200000]

Rooms of 4 x 6 m lie on both sides of a corridor, each with a window, a door that stands open, desks, chairs and plants.
Metres, y up; windows look north (-z) and south (+z). The same arguments give the same bytes.
"""
import argparse
import json
import math
import random
import struct

WIDTH, DEPTH, HEIGHT, CORRIDOR, WALL = 4.0, 6.0, 3.0, 2.0, 0.15
MATERIALS = {"floor": 0.2, "wall": 0.5, "ceiling": 0.7, "desk": 0.4, "chair": 0.15, "leaf": 0.25, "pane": None}


class Mesh:
    def __init__(self):
        self.position, self.index = [], []

    def quad(self, a, b, c, d, steps=1):
        """Counter-clockwise from the front, in steps x steps cells."""
        first = len(self.position)
        for i in range(steps + 1):
            for j in range(steps + 1):
                u, v = i / steps, j / steps
                self.position.append([(1 - u) * ((1 - v) * a[k] + v * d[k]) + u * ((1 - v) * b[k] + v * c[k])
                                      for k in range(3)])
        for i in range(steps):
            for j in range(steps):
                p = first + i * (steps + 1) + j
                q = p + steps + 1
                self.index += [p, q, q + 1, p, q + 1, p + 1]

    def box(self, low, high, steps=1):
        (x, y, z), (X, Y, Z) = low, high
        self.quad((x, y, Z), (X, y, Z), (X, Y, Z), (x, Y, Z), steps)
        self.quad((X, y, z), (x, y, z), (x, Y, z), (X, Y, z), steps)
        self.quad((X, y, Z), (X, y, z), (X, Y, z), (X, Y, Z), steps)
        self.quad((x, y, z), (x, y, Z), (x, Y, Z), (x, Y, z), steps)
        self.quad((x, Y, Z), (X, Y, Z), (X, Y, z), (x, Y, z), steps)
        self.quad((x, y, z), (X, y, z), (X, y, Z), (x, y, Z), steps)

    def ball(self, centre, radius, rings):
        """Two triangles per cell but at the poles: 4 rings (rings - 1) in all."""
        first, sectors = len(self.position), 2 * rings
        for i in range(rings + 1):
            for j in range(sectors):
                polar, turn = math.pi * i / rings, 2 * math.pi * j / sectors
                self.position.append([centre[0] + radius * math.sin(polar) * math.cos(turn),
                                      centre[1] + radius * math.cos(polar),
                                      centre[2] - radius * math.sin(polar) * math.sin(turn)])
        for i in range(rings):
            for j in range(sectors):
                a, b = first + i * sectors + j, first + i * sectors + (j + 1) % sectors
                if i > 0:
                    self.index += [a, b + sectors, b]
                if i < rings - 1:
                    self.index += [a, a + sectors, b + sectors]

    def triangles(self):
        return len(self.index) // 3


def wall_with_hole(mesh, x, X, z, Z, low, high, hole_x, hole_X):
    """A wall along x between z and Z with an opening from low to high."""
    mesh.box((x, 0, z), (hole_x, HEIGHT, Z))
    mesh.box((hole_X, 0, z), (X, HEIGHT, Z))
    if low > 0:
        mesh.box((hole_x, 0, z), (hole_X, low, Z))
    mesh.box((hole_x, high, z), (hole_X, HEIGHT, Z))


def furnish(meshes, x, z, side, rings, rng):
    """One room whose window is at z + side * DEPTH. @param rings of the chairs' and plants' balls"""
    for k in range(2):
        cx, cz = x + 1.0 + 1.7 * k, z + side * (2.0 + 1.8 * (k % 2))
        meshes["desk"].box((cx - 0.7, 0.7, cz - 0.4), (cx + 0.7, 0.74, cz + 0.4), 4)
        for dx in (-0.65, 0.6):
            meshes["desk"].box((cx + dx, 0, cz - 0.38), (cx + dx + 0.05, 0.7, cz + 0.38))
        meshes["chair"].ball((cx + rng.uniform(-0.2, 0.2), 0.3, cz - side * 0.75), 0.28, rings)
    for k in range(3):
        meshes["leaf"].ball((x + 0.4 + 0.12 * k, 0.5 + 0.3 * k, z + side * 5.4), 0.2, rings)


def build(rooms, triangles):
    rng = random.Random(1)
    count = (rooms + 1) // 2
    length = count * WIDTH
    rings = max(int(math.sqrt(triangles / (rooms * 5 * 4))), 3)
    meshes = {name: Mesh() for name in MATERIALS}
    half = CORRIDOR / 2
    edge = half + DEPTH
    meshes["floor"].box((0, -0.2, -edge), (length, 0, edge), 24)
    meshes["ceiling"].box((0, HEIGHT, -edge), (length, HEIGHT + 0.2, edge), 24)
    for k in range(rooms):
        side, x = (1, -1)[k % 2], (k // 2) * WIDTH
        z = side * half
        inner, outer = sorted((z, z + side * WALL)), sorted((z + side * (DEPTH - WALL), z + side * DEPTH))
        wall_with_hole(meshes["wall"], x, x + WIDTH, *inner, 0, 2.1, x + 1.5, x + 2.4)
        wall_with_hole(meshes["wall"], x, x + WIDTH, *outer, 0.9, 2.5, x + 0.4, x + WIDTH - 0.4)
        middle = sum(outer) / 2
        p = [(x + 0.4, 0.9), (x + WIDTH - 0.4, 0.9), (x + WIDTH - 0.4, 2.5), (x + 0.4, 2.5)]
        if side < 0:
            p.reverse()
        meshes["pane"].quad(*[(a, b, middle) for a, b in p])
        furnish(meshes, x, z, side, rings, rng)
    for k in range(count + 1):
        for side in (1, -1):
            low, high = sorted((side * (half + WALL), side * (edge - WALL)))
            x = min(max(k * WIDTH - WALL / 2, 0), length - WALL)
            meshes["wall"].box((x, 0, low), (x + WALL, HEIGHT, high))
    for x in (0, length - WALL):
        meshes["wall"].box((x, 0, -half), (x + WALL, HEIGHT, half))
    return meshes


def material(name):
    albedo = MATERIALS[name]
    if albedo is None:
        return {"name": name, "doubleSided": True, "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}},
                "pbrMetallicRoughness": {"roughnessFactor": 0, "metallicFactor": 0}}
    return {"name": name, "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
            "pbrMetallicRoughness": {"baseColorFactor": [albedo] * 3 + [1], "metallicFactor": 0}}


def write(path, meshes):
    data, views, accessors, parts = b"", [], [], []
    for number, (name, mesh) in enumerate(meshes.items()):
        flat = [c for p in mesh.position for c in p]
        for values, letter, kind, target in ((flat, "f", 5126, 34962), (mesh.index, "I", 5125, 34963)):
            chunk = struct.pack("<%d%s" % (len(values), letter), *values)
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(chunk), "target": target})
            accessors.append({"bufferView": len(views) - 1, "componentType": kind,
                              "count": len(values) // (3 if letter == "f" else 1),
                              "type": "VEC3" if letter == "f" else "SCALAR"})
            data += chunk
        accessors[-2]["min"] = [min(p[k] for p in mesh.position) for k in range(3)]
        accessors[-2]["max"] = [max(p[k] for p in mesh.position) for k in range(3)]
        parts.append({"name": name, "primitives": [{"attributes": {"POSITION": len(accessors) - 2},
                                                    "indices": len(accessors) - 1, "material": number}]})
    document = {"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_transmission", "KHR_materials_specular"],
                "scene": 0, "scenes": [{"nodes": list(range(len(parts)))}],
                "nodes": [{"name": p["name"], "mesh": k} for k, p in enumerate(parts)], "meshes": parts,
                "materials": [material(name) for name in meshes], "buffers": [{"byteLength": len(data)}],
                "bufferViews": views, "accessors": accessors}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data)))
        file.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
        file.write(struct.pack("<II", len(data), 0x004E4942) + data)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("output")
    parser.add_argument("--rooms", type=int, default=20)
    parser.add_argument("--triangles", type=int, default=200000)
    options = parser.parse_args()
    meshes = build(options.rooms, options.triangles)
    write(options.output, meshes)
    print(sum(mesh.triangles() for mesh in meshes.values()), "triangles")


if __name__ == "__main__":
    main()
