# SPDX-License-Identifier: GPL-3.0-or-later
"""A lightmap baked by the add-on and by Cycles: bench_bake.py -- FOLDER [TEXELS] [TRIANGLES] [SAMPLES] [QUALITY]...

A furnished room, one mesh, is baked by the add-on; then Cycles bakes the same mesh into the same texels. The truth is the
mean of two of Cycles' bakes with SAMPLES samples each, whose noise is subtracted. The error of a bake with n samples falls as
1 / n, and its time grows linearly with n: both are measured, and give the time in which Cycles' error is as small as ours.
Errors are relative: mean of (truth / E - 1)^2 over texels away from the borders of charts and from what stands on the floor.
"""
import os
import resource
import sys
import time

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import scenes  # noqa: E402

MAP = "Resolvent"
DARK = 0.02  # of the mean: what lies below solid things


# ---- the room: boxes whose faces are grids, a chart each ----------------------------------------------------------


def furniture():
    """(centre, size, turn about z, seen from inside)"""
    yield (0, 0, 1.4), (5, 4, 2.8), 0, True
    yield (-1.2, 0.8, 0.35), (1.6, 0.9, 0.7), 0.3, False
    yield (1.5, 1.2, 0.9), (0.6, 0.9, 1.8), 0, False
    yield (0.6, -1.1, 0.22), (0.45, 0.45, 0.44), 0.7, False
    yield (-1.9, -1.3, 0.5), (0.5, 0.5, 1.0), -0.4, False
    for k in range(5):
        yield (-0.6 + 0.35 * k, 1.85, 1.2 + 0.22 * (k % 2)), (0.2, 0.25, 0.3), 0, False
    yield (1.7, -0.8, 0.3), (0.9, 0.9, 0.6), 0.5, False


def faces():
    """(corner, two edges, whether the normal is turned over) of each rectangle, metres."""
    for centre, size, turn, inward in furniture():
        cos, sin = np.cos(turn), np.sin(turn)
        rotation = np.array([(cos, -sin, 0), (sin, cos, 0), (0, 0, 1)])
        for axis in range(3):
            for side in (-1, 1):
                if side < 0 and axis == 2 and not inward and centre[2] - size[2] / 2 < 0.01:
                    continue  # stands on the floor
                normal, u, v = np.zeros(3), np.zeros(3), np.zeros(3)
                normal[axis] = side * size[axis] / 2
                u[(axis + 1) % 3], v[(axis + 2) % 3] = size[(axis + 1) % 3], size[(axis + 2) % 3]
                corner = np.array(centre) + rotation @ (normal - u / 2 - v / 2)
                yield corner, rotation @ u, rotation @ v, (side < 0) != inward


def grid(rectangle, cell):
    """Vertices and quads of one rectangle in cells of about `cell` metres."""
    corner, u, v, turned = rectangle
    nu, nv = (max(int(round(np.linalg.norm(e) / cell)), 1) for e in (u, v))
    s, t = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, nu + 1), np.linspace(0, 1, nv + 1)))
    first = (np.arange(nv)[:, None] * (nu + 1) + np.arange(nu)).ravel()
    quads = np.stack([first, first + 1, first + nu + 2, first + nu + 1], axis=1)
    return corner + s[:, None] * u + t[:, None] * v, quads[:, ::-1] if turned else quads


def make_room(triangles):
    rectangles = list(faces())
    area = sum(np.linalg.norm(u) * np.linalg.norm(v) for _, u, v, _ in rectangles)
    parts = [grid(r, np.sqrt(2 * area / triangles)) for r in rectangles]
    first = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    vertices = np.concatenate([p[0] for p in parts])
    quads = np.concatenate([p[1] + f for p, f in zip(parts, first)])
    ob = scenes.mesh("room", vertices.tolist(), quads.tolist(), scenes.material("plaster", Color=(0.7, 0.65, 0.6)))
    scenes.lamp("AREA", (0.4, 0, 2.7), energy=60, shape="SQUARE", size=0.8)
    scenes.lamp("AREA", (-2.4, 0, 1.5), (0, 0, 1.2), energy=40, shape="RECTANGLE", size=1.0, size_y=1.2, name="window",
                color=(0.7, 0.85, 1))
    scenes.camera((1.9, -1.7, 1.6), (-1, 1, 0.8), lens=22)
    return ob


# ---- bakes --------------------------------------------------------------------------------------------------------


