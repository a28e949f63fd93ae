#!/usr/bin/env python3
"""Writes an office for docs/office.md: office.glb, desks.csv and panel.ies, in the current folder.

The room is 6 m wide (x), 8 m deep (z) and 3 m high (y). Its windows are in the wall at z = 0 and look towards -z. Nodes
named `panel 1` to `panel 9` below the ceiling mark where luminaires go.
"""
import json
import math
import struct

WIDTH, DEPTH, HEIGHT = 6.0, 8.0, 3.0
SILL, LINTEL, DESK = 0.9, 2.6, 0.75
ALBEDO = {"floor": 0.2, "walls": 0.5, "ceiling": 0.7, "furniture": 0.4}
WINDOW_TRANSMITTANCE = 0.72


class Mesh:
    """Quads, as triangles; corners counter-clockwise seen from the front."""

    def __init__(self):
        self.position, self.index = [], []

    def quad(self, *corners):
        first = len(self.position)
        self.position += corners
        self.index += [first + k for k in (0, 1, 2, 0, 2, 3)]

    def box(self, low, high):
        (x, y, z), (X, Y, Z) = low, high
        self.quad((x, y, Z), (X, y, Z), (X, Y, Z), (x, Y, Z))
        self.quad((X, y, z), (x, y, z), (x, Y, z), (X, Y, z))
        self.quad((X, y, Z), (X, y, z), (X, Y, z), (X, Y, Z))
        self.quad((x, y, z), (x, y, Z), (x, Y, Z), (x, Y, z))
        self.quad((x, Y, Z), (X, Y, Z), (X, Y, z), (x, Y, z))
        self.quad((x, y, z), (X, y, z), (X, y, Z), (x, y, Z))


def desks():
    """Middles of the desk tops."""
    return [(x, z) for z in (2.0, 5.5) for x in (1.5, 4.5)]


def panels():
    """Middles of the ceiling panels, row by row from the windows."""
    return [(x, z) for z in (1.5, 4.0, 6.5) for x in (1.0, 3.0, 5.0)]


def build():
    meshes = {name: Mesh() for name in (*ALBEDO, "glass")}
    meshes["floor"].box((-0.2, -0.2, -0.2), (WIDTH + 0.2, 0, DEPTH + 0.2))
    meshes["ceiling"].box((-0.2, HEIGHT, -0.2), (WIDTH + 0.2, HEIGHT + 0.2, DEPTH + 0.2))
    walls = meshes["walls"]
    walls.box((-0.2, 0, 0), (0, HEIGHT, DEPTH))
    walls.box((WIDTH, 0, 0), (WIDTH + 0.2, HEIGHT, DEPTH))
    walls.box((-0.2, 0, DEPTH), (WIDTH + 0.2, HEIGHT, DEPTH + 0.2))
    walls.box((-0.2, 0, -0.2), (WIDTH + 0.2, SILL, 0))
    walls.box((-0.2, LINTEL, -0.2), (WIDTH + 0.2, HEIGHT, 0))
    for x, X in ((-0.2, 0.5), (2.75, 3.25), (5.5, WIDTH + 0.2)):
        walls.box((x, SILL, -0.2), (X, LINTEL, 0))
    for x, X in ((0.5, 2.75), (3.25, 5.5)):
        meshes["glass"].quad((x, SILL, -0.1), (X, SILL, -0.1), (X, LINTEL, -0.1), (x, LINTEL, -0.1))
    for x, z in desks():
        meshes["furniture"].box((x - 0.8, DESK - 0.04, z - 0.4), (x + 0.8, DESK, z + 0.4))
        for side in (-0.78, 0.74):
            meshes["furniture"].box((x + side, 0, z - 0.35), (x + side + 0.04, DESK - 0.04, z + 0.35))
    return meshes


def material(name):
    if name == "glass":  # an interface of ior 1.5 reflects 4 % at normal incidence
        tint = WINDOW_TRANSMITTANCE / 0.96
        return {"name": name, "doubleSided": True, "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}},
                "pbrMetallicRoughness": {"baseColorFactor": [tint] * 3 + [1], "roughnessFactor": 0, "metallicFactor": 0}}
    return {"name": name, "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
            "pbrMetallicRoughness": {"baseColorFactor": [ALBEDO[name]] * 3 + [1], "metallicFactor": 0}}


def write_glb(path, meshes):
    data, views, accessors, nodes, parts = b"", [], [], [], []
    for number, (name, mesh) in enumerate(meshes.items()):
        positions = [value for corner in mesh.position for value in corner]
        for chunk, kind, count, shape in ((struct.pack(f"<{len(positions)}f", *positions), 5126, len(mesh.position), "VEC3"),
                                          (struct.pack(f"<{len(mesh.index)}I", *mesh.index), 5125, len(mesh.index), "SCALAR")):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(chunk)})
            accessors.append({"bufferView": len(views) - 1, "componentType": kind, "count": count, "type": shape})
            data += chunk
        accessors[-2]["min"] = [min(p[k] for p in mesh.position) for k in range(3)]
        accessors[-2]["max"] = [max(p[k] for p in mesh.position) for k in range(3)]
        parts.append({"name": name, "primitives": [{"attributes": {"POSITION": 2 * number}, "indices": 2 * number + 1,
                                                    "material": number}]})
        nodes.append({"name": name, "mesh": number})
    nodes += [{"name": f"panel {k + 1}", "translation": [x, HEIGHT - 0.01, z]} for k, (x, z) in enumerate(panels())]
    turn = math.radians(-10) / 2  # towards the windows, and a little down
    nodes.append({"name": "view", "camera": 0, "translation": [3, 1.7, DEPTH - 0.2],
                  "rotation": [math.sin(turn), 0, 0, math.cos(turn)]})
    document = {"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_transmission", "KHR_materials_specular"],
                "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": parts,
                "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}],
                "materials": [material(name) for name in meshes], "buffers": [{"byteLength": len(data)}],
                "bufferViews": views, "accessors": accessors}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data)))
        file.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
        file.write(struct.pack("<II", len(data), 0x004E4942) + data)


def write_points(path):
    """Fifteen points on each desk, 0.3 m apart."""
    with open(path, "w") as file:
        file.write("x,y,z,nx,ny,nz\n")
        for x, z in desks():
            for dz in (-0.3, 0, 0.3):
                for dx in (-0.6, -0.3, 0, 0.3, 0.6):
                    file.write(f"{x + dx:.2f},{DESK},{z + dz:.2f},0,1,0\n")


def write_luminaire(path, lumens=4200):
    """A diffuse panel of 0.6 x 0.6 m that shines downwards: intensity lumens / pi x cos(angle)."""
    angles = range(0, 91, 5)
    candela = " ".join(f"{lumens / math.pi * math.cos(math.radians(a)):.1f}" for a in angles)
    with open(path, "w") as file:
        file.write("IESNA:LM-63-2002\n[LUMINAIRE] diffuse panel\nTILT=NONE\n"
                   f"1 {lumens} 1 {len(angles)} 1 1 2 0.6 0.6 0\n1 1 35\n"
                   f"{' '.join(map(str, angles))}\n0\n{candela}\n")


if __name__ == "__main__":
    write_glb("office.glb", build())
    write_points("desks.csv")
    write_luminaire("panel.ies")
