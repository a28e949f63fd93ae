# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that pass between Blender and the program: GLB, PNG and EXR. Without Blender."""
import json
import math
import struct
import zlib

import numpy as np

GLB_MAGIC, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
COMPONENT_TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
COMPONENT_COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


class GlbWriter:
    """Collects the parts of a glTF document and its one buffer."""

    def __init__(self, generator):
        self.document = {"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}]}
        self.chunks, self.size = [], 0

    def add(self, kind, value):
        """Appends to a top-level array and returns the index."""
        items = self.document.setdefault(kind, [])
        items.append(value)
        return len(items) - 1

    def add_root(self, node):
        """Adds a node to the scene and returns its index."""
        index = self.add("nodes", node)
        self.document["scenes"][0]["nodes"].append(index)
        return index

    def use_extension(self, name):
        used = self.document.setdefault("extensionsUsed", [])
        if name not in used:
            used.append(name)

    def add_view(self, data, target=None):
        """Appends bytes to the buffer and returns the index of their buffer view."""
        view = {"buffer": 0, "byteOffset": self.size, "byteLength": len(data)}
        if target:
            view["target"] = target
        padding = -len(data) % 4
        self.chunks += [data, b"\0" * padding]
        self.size += len(data) + padding
        return self.add("bufferViews", view)

    def add_attribute(self, array, with_bounds=False):
        """Appends a float32 array of shape (count, components) and returns its accessor."""
        array = np.ascontiguousarray(array, np.float32)
        components = 1 if array.ndim == 1 else array.shape[1]
        accessor = {"bufferView": self.add_view(array.tobytes(), ARRAY_BUFFER), "componentType": 5126,
                    "count": len(array), "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[components]}
        if with_bounds:
            accessor["min"], accessor["max"] = array.min(0).tolist(), array.max(0).tolist()
        return self.add("accessors", accessor)

    def add_indices(self, array):
        array = np.ascontiguousarray(array, np.uint32).ravel()
        return self.add("accessors", {"bufferView": self.add_view(array.tobytes(), ELEMENT_ARRAY_BUFFER),
                                      "componentType": 5125, "count": len(array), "type": "SCALAR"})

    def add_image(self, data, mime_type, name):
        return self.add("images", {"bufferView": self.add_view(data), "mimeType": mime_type, "name": name})

    def write(self, path):
        """Raises OSError if the file cannot be written."""
        if self.size:
            self.document["buffers"] = [{"byteLength": self.size}]
        text = json.dumps(self.document, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        binary = 8 + self.size if self.size else 0
        with open(path, "wb") as file:
            file.write(struct.pack("<III", GLB_MAGIC, 2, 12 + 8 + len(text) + binary))
            file.write(struct.pack("<II", len(text), JSON_CHUNK) + text)
            if self.size:
                file.write(struct.pack("<II", self.size, BINARY_CHUNK))
                file.writelines(self.chunks)


class GlbFile:
    """A GLB file that the program wrote."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        magic, _, _ = struct.unpack_from("<III", data)
        if magic != GLB_MAGIC:
            raise ValueError(f"{path}: not a GLB file")
        self.document, self.binary, at = {}, b"", 12
        while at + 8 <= len(data):
            size, kind = struct.unpack_from("<II", data, at)
            if kind == JSON_CHUNK:
                self.document = json.loads(data[at + 8:at + 8 + size])
            elif kind == BINARY_CHUNK:
                self.binary = data[at + 8:at + 8 + size]
            at += 8 + size

    def accessor(self, index):
        """The values of an accessor, (count, components); integers that are normalised become 0..1."""
        accessor = self.document["accessors"][index]
        view = self.document["bufferViews"][accessor["bufferView"]]
        dtype = np.dtype(COMPONENT_TYPES[accessor["componentType"]])
        count, components = accessor["count"], COMPONENT_COUNTS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        row = components * dtype.itemsize
        stride = view.get("byteStride", row)
        raw = np.frombuffer(self.binary, np.uint8, (count - 1) * stride + row if count else 0, start)
        rows = np.lib.stride_tricks.as_strided(raw, (count, row), (stride, 1))
        values = np.ascontiguousarray(rows).view(dtype).reshape(count, components)
        if accessor.get("normalized") and dtype.kind in "iu":
            return values.astype(np.float32) / np.iinfo(dtype).max
        return values


def _png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_bytes(codes):
    """A PNG of (height, width, channels) uint8 or uint16, row 0 on top."""
    height, width, channels = codes.shape
    depth = 8 * codes.dtype.itemsize
    raw = codes.astype(codes.dtype.newbyteorder(">")).reshape(height, -1).view(np.uint8)
    rows = np.concatenate([np.zeros((height, 1), np.uint8), raw], axis=1)
    header = struct.pack(">IIBBBBB", width, height, depth, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + _png_chunk(b"IHDR", header)
            + _png_chunk(b"IDAT", zlib.compress(rows.tobytes(), 4)) + _png_chunk(b"IEND", b""))


def _exr_attribute(name, kind, data):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(data)) + data


def exr_bytes(pixels):
    """An uncompressed EXR of (height, width, 3) float32 linear RGB, row 0 on top."""
    height, width, _ = pixels.shape
    channels = b"".join(c + b"\0" + struct.pack("<IBBBBII", 2, 0, 0, 0, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<II", 20000630, 2) + b"".join([
        _exr_attribute("channels", "chlist", channels), _exr_attribute("compression", "compression", b"\0"),
        _exr_attribute("dataWindow", "box2i", window), _exr_attribute("displayWindow", "box2i", window),
        _exr_attribute("lineOrder", "lineOrder", b"\0"),
        _exr_attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        _exr_attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        _exr_attribute("screenWindowWidth", "float", struct.pack("<f", 1))]) + b"\0"
    size = 12 * width
    first = len(header) + 8 * height
    offsets = first + (8 + size) * np.arange(height, dtype="<u8")
    lines = np.empty(height, np.dtype([("y", "<i4"), ("size", "<i4"), ("data", "<f4", (3, width))]))
    lines["y"], lines["size"] = np.arange(height), size
    lines["data"] = np.moveaxis(pixels[..., ::-1], 2, 1)
    return header + offsets.tobytes() + lines.tobytes()


def to_srgb(linear):
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1 / 2.4) - 0.055)


def to_linear(codes):
    return np.where(codes <= 0.04045, codes / 12.92, np.power((np.maximum(codes, 0) + 0.055) / 1.055, 2.4))


def icosphere(divisions):
    """A unit sphere of triangles: vertices (n, 3) and triangles (m, 3), seen counter-clockwise from outside."""
    golden = (1 + math.sqrt(5)) / 2
    points = [np.array(p, float) / math.hypot(1, golden) for p in (
        (-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden), (0, 1, golden),
        (0, -1, -golden), (0, 1, -golden), (golden, 0, -1), (golden, 0, 1), (-golden, 0, -1), (-golden, 0, 1))]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                 (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
                 (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(divisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                point = points[a] + points[b]
                points.append(point / np.linalg.norm(point))
                middles[key] = len(points) - 1
            return middles[key]

        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return np.array(points), np.array(triangles)


def triangle_areas(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
