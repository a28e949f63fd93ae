"""Other boxes for tests. usage: change_box.py colored|framed|marble BOX.glb CHANGED.glb (BOX.glb by `resolvent scene cornell-blocks`)

colored: vertices have colours, the back wall's alpha cuts its top off, and a metal behind the camera has colours too
framed: without a camera, and tipped so that one who frames it looks straight in
marble: what was of the first material is translucent
"""
import json, struct, sys


def read_floats(g, binary, index, width):
    a = g["accessors"][index]
    at = g["bufferViews"][a["bufferView"]].get("byteOffset", 0) + a.get("byteOffset", 0)
    return [struct.unpack_from(f"<{width}f", binary, at + 4 * width * k) for k in range(a["count"])]


def add(g, binary, data, **accessor):
    g["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
    binary += data + bytes(-len(data) % 4)
    g["accessors"].append({"bufferView": len(g["bufferViews"]) - 1, **accessor})
    return len(g["accessors"]) - 1


def color(place, low, high):
    """What a vertex gets, 0..1: linear in its place, so that what lies between is known."""
    x, y, z = ((p - a) / max(b - a, 1e-3) for p, a, b in zip(place, low, high))
    return 0.2 + 0.8 * x, 1 - 0.8 * y, 0.3 + 0.6 * z, 1 - 0.8 * y


def color_all(g, binary):
    for mesh in g["meshes"]:
        attributes = mesh["primitives"][0]["attributes"]
        a = g["accessors"][attributes["POSITION"]]
        places = read_floats(g, binary, attributes["POSITION"], 3)
        codes = bytes(round(255 * c) for place in places for c in color(place, a["min"], a["max"]))
        attributes["COLOR_0"] = add(g, binary, codes, componentType=5121, normalized=True, count=a["count"], type="VEC4")


def add_metal(g, binary):
    places = [(-0.3, 0.2, 1.5), (-0.25, 0.3, 1.5), (-0.2, 0.2, 1.5)]
    place = add(g, binary, struct.pack("<9f", *sum(places, ())), componentType=5126, count=3, type="VEC3",
                min=[-0.3, 0.2, 1.5], max=[-0.2, 0.3, 1.5])
    index = add(g, binary, struct.pack("<3I", 0, 1, 2), componentType=5125, count=3, type="SCALAR")
    g["materials"].append({"name": "metal", "pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}})
    g["meshes"].append({"name": "metal", "primitives": [
        {"attributes": {"POSITION": place}, "indices": index, "material": len(g["materials"]) - 1}]})
    g["nodes"].append({"name": "metal", "mesh": len(g["meshes"]) - 1})
    g["scenes"][0]["nodes"].append(len(g["nodes"]) - 1)


def color_vertices(g, binary):
    g["materials"].append({**g["materials"][0], "name": "cut", "alphaMode": "MASK"})
    next(mesh for mesh in g["meshes"] if mesh["name"] == "back wall")["primitives"][0]["material"] = len(g["materials"]) - 1
    add_metal(g, binary)
    color_all(g, binary)


def leave_framing(g, _):
    del g["cameras"]
    for node in g["nodes"]:
        node.pop("camera", None)
    g["nodes"].append({"rotation": [-0.16754, 0, 0, 0.98586], "children": g["scenes"][0]["nodes"]})
    g["scenes"][0]["nodes"] = [len(g["nodes"]) - 1]


def make_translucent(g, _):
    g["materials"][0]["extras"] = {"resolvent": {"scatter_distance": [0.0084, 0.0054, 0.0037]}}


def main(kind, source, target):
    raw = open(source, "rb").read()
    length = struct.unpack("<I", raw[12:16])[0]
    g, binary = json.loads(raw[20:20 + length]), bytearray(raw[28 + length:])
    {"colored": color_vertices, "framed": leave_framing, "marble": make_translucent}[kind](g, binary)
    g["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(g).encode()
    text += b" " * (-len(text) % 4)
    with open(target, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


if __name__ == "__main__":
    main(*sys.argv[1:])
