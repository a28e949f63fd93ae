"""An operator file read with numpy alone, without Resolvent: solved again, relit, and differentiated by its albedo.

usage: operator_file.py FILE.safetensors

`resolvent solve SCENE -o FILE.safetensors`, or Light.save, writes one. With PyTorch installed the same product is taken
there, and its gradient by autograd.
"""
# %% The file: a JSON header, then the arrays
import argparse
import json

import numpy as np

arguments = argparse.ArgumentParser()
arguments.add_argument("file")
arguments = arguments.parse_args()

raw = np.memmap(arguments.file, mode="r")
start = 8 + int.from_bytes(raw[:8].tobytes(), "little")
header = json.loads(raw[8:start].tobytes())
KINDS = {"U8": "u1", "U16": "<u2", "U32": "<u4", "U64": "<u8", "F32": "<f4"}


def tensor(name):
    begin, end = header[name]["data_offsets"]
    return raw[start + begin:start + end].view(KINDS[header[name]["dtype"]]).reshape(header[name]["shape"])


# %% E = E0 + G K E: entries of G as rows, columns and weights for each channel
source, albedo, expected = (tensor(name).astype(float) for name in ("source", "albedo", "irradiance"))
n = len(source)
assert "subsurface.column" not in header, "light that diffuses below surfaces is left out of this example"
starts, tinted = tensor("transport.row_start").astype(int), tensor("transport.tinted.row_start").astype(int)
rows = np.concatenate([np.repeat(np.arange(n), np.diff(starts)), np.repeat(np.arange(n), np.diff(tinted))])
columns = np.concatenate([tensor("transport.column"), tensor("transport.tinted.column")]).astype(int)
weights = np.concatenate([np.ones((starts[-1], 3)), tensor("transport.tinted.weight")])
weights = weights * tensor("transport.scale")[rows, None]
hanging = list(zip(*(tensor("element.hanging." + name) for name in ("node", "parent", "weight"))))


def fill_in(field):  # elements that hang are means of others, parents first
    for node, parents, shares in hanging:
        field[node] = shares @ field[parents]
    return field


def bounce(field):  # G K
    exitance = albedo * field
    return fill_in(np.stack([np.bincount(rows, weights[:, c] * exitance[columns, c], n) for c in range(3)], axis=1))


# %% Solved: bounce after bounce
def solve(right):
    total = term = fill_in(right.copy())
    while abs(term).max() > 1e-9 * abs(total).max():
        term = bounce(term)
        total = total + term
    return total


solution = solve(source)
error = abs(solution - fill_in(expected.copy())).max() / expected.max()
print(f"{header['__metadata__']['scene']}: {n} elements, {len(columns)} entries, difference from the file {error:.1e}")
assert error < 1e-5

# %% Relit: light by light, where the file has several
names = json.loads(header["__metadata__"].get("light.name", "[]"))
parts = {name: tensor(f"light.{k}.source") for k, name in enumerate(names) if f"light.{k}.source" in header}
if "light.scale" in header:  # lights that were scaled are stored as they are by themselves
    parts = {name: part * scale for (name, part), scale in zip(parts.items(), tensor("light.scale"))}
for name, part in parts.items():
    print(f"{name}: {100 * part.sum() / source.sum():.1f} % of the direct light")

# %% The same product in PyTorch, whose autograd differentiates it
try:
    import torch
except ImportError:
    print("PyTorch is not installed: left out")
else:
    places = torch.tensor(np.stack([rows, columns]))
    green = torch.sparse_coo_tensor(places, torch.tensor(weights[:, 1]), (n, n)).coalesce()
    rho = torch.tensor(albedo[:, 1], requires_grad=True)
    once = torch.sparse.mm(green, (rho * torch.tensor(solution[:, 1]))[:, None]).sum()
    once.backward()
    expected_gradient = np.bincount(columns, weights[:, 1], n) * solution[:, 1]
    assert np.allclose(rho.grad.numpy(), expected_gradient)
    print(f"PyTorch: one bounce brings {once.item():.3f}, and its gradient by albedo agrees")
