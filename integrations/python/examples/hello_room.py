"""A room of arrays: its light solved, read, rendered, certified.

usage: hello_room.py [--quality draft|medium|high] [--picture OUT.png]
"""
# %% What to do
import argparse

import numpy as np

import resolvent
from resolvent import Camera, Material, Mesh

arguments = argparse.ArgumentParser()
arguments.add_argument("--quality", default="draft", choices=["draft", "medium", "high"])
arguments.add_argument("--picture", default="hello_room.png")
arguments = arguments.parse_args()


# %% A box that faces inwards is a room; one that faces outwards stands in it
def box(low, high, inwards=False, **mesh):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    sides = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    triangles = np.concatenate([sides[:, [0, 1, 2]], sides[:, [0, 2, 3]]])
    low, high = np.asarray(low, float), np.asarray(high, float)
    return Mesh(low + corners * (high - low), triangles[:, ::-1] if inwards else triangles, **mesh)


walls = [Material.lambert(0.75, "plaster"), Material.lambert((0.6, 0.2, 0.15), "brick")]
left = np.arange(12) % 6 == 0  # the triangles at x = 0
room = box((0, 0, 0), (4, 2.5, 3), inwards=True, material=walls, triangle_materials=left.astype(int), name="room")
table = box((1.5, 0, 1), (2.5, 0.7, 2), material=Material.lambert((0.4, 0.3, 0.2), "oak"), name="table")
lamp = box((1.7, 2.3, 1.2), (2.3, 2.35, 1.8), material=Material.lambert(0, "lamp", emission=10), name="lamp")
scene = resolvent.Scene.from_meshes([room, table, lamp], cameras=[Camera((3.8, 1.6, 2.8), (1.5, 0.8, 1), 1.2, 4 / 3)])
print(scene)

# %% Solved once
light = scene.solve(arguments.quality)
report = light.report
print(f"{report.elements} elements, spectral radius {report.spectral_radius:.3f}, solved by {report.solver}")

# %% Read: along the table, and on the floor below it
x = np.linspace(1.55, 2.45, 5)
points = np.stack([x, np.full(5, 0.7), np.full(5, 1.5)], axis=1)
above = light.irradiance(points, (0, 1, 0), mode="operator")
lookup = light.irradiance(points, (0, 1, 0))
print("on the table  ", np.round(resolvent.luminance(above), 3), "W/m2")
print("stored there  ", np.round(resolvent.luminance(lookup), 3), "W/m2")
assert np.allclose(above, lookup, rtol=0.1)

# %% Rendered, order by order
picture, layers = light.render(width=160, samples=4, layers=True)
print("picture", picture.shape, "of", ", ".join(layers))
assert np.allclose(picture, sum(layers.values()), atol=1e-4 * picture.max())
resolvent.write_image(arguments.picture, picture)

# %% Certified
certificate = light.certify(samples=512)
low, high = certificate.error_estimate_ci95
print(f"error {100 * certificate.relative_error:.1f} %, {low:.4f} to {high:.4f} W/m2 with 95 % confidence")
