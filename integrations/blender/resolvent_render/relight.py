# SPDX-License-Identifier: GPL-3.0-or-later
"""Solved light under other lamps, with numpy: what rt/resolvent_rt.h does for engines. Without Blender."""
import json
import struct

import numpy as np

TYPES = {"F32": np.float32, "U32": np.uint32, "U64": np.uint64, "U16": np.uint16, "U8": np.uint8}


class Tensors:
    """A safetensors file, mapped into memory."""

    def __init__(self, path):
        with open(path, "rb") as file:
            size = struct.unpack("<Q", file.read(8))[0]
            self.header = json.loads(file.read(size))
        self.data = np.memmap(path, np.uint8, "r", 8 + size)
        self.metadata = self.header.pop("__metadata__", {})

    def __getitem__(self, name):
        entry = self.header[name]
        start, end = entry["data_offsets"]
        return np.frombuffer(self.data[start:end], TYPES[entry["dtype"]]).reshape(entry["shape"])

    def __contains__(self, name):
        return name in self.header


class Basis:
    """What each lamp does by itself: names, and values (lamps, receivers, 3), W/m2."""

    def __init__(self, path):
        tensors = Tensors(path)
        self.names = json.loads(tensors.metadata["light.name"])
        self.values = np.array(tensors["basis.value"])

    def light(self, scales):
        """(receivers, 3): the sum of all lamps, each times its scale (3,) in {name: scale}; 1 where there is none."""
        result = np.zeros(self.values.shape[1:], np.float32)
        for name, value in zip(self.names, self.values):
            scale = np.asarray(scales.get(name, 1), np.float32)
            if scale.any():
                result += value * scale
        return result


class Operator:
    """E = E0 + G K E on elements, and how receivers lie between them."""

    def __init__(self, path):
        t = Tensors(path)
        self.positions, self.normals = np.array(t["element.position"]), np.array(t["element.normal"])
        self.albedo = np.array(t["albedo"])
        starts = np.array(t["transport.row_start"]).astype(np.int64)
        self.scale, self.column = np.array(t["transport.scale"]), np.array(t["transport.column"])
        self.rows = np.flatnonzero(np.diff(starts))
        self.starts = starts[self.rows]
        self.weights = self.scale[self.rows, None]
        self.hanging = [np.array(t[f"element.hanging.{k}"]) for k in ("node", "parent", "weight")]
        self.receiver, self.receiver_weight = np.array(t["receiver.element"]), np.array(t["receiver.weight"])
        self.tinted = None
        if len(t["transport.tinted.column"]):
            rows = np.diff(np.array(t["transport.tinted.row_start"]).astype(np.int64))
            self.tinted = (np.repeat(np.arange(len(rows)), rows), np.array(t["transport.tinted.column"]),
                           np.array(t["transport.tinted.weight"]))

    def _settle(self, field):
        """Hanging elements are means of others; a parent comes before its children."""
        node, parent, weight = self.hanging
        for _ in range(2):
            field[node] = (field[parent] * weight[..., None]).sum(axis=1)

    def bounce(self, irradiance):
        """G K irradiance, (elements, 3)."""
        exitance = self.albedo * irradiance
        result = np.zeros_like(irradiance)
        if len(self.rows):
            for c in range(3):
                gathered = np.ascontiguousarray(exitance[:, c])[self.column]
                result[self.rows, c] = np.add.reduceat(gathered, self.starts) * self.weights[:, 0]
        if self.tinted is not None:
            row, column, weight = self.tinted
            np.add.at(result, row, exitance[column] * weight * self.scale[row, None])
        self._settle(result)
        return result

    def solve(self, direct, start=None, sweeps=8):
        """(elements, 3): Neumann's series from `start`, so that light follows over some frames."""
        irradiance = np.array(direct if start is None else start, np.float32)
        for _ in range(sweeps):
            irradiance = direct + self.bounce(irradiance)
        return irradiance

    def receive(self, field):
        """(receivers, 3): a field of the elements at vertices."""
        return (field[self.receiver] * self.receiver_weight[..., None]).sum(axis=1)


def direct_light(lamp, positions, normals, is_hidden):
    """(n, 3): what a lamp sends to points without bounces, W/m2.

    @param lamp kind, position, direction (unit, the way the light travels), intensity (W/sr; W/m2 of suns), cones
    (cosines inner, outer), exponent; of areas: `corners` for samples, and the intensity along the axis
    @param is_hidden (point, towards, distance) -> bool for one point
    """
    result = np.zeros((len(positions), 3), np.float32)
    samples = lamp.get("samples", [lamp["position"]])
    for place in samples:
        towards, distance = -np.broadcast_to(lamp["direction"], positions.shape), np.full(len(positions), np.inf)
        if lamp["kind"] != "directional":
            towards = place - positions
            distance = np.linalg.norm(towards, axis=1)
            towards = towards / np.maximum(distance, 1e-9)[:, None]
        strength = np.maximum((towards * normals).sum(axis=1), 0)
        axis = -(towards @ lamp["direction"])
        if lamp["kind"] == "spot":
            inner, outer = lamp["cones"]
            ramp = np.clip((axis - outer) / max(inner - outer, 1e-6), 0, 1)
            strength = strength * ramp * ramp * (3 - 2 * ramp) * np.maximum(axis, 0) ** lamp["exponent"]
        elif lamp["kind"] == "area":
            strength = strength * np.maximum(axis, 0)
        if lamp["kind"] != "directional":
            strength = strength / np.maximum(distance, 1e-3) ** 2
        for k in np.flatnonzero(strength > 0):
            if is_hidden(positions[k], towards[k], distance[k]):
                strength[k] = 0
        result += strength[:, None].astype(np.float32) * np.asarray(lamp["intensity"], np.float32) / len(samples)
    return result
