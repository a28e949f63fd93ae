"""Reads an operator file without any of Resolvent, solves E = E0 + G K E again, and compares. Needs numpy and scipy.

usage: solve_operator.py FILE.safetensors        (docs/operator-files.md says what the arrays are)
"""
import json, sys
import numpy as np
from scipy.sparse import csr_matrix, diags

raw = open(sys.argv[1], "rb").read()
start = 8 + int.from_bytes(raw[:8], "little")
header = json.loads(raw[8:start])

def tensor(name):
    entry, kind = header[name], {"U8": "u1", "U16": "<u2", "U32": "<u4", "U64": "<u8", "F32": "<f4"}
    begin, end = entry["data_offsets"]
    return np.frombuffer(raw[start + begin:start + end], kind[entry["dtype"]]).reshape(entry["shape"])

source, albedo, irradiance = tensor("source"), tensor("albedo"), tensor("irradiance")
n = len(source)
rows = lambda name, weight: csr_matrix(
    (weight, tensor(name + "column").astype("i8"), tensor(name + "row_start").astype("i8")), (n, n))
plain = rows("transport.", np.ones(len(tensor("transport.column"))))

hanging = [tensor("element.hanging." + k) for k in ("node", "parent", "weight")]

def fill_in(field):  # hanging elements are means of others, parents first
    for node, parents, weights in zip(*hanging):
        field[node] = weights @ field[parents]
    return field

G = [diags(tensor("transport.scale")) @ (plain + rows("transport.tinted.", tensor("transport.tinted.weight")[:, c]))
     for c in range(3)]  # red, green, blue; subsurface scattering is left out of this sample
E, change = fill_in(source.astype("f8")), 1.0
while change > 1e-9:  # bounce after bounce
    exitance = albedo * E
    before, E = E, fill_in(source + np.stack([G[c] @ exitance[:, c] for c in range(3)], axis=1))
    change = np.max(np.abs(E - before)) / np.max(E)

worst = np.max(np.abs(E - fill_in(irradiance.astype("f8"))) / np.max(irradiance, axis=0))
print(f"{header['__metadata__']['scene']}: {n} elements, {plain.nnz} entries, largest difference {worst:.2g}")
sys.exit(int(worst > 1e-5))
