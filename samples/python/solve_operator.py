"""Reads an operator file without any of Resolvent, solves E = E0 + G K E again, and compares. Needs numpy and scipy.

usage: solve_operator.py FILE.safetensors [--light NAME=SCALE] [--with RELIT.safetensors] [--spectrum OUT.svg]

--light changes a light first; --with compares with another file, as `resolvent relight` writes it; --spectrum draws
the largest eigenvalues of G K for green. docs/operator-files.md says what the arrays are.
"""
import argparse, json, sys
import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import LinearOperator, eigs

arguments = argparse.ArgumentParser()
arguments.add_argument("file")
arguments.add_argument("--light", metavar="NAME=SCALE")
arguments.add_argument("--with", dest="other", metavar="RELIT.safetensors")
arguments.add_argument("--spectrum", metavar="OUT.svg")
arguments = arguments.parse_args()

class Tensors:
    def __init__(self, path):
        self.raw = open(path, "rb").read()
        self.start = 8 + int.from_bytes(self.raw[:8], "little")
        self.header = json.loads(self.raw[8:self.start])
        self.notes = self.header["__metadata__"]

    def __call__(self, name):
        entry, kind = self.header[name], {"U8": "u1", "U16": "<u2", "U32": "<u4", "U64": "<u8", "F32": "<f4"}
        begin, end = entry["data_offsets"]
        data = self.raw[self.start + begin:self.start + end]
        return np.frombuffer(data, kind[entry["dtype"]]).reshape(entry["shape"])

tensor = Tensors(arguments.file)
source, albedo = tensor("source").astype("f8"), tensor("albedo")
n = len(source)
if arguments.light:
    name, scale = arguments.light.rsplit("=", 1)
    k = json.loads(tensor.notes["light.name"]).index(name)
    parts = [tensor(part) for part in (f"light.{k}.source", f"light.{k}.coarse_caustic") if part in tensor.header]
    own = sum(parts) if parts else source  # the only light is the whole
    now = tensor("light.scale")[k] if "light.scale" in tensor.header else 1  # of a file that was relit
    source = source + (float(scale) - now) * own

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
E, change = fill_in(source.copy()), 1.0
while change > 1e-9:  # bounce after bounce
    exitance = albedo * E
    before, E = E, fill_in(source + np.stack([G[c] @ exitance[:, c] for c in range(3)], axis=1))
    change = np.max(np.abs(E - before)) / np.max(E)

expected = fill_in((Tensors(arguments.other) if arguments.other else tensor)("irradiance").astype("f8"))
worst = np.max(np.abs(E - expected) / np.max(expected, axis=0))
print(f"{tensor.notes['scene']}: {n} elements, {plain.nnz} entries, largest difference {worst:.2g}")

def draw(values, path):  # in the unit disc
    points = "".join(f'<circle cx="{v.real:.4f}" cy="{-v.imag:.4f}" r="0.012"/>' for v in values)
    with open(path, "w") as file:
        file.write('<svg xmlns="http://www.w3.org/2000/svg" width="480" height="480" viewBox="-1.1 -1.1 2.2 2.2">'
                   '<rect x="-1.1" y="-1.1" width="2.2" height="2.2" fill="white"/><g stroke="gray" stroke-width="0.005">'
                   '<circle r="1" fill="none"/><path d="M-1.1 0H1.1M0 -1.1V1.1"/></g>' + points + "</svg>")

if arguments.spectrum:
    bounce = LinearOperator((n, n), matvec=lambda x: fill_in(G[1] @ (albedo[:, 1] * x.ravel())), dtype="f8")
    values = eigs(bounce, k=20, which="LM", v0=np.ones(n), return_eigenvectors=False)
    draw(values, arguments.spectrum)
    print(f"spectral radius of G K: {np.max(np.abs(values)):.4f}, at most the largest albedo, {np.max(albedo[:, 1]):.4f}")
    worst = max(worst, np.max(np.abs(values)) > np.max(albedo[:, 1]))
sys.exit(int(worst > 1e-5))
