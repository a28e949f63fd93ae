"""Lights fitted to wanted lux: how bright must each lamp be, for these readings on these desks?

usage: fit_lights.py [SCENE] [--lux WANTED] [--elements COUNT]
"""
# %% What to do
import argparse

import numpy as np
from scipy.optimize import nnls

import resolvent

arguments = argparse.ArgumentParser()
arguments.add_argument("scene", nargs="?", default="gallery:1")
arguments.add_argument("--lux", type=float, default=300)
arguments.add_argument("--elements", type=int, default=3000, help="wanted number of coarse elements")
arguments = arguments.parse_args()

# %% Solved once; sensors on the floor, 0.8 m above it
scene = resolvent.Scene.builtin(arguments.scene)
light = scene.solve("draft", element_target=arguments.elements)
low, high = scene.bounds
u, v = (k.ravel() for k in np.meshgrid(np.linspace(0.25, 0.75, 4), np.linspace(0.25, 0.75, 4)))
points = np.stack([low[0] + u * (high[0] - low[0]), np.full(16, low[1] + 0.8), low[2] + v * (high[2] - low[2])], axis=1)
for source in light.sources:
    print(f"{source.name}: strength {np.round(source.strength, 3)}")

# %% What each light does there by itself, reflections included: one column for each
basis = light.basis(points, (0, 1, 0), mode="operator", samples=1024)
columns = resolvent.illuminance(basis.irradiance).T
print("readings now:", np.round(columns.sum(axis=1)), "lx")

# %% Factors of the strengths, none negative, that come closest to what is wanted
factors, misfit = nnls(columns, np.full(16, arguments.lux))
for name, factor in zip(basis.names, factors):
    print(f"{name}: times {factor:.3f}")

# %% Relit by these: no ray is traced for the operator
relit = light.relight(lights=dict(zip(basis.names, factors)))
lux = resolvent.illuminance(relit.irradiance(points, (0, 1, 0), mode="operator", samples=1024))
print(f"wanted {arguments.lux:g} lx: {lux.min():.0f} to {lux.max():.0f}, mean {lux.mean():.0f}")
assert np.allclose(lux, columns @ factors, rtol=0.01)

# %% The same slopes by one adjoint solution, however many lights there are
gradient = light.gradient(points, (0, 1, 0))
slopes = [resolvent.illuminance(gradient.lights[name]) for name in basis.names]
print("mean lx per factor of each light:", np.round(slopes, 1))
