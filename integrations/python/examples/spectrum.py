"""The spectrum of the light-transport operator: how fast light dies out, and what is left last.

usage: spectrum.py [SCENE] [-k COUNT] [--elements COUNT]
"""
# %% What to do
import argparse

import numpy as np
from scipy.sparse.linalg import eigs, svds

import resolvent

arguments = argparse.ArgumentParser()
arguments.add_argument("scene", nargs="?", default="two-rooms")
arguments.add_argument("-k", type=int, default=8)
arguments.add_argument("--elements", type=int, default=3000, help="wanted number of coarse elements")
arguments = arguments.parse_args()

# %% The operator G K for green, as a sparse matrix and as a linear operator
scene = resolvent.Scene.builtin(arguments.scene)
light = scene.solve("draft", element_target=arguments.elements)
operator = light.operator
matrix = operator.matrix(1)
print(f"{arguments.scene}: {matrix.shape[0]} elements, {matrix.nnz} entries, norm {operator.norm():.4f}")

# %% Its largest eigenvalues: each bounce multiplies what is left of the light by the first
values, vectors = eigs(operator.linear_operator(1), k=arguments.k, which="LM", v0=np.ones(len(operator.areas)))
order = np.argsort(-abs(values))
values, vectors = values[order], vectors[:, order]
for value in values:
    print(f"  {value.real:+.4f} {value.imag:+.4f}i")
radius = abs(values[0])
print(f"spectral radius {radius:.4f}: {np.log(1e-3) / np.log(radius):.0f} bounces to a thousandth")
assert radius <= operator.albedo[:, 1].max() + 1e-6  # no mode decays slower than the brightest surface reflects

# %% The first mode is where light stays longest: all of one sign (Perron and Frobenius)
mode = vectors[:, 0].real
mode /= mode[np.argmax(abs(mode))]
free = operator.areas > 0
print(f"slowest mode: {100 * np.mean(mode[free] > -1e-6):.1f} % of the elements of one sign")
print("brightest at", np.round(operator.positions[free][np.argmax(mode[free])], 2))

# %% Singular values say how many numbers describe all light that is reflected once
singular = np.sort(svds(matrix, k=min(40, min(matrix.shape) - 1), return_singular_vectors=False,
                        random_state=np.random.RandomState(0)))[::-1]
print("singular values:", np.round(singular[:5], 4), "... the 40th", round(singular[-1], 4))

# %% The Neumann series, by hand
total = term = light.source_field.astype(float)
for _ in range(400):
    term = operator.apply(term).astype(float)
    total = total + term
error = abs(total - light.irradiance_field).max() / light.irradiance_field.max()
print(f"sum of 400 bounces against the solution: {error:.1e}")
assert error < 1e-3
