"""Compares two operator files: says whether the operators are the same, and how far the irradiances differ."""
import array
import json
import struct
import sys


def tensors(path):
    data = open(path, "rb").read()
    length = struct.unpack("<Q", data[:8])[0]
    header = json.loads(data[8 : 8 + length])
    header.pop("__metadata__")
    start = 8 + length
    return {n: data[start + t["data_offsets"][0] : start + t["data_offsets"][1]] for n, t in header.items()}


one, other = tensors(sys.argv[1]), tensors(sys.argv[2])
solution = ("irradiance", "shown.", "diffused.")
same = one.keys() == other.keys() and all(one[n] == other[n] for n in one if not n.startswith(solution))
a, b = array.array("f", one["irradiance"]), array.array("f", other["irradiance"])
difference = max(abs(x - y) for x, y in zip(a, b)) / max(a)
print("operator", "same" if same else "different", "irradiance %.2e" % difference)
sys.exit(not (same and difference <= 1e-6))
