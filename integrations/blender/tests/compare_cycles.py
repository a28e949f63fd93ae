# SPDX-License-Identifier: GPL-3.0-or-later
"""Mode reference beside Cycles: blender -b --factory-startup -P compare_cycles.py -- FOLDER SAMPLES [SCENE]...

Prints a table: ratio of the means, relative MSE of 16 x 16 blocks, and an estimate of what of it is noise, from two
halves. Exit status 1 if a scene is beyond the limits of EXPECTED.
"""
import os
import sys

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import scenes  # noqa: E402

BLOCK = 16
MEAN, BLOCKS = 0.01, 0.001  # what is asked of all scenes
# where the two programs differ by design; docs/blender.md explains each
EXPECTED = {}


def read(path):
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[::-1, :, :3].astype(np.float64)


def cycles(scene, path, samples, seed):
    scene.render.engine = "CYCLES"
    c = scene.cycles
    c.samples, c.seed, c.use_denoising, c.use_adaptive_sampling = samples, seed, False, False
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = c.transparent_max_bounces = 64
    c.sample_clamp_direct = c.sample_clamp_indirect = 0
    c.blur_glossy, c.light_sampling_threshold = 0, 0
    c.caustics_reflective = c.caustics_refractive = True
    c.pixel_filter_type = "BOX"
    scene.render.filter_size = 1
    scene.cycles.filter_width = 1
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return read(path)


def ours(scene, path, samples, seed):
    scene.resolvent.seed = seed
    done = bpy.ops.resolvent.render(mode="reference", samples=samples, filepath=path)
    assert done == {"FINISHED"}, done
    return read(path)


def blocks(picture):
    height, width = (n // BLOCK * BLOCK for n in picture.shape[:2])
    p = picture[:height, :width].mean(axis=2)
    return p.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK).mean(axis=(1, 3))


def measure(a, b):
    """(ratio of means, relative MSE of blocks without noise, its noise), of two halves each."""
    x, y = ([blocks(p) for p in halves] for halves in (a, b))
    mx, my = np.mean(x, axis=0), np.mean(y, axis=0)
    square = np.maximum(mx, 0.02 * mx.mean()) ** 2
    noise = float((((x[0] - x[1]) ** 2 + (y[0] - y[1]) ** 2) / 4 / square).mean())
    error = float(((mx - my) ** 2 / square).mean())
    return my.mean() / mx.mean(), error - noise, noise


def main(folder, samples, *names):
    os.makedirs(folder, exist_ok=True)
    half, failed = max(int(samples) // 2, 1), []
    for name in names or scenes.ALL:
        scene = scenes.reset()
        scenes.ALL[name]()
        path = os.path.join(folder, name)
        a = [cycles(scene, f"{path}-cycles-{k}.exr", half, k) for k in range(2)]
        b = [ours(scene, f"{path}-ours-{k}.exr", half, k) for k in range(2)]
        mean, error, noise = measure(a, b)
        most_mean, most_error = EXPECTED.get(name, (MEAN, BLOCKS))
        good = abs(mean - 1) <= most_mean and error <= most_error
        failed += [] if good else [name]
        print(f"RESULT {name:12} mean {mean:.4f}  blocks {error:.5f}  noise {noise:.5f}  {'' if good else 'FAILED'}", flush=True)
        for line in scene.resolvent.report.splitlines():
            print(f"    {line}")
    print("failed: " + ", ".join(failed) if failed else f"all of {len(names or scenes.ALL)} agree")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1:])
