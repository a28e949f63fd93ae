# SPDX-License-Identifier: GPL-3.0-or-later
"""The world and large suns as a latitude-longitude picture for --env."""
import math
import os
import subprocess

import bpy
import numpy as np

from .formats import exr_bytes
from .textures import Graph, Images

BAKED_SIZE = (1024, 512)  # of worlds whose nodes Cycles evaluates
SUN_PIXELS = 12  # across a sun
MOST_WIDTH = 4096
BAKE_SECONDS = 120
BAKE_SCRIPT = os.path.join(os.path.dirname(__file__), "bake_world.py")


def directions(width, height):
    """(height, width, 3): unit directions of pixel centres, y up."""
    longitude = ((np.arange(width) + 0.5) / width - 0.5) * 2 * math.pi
    colatitude = (np.arange(height) + 0.5) / height * math.pi
    sin = np.sin(colatitude)[:, None]
    return np.dstack([sin * np.cos(longitude), np.repeat(np.cos(colatitude)[:, None], width, 1),
                      sin * np.sin(longitude)])


def to_blender(d):
    """Directions of the program (y up) in Blender's world (z up)."""
    return np.stack([d[..., 0], -d[..., 2], d[..., 1]], axis=-1)


def sample_equirect(pixels, d):
    """An environment texture of Blender in directions (z up), interpolated."""
    height, width = pixels.shape[:2]
    u = (0.5 - np.arctan2(d[..., 1], d[..., 0]) / (2 * math.pi)) * width - 0.5
    v = np.arccos(np.clip(d[..., 2], -1, 1)) / math.pi * height - 0.5
    x, y = np.floor(u).astype(int), np.floor(v).astype(int)
    fx, fy = (u - x)[..., None], (v - y)[..., None]
    rows = np.clip(np.stack([y, y + 1]), 0, height - 1)
    columns = np.stack([x, x + 1]) % width
    p = pixels[..., :3]
    top = p[rows[0], columns[0]] * (1 - fx) + p[rows[0], columns[1]] * fx
    low = p[rows[1], columns[0]] * (1 - fx) + p[rows[1], columns[1]] * fx
    return (top * (1 - fy) + low * fy).astype(np.float32)


