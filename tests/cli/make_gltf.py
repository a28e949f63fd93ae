"""Writes a room of 4 x 3 x 5 m as glTF: make_gltf.py OUT.gltf [X Y Z], where its only root node stands.

A lamp in the ceiling, three point lights of one definition at nodes of their own, one more that is hidden, a row of
crates as instances.
"""
import base64
import json
import struct
import sys

data, views, accessors = b"", [], []


def add(rows, kind):
    global data
    flat = [x for row in rows for x in row]
    packed = struct.pack("<%df" % len(flat), *flat)
    views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(packed)})
    accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(rows), "type": kind})
    data += packed
    return len(accessors) - 1


def box(low, high, inward):
    corners = [[high[a] if k >> a & 1 else low[a] for a in range(3)] for k in range(8)]
    faces = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    turn = (0, 2, 1, 0, 3, 2) if inward else (0, 1, 2, 0, 2, 3)
    return [corners[face[k]] for face in faces for k in turn]


def mesh(triangles, material):
    return {"primitives": [{"attributes": {"POSITION": add(triangles, "VEC3")}, "material": material}]}


def light(index):
    return {"KHR_lights_punctual": {"light": index}}


path, place = sys.argv[1], [float(x) for x in sys.argv[2:5]] or [0, 0, 0]
lamp = [[-0.6, 2.95, -0.6], [0.6, 2.95, -0.6], [0.6, 2.95, 0.6], [-0.6, 2.95, -0.6], [0.6, 2.95, 0.6], [-0.6, 2.95, 0.6]]
meshes = [mesh(box((-2, 0, -2.5), (2, 3, 2.5), True), 0), mesh(box((-0.3, 0, -0.3), (0.3, 0.6, 0.3), False), 0), mesh(lamp, 1)]
crates = {"attributes": {"TRANSLATION": add([[-1.2, 0, 0], [0, 0, 0], [1.2, 0, 0]], "VEC3")}}
nodes = [
    {"name": "site", "translation": place, "children": list(range(1, 10))},
    {"name": "room", "mesh": 0},
    {"name": "crates", "mesh": 1, "translation": [0, 0, -1], "extensions": {"EXT_mesh_gpu_instancing": crates}},
    {"name": "lamp", "mesh": 2},
    {"name": "left", "translation": [-1.5, 2, 0], "extensions": light(0)},
    {"name": "middle", "translation": [0, 2, 0], "extensions": light(0)},
    {"name": "right", "translation": [1.5, 2, 0], "extensions": light(0)},
    {"name": "off", "translation": [0, 1, 1], "extensions": {**light(1), "KHR_node_visibility": {"visible": False}}},
    {"name": "door", "camera": 0, "translation": [0, 1.5, 2.4]},
    {"name": "top", "camera": 0, "translation": [0, 2.8, 0], "rotation": [-0.70710678, 0, 0, 0.70710678]},
]
paint = {"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": [0.7, 0.7, 0.7, 1], "metallicFactor": 0}}
glow = {"name": "glow", "emissiveFactor": [1, 1, 1], "pbrMetallicRoughness": {"metallicFactor": 0}}
document = {
    "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": nodes, "meshes": meshes, "materials": [paint, glow],
    "cameras": [{"name": "lens", "type": "perspective", "perspective": {"yfov": 1.1, "znear": 0.1}}],
    "extensionsUsed": ["KHR_lights_punctual", "EXT_mesh_gpu_instancing", "KHR_node_visibility"],
    "extensions": {"KHR_lights_punctual": {"lights": [
        {"name": "bulb", "type": "point", "intensity": 2}, {"name": "hidden", "type": "point", "intensity": 1000}]}},
    "buffers": [{"uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(), "byteLength": len(data)}],
    "bufferViews": views, "accessors": accessors,
}
with open(path, "w") as file:
    json.dump(document, file)