def processor_seconds():
    """Of this process and of those that it has waited for."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)


def timed(bake, *arguments):
    cpu, wall = processor_seconds(), time.time()
    result = bake(*arguments)
    return result, processor_seconds() - cpu, time.time() - wall


def pixels_of(image, texels):
    values = np.empty(texels * texels * image.channels, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(texels, texels, -1).astype(np.float64)


def cycles_bake(ob, texels, samples, seed):
    """Irradiance / pi by Cycles, and 1 where there is a surface, else 0."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    c = scene.cycles
    c.samples, c.seed, c.use_denoising, c.use_adaptive_sampling = samples, seed, False, False
    c.max_bounces = c.diffuse_bounces = 64
    c.sample_clamp_direct = c.sample_clamp_indirect = 0
    image = bpy.data.images.new("cycles", texels, texels, float_buffer=True, alpha=True)
    tree = ob.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, tree.nodes.active = image, node
    bpy.context.view_layer.objects.active = ob
    ob.select_set(True)
    ob.data.uv_layers.active = ob.data.uv_layers[MAP]
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, margin=0, use_clear=True)
    result = pixels_of(image, texels)
    tree.nodes.remove(node)
    bpy.data.images.remove(image)
    return result


def our_bake(texels, quality):
    """Irradiance / pi by the add-on."""
    done = bpy.ops.resolvent.bake(target="lightmap", quality=quality, map_size=texels, into_materials=False)
    assert done == {"FINISHED"}, done
    image = next(i for i in bpy.data.images if i.name.startswith("Lightmap of "))
    return pixels_of(image, texels)[:, :, :3] / np.pi


def uv_of(ob):
    values = np.empty(2 * len(ob.data.loops), np.float32)
    ob.data.uv_layers[MAP].data.foreach_get("uv", values)
    return values


def widened(mask, texels=1):
    """The mask and all that is next to it."""
    for _ in range(texels):
        padded = np.pad(mask, 1)
        height, width = mask.shape
        mask = np.any([padded[y:y + height, x:x + width] for y in range(3) for x in range(3)], axis=0)
    return mask


def judged(truth):
    """Texels away from borders of charts, and from the dark below things that stand on the floor."""
    inside, light = truth[:, :, 3] > 0, truth[:, :, :3].mean(axis=2)
    dark = inside & (light < DARK * light[inside].mean())
    return inside & ~widened(~inside) & ~widened(dark, 2)


def mean_square(a, b, light, mask):
    """Of the difference of two bakes, relative to the third, which has no noise."""
    difference, by = (p[mask][:, :3].mean(axis=1) for p in (a - b, light))
    return float(((difference / np.maximum(by, DARK * by.mean())) ** 2).mean())


def main(folder, texels=1024, triangles=100000, samples=256, *qualities):
    texels, samples, qualities = int(texels), int(samples), qualities or ("draft", "medium")
    os.makedirs(folder, exist_ok=True)
    scenes.reset()
    ob = make_room(int(triangles))
    ours, uv = {}, None
    for quality in qualities:
        ours[quality] = timed(our_bake, texels, quality)
        uv = uv_of(ob) if uv is None else uv
        assert np.array_equal(uv, uv_of(ob)), "texture coordinates follow from the mesh"
        np.save(os.path.join(folder, f"ours-{quality}.npy"), ours[quality][0].astype(np.float32))
    _, first_cpu, _ = timed(cycles_bake, ob, texels, 1, 7)
    many = [timed(cycles_bake, ob, texels, samples, seed) for seed in (1, 2)]
    truth = (many[0][0] + many[1][0]) / 2
    np.save(os.path.join(folder, "truth.npy"), truth[:, :, :3].astype(np.float32))
    mask = judged(truth)
    print(f"RESULT {len(ob.data.polygons)} triangles, {int(mask.sum())} texels judged of {texels} x {texels}")
    per_sample = ((many[0][1] + many[1][1]) / 2 - first_cpu) / (samples - 1)
    print(f"RESULT Cycles: {first_cpu - per_sample:.1f} s + {per_sample:.3f} s per sample of CPU time", flush=True)
    for quality in qualities:
        light, cpu, wall = ours[quality]
        noise = mean_square(many[0][0][:, :, :3], many[1][0][:, :, :3], light, mask) / 2
        error = mean_square(light, truth[:, :, :3], light, mask) - noise / 2  # less the truth's
        wanted = noise * samples / error
        needed = first_cpu + (wanted - 1) * per_sample
        print(f"RESULT {quality}: {cpu:.1f} s of CPU time ({wall:.1f} s), relative MSE {error:.5f}, mean "
              f"{light[mask].mean() / truth[mask][:, :3].mean():.4f}; Cycles has {noise * samples:.3f} / samples and needs "
              f"{wanted:.0f}, {needed:.0f} s: {needed / cpu:.1f} times as long", flush=True)


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1:])
