"""Light.irradiance beside the C function alone, for the same points: CPU seconds of each, in turns.

usage: measure_irradiance.py [POINTS] [MOST]     fails where Python takes more than MOST times as long
"""
import sys
import time

import numpy as np

import resolvent
from resolvent._native import ffi, lib

count = int(float(sys.argv[1])) if len(sys.argv) > 1 else 1000000
most = float(sys.argv[2]) if len(sys.argv) > 2 else 1.2
light = resolvent.Scene.builtin("cornell-blocks").solve("draft", element_target=1000, rays_per_element=64)
low, high = light.scene.bounds
points = np.random.RandomState(0).uniform(low, high, (count, 3))  # float64, as NumPy makes them
points[:, 1] = low[1]
normals = np.tile((0.0, 1.0, 0.0), (count, 1))

# the C program: a context without callbacks, arrays as C has them
context, scene, solution = ffi.new("rsv_context **"), ffi.new("rsv_scene **"), ffi.new("rsv_light **")
assert lib.rsv_context_create(ffi.NULL, context) == 0
assert lib.rsv_scene_builtin(context[0], b"cornell-blocks", scene) == 0
desc = ffi.new("rsv_solve_desc *", lib.rsv_default_solve_desc(lib.RSV_QUALITY_DRAFT))
desc.element_target, desc.rays_per_element = 1000, 64
assert lib.rsv_light_create(scene[0], desc, solution) == 0
probes = np.concatenate([points, normals], axis=1).astype(np.float32)
readings = np.empty_like(probes)
lookup = ffi.new("rsv_probe_desc *", {"size": ffi.sizeof("rsv_probe_desc"), "mode": lib.RSV_PROBE_LOOKUP, "samples": 1})
given, out = ffi.cast("rsv_probe *", probes.ctypes.data), ffi.cast("rsv_probe_reading *", readings.ctypes.data)


def in_c():
    assert lib.rsv_probe_irradiance(solution[0], lookup, given, count, out) == 0
    return readings[:, :3]


def in_python():
    return light.irradiance(points, normals)


def seconds(work):
    began = time.process_time()
    work()
    return time.process_time() - began


np.testing.assert_array_equal(in_python(), in_c())
pairs = [(seconds(in_python), seconds(in_c)) for _ in range(3)]
ours, theirs = min(p for p, _ in pairs), min(c for _, c in pairs)
print(f"{count} points: {ours:.2f} s of CPU, in C {theirs:.2f} s: {ours / theirs:.2f} times")
sys.exit(ours > most * theirs)