def euler_matrix(x, y, z):
    """Blender's XYZ order: z * y * x."""
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(a), math.sin(a)) for a in (x, y, z))
    return np.array([[cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
                     [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx], [-sy, cy * sx, cy * cx]])


class World:
    """A world's radiance: constant, by an image, or by Cycles."""

    def __init__(self, world, folder, report):
        self.world, self.folder, self.report = world, folder, report
        self.constant, self.image, self.turn = np.zeros(3), None, np.eye(3)
        if world is None:
            return
        if not (world.use_nodes and world.node_tree):
            self.constant = np.array(world.color[:3], float)
        elif not self._read_nodes(world.node_tree):
            self._bake()

    def _read_nodes(self, tree):
        graph = Graph("the world", self.report)
        output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
        if output is None or not output.inputs["Surface"].is_linked:
            return True
        if output.inputs["Volume"].is_linked:
            graph.note(output, "has a volume, which is left out; the program's --fog is in mode reference alone")
        source = graph.source(output.inputs["Surface"])
        if source is None or source.node.type != "BACKGROUND" or source.node.inputs["Strength"].is_linked:
            return source is None
        strength, colour = source.node.inputs["Strength"].default_value, source.node.inputs["Color"]
        texture = graph.source(colour)
        if texture is None:
            self.constant = strength * np.array(colour.default_value[:3])
            return True
        return texture.node.type == "TEX_ENVIRONMENT" and self._read_texture(graph, texture.node, strength)

    def _read_texture(self, graph, node, strength):
        if node.image is None or node.projection != "EQUIRECTANGULAR" or not self._read_mapping(graph, node):
            return False
        pixels = Images(None, self.report).linear(node.image)
        if pixels is None:
            self.constant = strength * np.array([1.0, 0, 1])
        else:
            self.image, self.constant = pixels[..., :3] * np.float32(strength), None
        return True

    def _read_mapping(self, graph, node):
        source = graph.source(node.inputs["Vector"])
        if source is None:
            return True
        if source.node.type == "MAPPING":
            mapping = source.node
            sockets = [mapping.inputs.get(k) for k in ("Location", "Rotation", "Scale")]
            moved = any(s is None or s.is_linked for s in sockets) or any(sockets[0].default_value) \
                or any(abs(x - 1) > 1e-6 for x in sockets[2].default_value)
            if mapping.vector_type != "POINT" or moved:
                return False
            self.turn = euler_matrix(*sockets[1].default_value)
            source = graph.source(mapping.inputs["Vector"])
        return source is None or (source.node.type == "TEX_COORD" and source.name == "Generated") \
            or (source.node.type == "NEW_GEOMETRY" and source.name == "Position")

    def _bake(self):
        """Has another Blender evaluate the nodes."""
        library, picture = (os.path.join(self.folder, n) for n in ("world.blend", "world.exr"))
        bpy.data.libraries.write(library, {self.world}, path_remap="ABSOLUTE")
        command = [bpy.app.binary_path, "-b", "--factory-startup", library, "-P", BAKE_SCRIPT, "--", picture,
                   *map(str, BAKED_SIZE)]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=BAKE_SECONDS)
        raw = picture + ".npy"
        if not os.path.exists(raw):
            self.report.note("the world's nodes cannot be evaluated; it is shown black")
            print(done.stdout.decode(errors="replace"))
            return
        self.image, self.constant = np.load(raw), None
        self.report.note(f"the world's nodes are evaluated at {BAKED_SIZE[0]} x {BAKED_SIZE[1]} pixels")

    @property
    def is_black(self):
        return self.image is None and not self.constant.any()

    def picture(self, suns):
        """(height, width, 3), or None if the world is black and there are no suns in it."""
        if self.is_black and not suns:
            return None
        finest = min((angle for _, _, angle in suns), default=0)
        width = min(int(SUN_PIXELS * 2 * math.pi / finest), MOST_WIDTH) if suns else 2
        if self.image is not None:
            width = max(width, self.image.shape[1])
            if not suns and np.allclose(self.turn, np.eye(3)):
                return self.image
        size = (max(width, 2), max(width // 2, 1))
        d = directions(*size)
        if self.image is not None:
            result = sample_equirect(self.image, to_blender(d) @ self.turn.T)
        else:
            result = np.broadcast_to(self.constant.astype(np.float32), d.shape).copy()
        for direction, irradiance, angle in suns:
            add_sun(result, d, direction, irradiance, angle)
        return result


def add_sun(picture, d, direction, irradiance, angle):
    """A disc whose light arrives as Cycles' does: irradiance * mean cosine over a flat disc at distance 1."""
    half = min(angle, 3.1) / 2
    cosine = np.clip(d @ direction, -1, 1)
    pixel = math.pi / picture.shape[0]
    inside = np.clip((half - np.arccos(cosine)) / pixel + 0.5, 0, 1)  # its edge is as wide as a pixel
    disc = math.tan(half)
    wanted = 2 * (math.sqrt(1 + disc * disc) - 1) / (disc * disc) if disc < 1e3 else 0
    solid = pixel * pixel * np.sqrt(np.maximum(1 - d[..., 1] ** 2, 0))
    shape = inside / np.maximum(cosine, 0.02) ** 3
    received = float((shape * np.maximum(cosine, 0) * solid).sum())
    if received > 0:
        picture += (shape[..., None] * (np.asarray(irradiance) * wanted / received)).astype(np.float32)


def write_environment(world, suns, folder, report):
    """The path of a picture for --env, or None for black surroundings."""
    picture = World(world, folder, report).picture(suns)
    if picture is None:
        return None
    path = os.path.join(folder, "world-radiance.exr")
    with open(path, "wb") as file:
        file.write(exr_bytes(np.ascontiguousarray(picture, np.float32)))
    return path
