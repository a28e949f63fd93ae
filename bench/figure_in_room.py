"""Puts an animated figure into a room, both binary glTF:

    resolvent scene cornell-blocks -o room.glb
    python3 bench/figure_in_room.py room.glb figure.glb walk.glb --scale 5 --at -1.4 0 -1.2

The room is scaled by --scale, and the figure stands at --at (metres). --without NAME leaves out nodes of the room whose
names contain NAME.
"""
import argparse
import json
import struct

LISTS = ("accessors", "animations", "bufferViews", "images", "materials", "meshes", "nodes", "samplers", "skins", "textures")


def read(path):
    data = open(path, "rb").read()
    length = struct.unpack("<I", data[12:16])[0]
    binary = data[28 + length:]
    return json.loads(data[20:20 + length]), binary + b"\0" * (-len(binary) % 4)


def write(path, scene, binary):
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    total = 28 + len(text) + len(binary)
    with open(path, "wb") as file:
        file.write(struct.pack("<IIIII", 0x46546C67, 2, total, len(text), 0x4E4F534A) + text)
        file.write(struct.pack("<II", len(binary), 0x004E4942) + binary)


def shift(item, key, by):
    if key in item:
        item[key] += by


def shift_primitive(primitive, first):
    shift(primitive, "indices", first["accessors"])
    shift(primitive, "material", first["materials"])
    for group in [primitive["attributes"]] + primitive.get("targets", []):
        for name in group:
            group[name] += first["accessors"]


def shift_node(node, first):
    shift(node, "mesh", first["meshes"])
    shift(node, "skin", first["skins"])
    node.pop("camera", None)
    node["children"] = [child + first["nodes"] for child in node.get("children", [])]
    if not node["children"]:
        del node["children"]


def shift_animation(animation, first):
    for channel in animation["channels"]:
        shift(channel["target"], "node", first["nodes"])
    for sampler in animation["samplers"]:
        shift(sampler, "input", first["accessors"])
        shift(sampler, "output", first["accessors"])


def add(room, room_binary, figure, figure_binary):
    """Appends the figure's lists to the room's. Returns its root nodes and the binary."""
    first = {name: len(room.get(name, [])) for name in LISTS}
    for view in figure["bufferViews"]:
        view["byteOffset"] = view.get("byteOffset", 0) + len(room_binary)
    for accessor in figure["accessors"]:
        shift(accessor, "bufferView", first["bufferViews"])
    for mesh in figure["meshes"]:
        for primitive in mesh["primitives"]:
            shift_primitive(primitive, first)
    for node in figure["nodes"]:
        shift_node(node, first)
    for skin in figure.get("skins", []):
        skin["joints"] = [joint + first["nodes"] for joint in skin["joints"]]
        shift(skin, "skeleton", first["nodes"])
        shift(skin, "inverseBindMatrices", first["accessors"])
    for animation in figure["animations"]:
        shift_animation(animation, first)
    for image in figure.get("images", []):
        shift(image, "bufferView", first["bufferViews"])
    for texture in figure.get("textures", []):
        shift(texture, "source", first["images"])
        shift(texture, "sampler", first["samplers"])
    for name in LISTS:
        if figure.get(name):
            room.setdefault(name, []).extend(figure[name])
    room["buffers"][0]["byteLength"] = len(room_binary) + len(figure_binary)
    roots = figure["scenes"][figure.get("scene", 0)]["nodes"]
    return [root + first["nodes"] for root in roots], room_binary + figure_binary


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("room")
    parser.add_argument("figure")
    parser.add_argument("output")
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--at", type=float, nargs=3, default=[0, 0, 0])
    parser.add_argument("--without")
    options = parser.parse_args()
    room, room_binary = read(options.room)
    figure, figure_binary = read(options.figure)
    scene = room["scenes"][room.get("scene", 0)]
    kept = [node for node in scene["nodes"]
            if not options.without or options.without not in room["nodes"][node].get("name", "")]
    roots, binary = add(room, room_binary, figure, figure_binary)
    room["nodes"].append({"name": "room", "children": kept, "scale": [options.scale] * 3})
    room["nodes"].append({"name": "figure", "children": roots, "translation": options.at})
    scene["nodes"] = [len(room["nodes"]) - 2, len(room["nodes"]) - 1]
    write(options.output, room, binary)


if __name__ == "__main__":
    main()
