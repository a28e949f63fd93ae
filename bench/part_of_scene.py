"""Gives connected parts of meshes nodes of their own, in binary glTF. Some files have one mesh for all objects of a
material, such as all seats of all chairs of a room:

    python3 bench/part_of_scene.py japanese_classroom.glb chair.glb chair --low -1.3 -0.05 2.2 --high -0.76 1 2.85

Parts that lie in the box from --low to --high become nodes of the given name. Nodes of meshes must not be placed by
parents or transformations.
"""
import argparse
import struct

from figure_in_room import read, write

TYPES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
PARTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def values(scene, binary, index):
    """Elements of an accessor without a stride, as tuples."""
    accessor = scene["accessors"][index]
    view = scene["bufferViews"][accessor["bufferView"]]
    parts = PARTS[accessor["type"]]
    kind = TYPES[accessor["componentType"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    flat = struct.unpack_from("<%d%s" % (parts * accessor["count"], kind), binary, start)
    return [flat[k:k + parts] for k in range(0, len(flat), parts)]


def connected(position, index):
    """Lists of triangles that share corners, or corners at the same place."""
    number = {}
    corner = [number.setdefault(tuple(round(x, 4) for x in position[i]), len(number)) for i in index]
    parent = list(range(len(number)))

    def root(x):
        while parent[x] != x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        return x

    for k in range(0, len(corner), 3):
        parent[root(corner[k + 1])] = root(corner[k])
        parent[root(corner[k + 2])] = root(corner[k])
    parts = {}
    for k in range(0, len(corner), 3):
        parts.setdefault(root(corner[k]), []).append(k)
    return list(parts.values())


def inside(position, corners, low, high):
    return all(low[k] <= position[i][k] <= high[k] for i in corners for k in range(3))


def corners_of(index, triangles):
    return [index[t + k] for t in triangles for k in range(3)]


def append(scene, binary, data, **accessor):
    """@return the accessor's number and the binary"""
    scene["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
    scene["accessors"].append(dict(accessor, bufferView=len(scene["bufferViews"]) - 1))
    return len(scene["accessors"]) - 1, binary + data + b"\0" * (-len(data) % 4)


def add_primitive(scene, binary, old, corners):
    """A primitive of some of another's corners, with only the vertices that it needs."""
    used = sorted(set(corners))
    number = {vertex: k for k, vertex in enumerate(used)}
    primitive = dict(old, attributes={})
    for name, source in old["attributes"].items():
        all_values = values(scene, binary, source)
        taken = [all_values[vertex] for vertex in used]
        then = scene["accessors"][source]
        data = b"".join(struct.pack("<%d%s" % (len(v), TYPES[then["componentType"]]), *v) for v in taken)
        now = {key: then[key] for key in ("componentType", "type", "normalized") if key in then}
        if "min" in then:
            now.update(min=[min(v) for v in zip(*taken)], max=[max(v) for v in zip(*taken)])
        primitive["attributes"][name], binary = append(scene, binary, data, count=len(taken), **now)
    data = struct.pack("<%dI" % len(corners), *(number[vertex] for vertex in corners))
    primitive["indices"], binary = append(
        scene, binary, data, count=len(corners), componentType=5125, type="SCALAR")
    return primitive, binary


def part_node(scene, binary, node, options):
    """Moves the node's parts in the box to a new node. @return its number, None = there are none; the binary"""
    mesh = scene["meshes"][node["mesh"]]
    kept, moved = [], []
    for primitive in mesh["primitives"]:
        position = values(scene, binary, primitive["attributes"]["POSITION"])
        index = [v[0] for v in values(scene, binary, primitive["indices"])]
        parts = [corners_of(index, triangles) for triangles in connected(position, index)]
        hit = [inside(position, part, options.low, options.high) for part in parts]
        for choice, primitives in ((False, kept), (True, moved)):
            corners = [i for part, h in zip(parts, hit) if h == choice for i in part]
            if not any(hit) or not corners:
                continue
            made, binary = add_primitive(scene, binary, primitive, corners)
            primitives.append(made)
        if not any(hit):
            kept.append(primitive)
    if not moved:
        return None, binary
    if kept:
        scene["meshes"].append({"name": options.name, "primitives": moved})
        scene["nodes"].append({"name": options.name, "mesh": len(scene["meshes"]) - 1})
        mesh["primitives"] = kept
        return len(scene["nodes"]) - 1, binary
    node["name"] = mesh["name"] = options.name
    mesh["primitives"] = moved
    return None, binary


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("output")
    parser.add_argument("name")
    parser.add_argument("--low", type=float, nargs=3, required=True)
    parser.add_argument("--high", type=float, nargs=3, required=True)
    options = parser.parse_args()
    scene, binary = read(options.scene)
    for node in list(scene["nodes"]):
        if "mesh" not in node:
            continue
        made, binary = part_node(scene, binary, node, options)
        if made is not None:
            scene["scenes"][scene.get("scene", 0)]["nodes"].append(made)
    scene["buffers"][0]["byteLength"] = len(binary)
    write(options.output, scene, binary)


if __name__ == "__main__":
    main()
