"""Lets nodes of a .glb slide: animate.py FROM TO NAME X Y Z moves those with NAME in their names that far in one second,
evenly, as the clip `slide`; a clip `fall` takes them down by as much."""
import json
import struct
import sys

source, target, name = sys.argv[1:4]
way = [float(x) for x in sys.argv[4:7]]
data = open(source, "rb").read()
length = struct.unpack("<I", data[12:16])[0]
scene = json.loads(data[20 : 20 + length])
binary = data[28 + length :]
binary += b"\0" * (-len(binary) % 4)


def add(values, kind):
    global binary
    width = {"SCALAR": 1, "VEC3": 3}[kind]
    packed = struct.pack("<%df" % len(values), *values)
    scene["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(packed)})
    scene["accessors"].append({"bufferView": len(scene["bufferViews"]) - 1, "componentType": 5126,
                               "count": len(values) // width, "type": kind})
    binary += packed
    return len(scene["accessors"]) - 1


nodes = [k for k, n in enumerate(scene["nodes"]) if name in n.get("name", "")]
time = add([0, 1], "SCALAR")
channels = [{"sampler": 0, "target": {"node": node, "path": "translation"}} for node in nodes]
scene["animations"] = [
    {"name": clip, "channels": channels, "samplers": [{"input": time, "output": add([0, 0, 0] + to, "VEC3")}]}
    for clip, to in (("slide", way), ("fall", [0, -abs(way[0]), 0]))]
scene["buffers"][0]["byteLength"] = len(binary)
text = json.dumps(scene).encode()
text += b" " * (-len(text) % 4)
total = 28 + len(text) + len(binary)
open(target, "wb").write(struct.pack("<IIIII", 0x46546C67, 2, total, len(text), 0x4E4F534A) + text +
                         struct.pack("<II", len(binary), 0x004E4942) + binary)
