"""Scenes that the tests share, and how they are solved: small."""
from __future__ import annotations

import functools

import numpy as np

import resolvent
from resolvent import Camera, Material, Mesh, PunctualLight, Scene

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
SIDES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
INWARDS = np.concatenate([SIDES[:, [0, 1, 2]], SIDES[:, [0, 2, 3]]])[:, ::-1]
SMALL = {"element_target": 300, "rays_per_element": 64, "photon_count": 2000, "direct_levels": 1}


def furnace(albedo: float = 0.5) -> Scene:
    """A closed room whose walls emit 1 W/m2 and reflect `albedo`: its irradiance is 1 / (1 - albedo) everywhere."""
    wall = Material.lambert(albedo, "wall", emission=1 / np.pi)
    return Scene.from_meshes(Mesh(CUBE, INWARDS, material=wall))


def lamps() -> Scene:
    """A cube with two point lights, a red wall at x = 0 and grey ones."""
    walls = [Material.lambert(0.6, "grey"), Material.lambert((0.5, 0.2, 0.1), "red")]
    room = Mesh(CUBE, INWARDS, material=walls, triangle_materials=(np.arange(12) % 6 == 0).astype(int))
    lights = [PunctualLight("point", (1, 1, 1), (0.5, 0.8, 0.5), name="white"),
              PunctualLight("point", (0.1, 0.2, 1), (0.2, 0.4, 0.3), name="blue")]
    camera = Camera((0.9, 0.5, 0.9), (0.2, 0.4, 0.2), 1.2, name="corner")
    return Scene.from_meshes(room, lights=lights, cameras=[camera])


@functools.lru_cache(None)
def solved_lamps() -> resolvent.Light:
    return lamps().solve("draft", **SMALL)


def floor_points(count: int, seed: int = 0) -> np.ndarray:
    """(count, 3) on the floor of the cubes."""
    points = np.random.RandomState(seed).uniform(0.05, 0.95, (count, 3))
    points[:, 1] = 0
    return points


UP = (0, 1, 0)
