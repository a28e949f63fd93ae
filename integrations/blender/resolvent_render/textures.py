# SPDX-License-Identifier: GPL-3.0-or-later
"""What node sockets say: constants, and image textures times constants."""
import math
import os

import numpy as np

from .formats import png_bytes, to_linear, to_srgb

MOST_STEPS = 64  # nodes followed from a socket
LARGEST_SIDE = 16384


class Texture:
    """An image texture as a material uses it."""

    premultiplied = False  # by its alpha: what Cycles does where a node's Alpha output is not linked

    def __init__(self, image, uv_name=None, transform=None, wrap="REPEAT", nearest=False, channel=None):
        self.image, self.uv_name, self.transform = image, uv_name, transform
        self.wrap, self.nearest = wrap, nearest
        self.channel = channel  # None = colour; "r", "g", "b", "a", "mean"


class Value:
    """factor * texture, linear; without a texture the factor alone."""

    def __init__(self, factor, texture=None):
        self.factor, self.texture = np.array(factor, float), texture

    @property
    def number(self):
        return float(self.factor.mean())


class Graph:
    """Follows the sockets of one material and notes what it cannot follow."""

    def __init__(self, owner, report):
        self.owner, self.report = owner, report

    def note(self, node, what):
        self.report.note(f"{self.owner}: node '{node.name}' ({node.bl_label}) {what}")

    def source(self, socket):
        """The socket that feeds this one, past reroutes and into groups, or None."""
        for _ in range(MOST_STEPS):
            if not socket.is_linked:
                return None
            link = next((l for l in socket.links if not l.is_muted), None)
            if link is None:
                return None
            node = link.from_node
            if node.type == "REROUTE":
                socket = node.inputs[0]
            elif node.mute:
                inner = next((l.from_socket for l in node.internal_links if l.to_socket == link.from_socket), None)
                if inner is None:
                    return None
                socket = inner
            else:
                return link.from_socket
        return None

    def default(self, socket):
        value = getattr(socket, "default_value", 0.0)
        return np.array(value[:3], float) if hasattr(value, "__len__") else np.array([value] * 3, float)

    def value(self, socket, depth=0):
        """A socket as a Value; the socket's own value where its nodes cannot be followed."""
        source = self.source(socket)
        if source is None:
            return Value(self.default(socket))
        followed = self._output(source, depth) if depth < MOST_STEPS else None
        if followed is None:
            self.note(source.node, "has no counterpart; the value of the socket "
                                   f"'{socket.name}' that it is linked to is used instead")
            return Value(self.default(socket))
        return followed

    def _output(self, output, depth):
        follow = {"RGB": self._own, "VALUE": self._own, "TEX_IMAGE": self._image, "MIX_RGB": self._mix_rgb,
                  "MIX": self._mix, "MATH": self._math, "SEPARATE_COLOR": self._separate, "SEPRGB": self._separate,
                  "GROUP": self._group, "GROUP_INPUT": self._group_input, "BLACKBODY": self._blackbody,
                  "VERTEX_COLOR": self._vertex_colour, "ATTRIBUTE": self._vertex_colour}.get(output.node.type)
        return follow(output, depth + 1) if follow else None

    def _own(self, output, _):
        return Value(self.default(output))

    def _blackbody(self, output, _):
        from .lamps import _blackbody
        socket = output.node.inputs[0]
        return None if socket.is_linked else Value(_blackbody(socket.default_value))

    def _vertex_colour(self, output, _):
        name = getattr(output.node, "layer_name", None) or getattr(output.node, "attribute_name", "")
        if output.node.type == "ATTRIBUTE" and output.node.attribute_type != "GEOMETRY":
            return None
        return Value((1, 1, 1), Texture(None, uv_name=name, channel="vertex"))

    def _group(self, output, depth):
        tree = output.node.node_tree
        end = tree and next((n for n in tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
        inner = end and end.inputs.get(output.name)
        if not inner:
            return None
        outer, self.group = getattr(self, "group", None), output.node
        try:
            return self.value(inner, depth)
        finally:
            self.group = outer

    def _group_input(self, output, depth):
        group = getattr(self, "group", None)
        socket = group and group.inputs.get(output.name)
        if socket is None:
            return None
        self.group = None
        try:
            return self.value(socket, depth)
        finally:
            self.group = group

    def _separate(self, output, depth):
        node = output.node
        if getattr(node, "mode", "RGB") != "RGB":
            return None
        value = self.value(node.inputs[0], depth)
        k = next(i for i, o in enumerate(node.outputs) if o == output)
        if value.texture is None:
            return Value([value.factor[k]] * 3)
        t = value.texture
        return Value([value.factor[k]] * 3, Texture(t.image, t.uv_name, t.transform, t.wrap, t.nearest, "rgb"[k]))

    def _product(self, a, b):
        if a.texture and b.texture:
            return None
        return Value(a.factor * b.factor, a.texture or b.texture)

    def _blend(self, kind, share, a, b):
        if share.texture:
            return None
        f = min(max(share.number, 0), 1)
        if f == 0:
            return a
        if kind == "MIX" and f == 1:
            return b
        if not a.texture and not b.texture:
            x, y = a.factor, b.factor
            mixed = {"MIX": y, "MULTIPLY": x * y, "ADD": x + y, "SUBTRACT": x - y, "DARKEN": np.minimum(x, y),
                     "LIGHTEN": np.maximum(x, y), "SCREEN": 1 - (1 - x) * (1 - y)}.get(kind)
            return None if mixed is None else Value((1 - f) * x + f * mixed)
        if kind != "MULTIPLY":
            return None
        if not b.texture:
            return Value(a.factor * (1 - f + f * b.factor), a.texture)
        return self._product(a, b) if f == 1 else None

    def _mix_rgb(self, output, depth):
        node = output.node
        a, b, share = (self.value(node.inputs[k], depth) for k in ("Color1", "Color2", "Fac"))
        return self._blend(node.blend_type, share, a, b)

    def _mix(self, output, depth):
        node = output.node
        live = [s for s in node.inputs if s.enabled]
        if node.data_type not in {"RGBA", "FLOAT"} or len(live) != 3:
            return None
        share, a, b = (self.value(s, depth) for s in live)
        return self._blend(node.blend_type if node.data_type == "RGBA" else "MIX", share, a, b)

    def _math(self, output, depth):
        node = output.node
        a, b = (self.value(s, depth) for s in node.inputs[:2])
        if node.operation == "MULTIPLY":
            return self._product(a, b)
        if a.texture or b.texture:
            return None
        x, y = a.number, b.number
        result = {"ADD": lambda: x + y, "SUBTRACT": lambda: x - y, "DIVIDE": lambda: x / y if y else 0,
                  "POWER": lambda: x ** y if x > 0 else 0, "MINIMUM": lambda: min(x, y),
                  "MAXIMUM": lambda: max(x, y), "SQRT": lambda: math.sqrt(max(x, 0))}.get(node.operation)
        return None if result is None else Value([min(max(result(), 0), 1) if node.use_clamp else result()] * 3)

    # ---- image textures ---------------------------------------------------------------------------

    def _image(self, output, _):
        node = output.node
        if node.image is None:
            self.note(node, "has no image; the program shows it as Blender does: pink")
            return Value((1, 0, 1))
        if node.projection != "FLAT":
            return None
        if node.image.source == "TILED":
            self.note(node, "uses UDIM tiles, of which only the first is shown")
        if node.extension == "CLIP":
            self.note(node, "is clipped beyond its borders; here the border's colour continues")
        uv_name, transform = self._coordinates(node)
        wrap = {"REPEAT": "REPEAT", "MIRROR": "MIRROR"}.get(node.extension, "CLAMP")
        channel = "a" if output.name == "Alpha" else None
        texture = Texture(node.image, uv_name, transform, wrap, node.interpolation == "Closest", channel)
        texture.premultiplied = not node.outputs["Alpha"].is_linked and node.image.alpha_mode in {"STRAIGHT", "PREMUL"}
        return Value((1, 1, 1), texture)

    def _coordinates(self, node):
        """The name of the UV map (None = the active one) and the transform of its coordinates, glTF's way."""
        source = self.source(node.inputs["Vector"])
        transform = None
        if source is not None and source.node.type == "MAPPING":
            transform = self._mapping(source.node)
            source = self.source(source.node.inputs["Vector"])
        if source is None or (source.node.type == "TEX_COORD" and source.name == "UV"):
            return None, transform
        if source.node.type == "UVMAP":
            return source.node.uv_map or None, transform
        self.note(source.node, "gives texture coordinates that glTF does not have; the active UV map is used instead")
        return None, transform

    def _mapping(self, node):
        vectors = [node.inputs[k] for k in ("Location", "Rotation", "Scale") if k in node.inputs]
        if node.vector_type not in {"POINT", "TEXTURE"} or any(s.is_linked for s in vectors) or len(vectors) != 3:
            self.note(node, "cannot be followed; coordinates are not mapped")
            return None
        (x, y), turn, (sx, sy) = vectors[0].default_value[:2], vectors[1].default_value[2], vectors[2].default_value[:2]
        c, s = math.cos(turn), math.sin(turn)
        matrix = np.array([[c * sx, -s * sy, x], [s * sx, c * sy, y], [0, 0, 1]])
        if node.vector_type == "TEXTURE":
            if not sx or not sy:
                return None
            matrix = np.linalg.inv(matrix)
        flip = np.array([[1, 0, 0], [0, -1, 1], [0, 0, 1]])
        return flip @ matrix @ flip


def transform_extension(matrix):
    """KHR_texture_transform of a matrix for texture coordinates with v down, or None if it shears."""
    sx, sy = (math.hypot(matrix[0, k], matrix[1, k]) for k in range(2))
    if matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0] < 0:
        sy = -sy
    turn = math.atan2(-matrix[1, 0], matrix[0, 0])  # offset * rotation (clockwise) * scale
    c, s = math.cos(turn), math.sin(turn)
    made = np.array([[c * sx, s * sy], [-s * sx, c * sy]])
    if np.abs(made - matrix[:2, :2]).max() > 1e-4 * max(abs(sx), abs(sy), 1e-30):
        return None
    return {"offset": [float(matrix[0, 2]), float(matrix[1, 2])], "rotation": float(turn), "scale": [float(sx), float(sy)]}


class Images:
    """Images of Blender as images of a glTF file, each once."""

    def __init__(self, writer, report):
        self.writer, self.report = writer, report
        self.indices, self.pixels, self.samplers = {}, {}, {}

    def linear(self, image):
        """(height, width, 4) linear, row 0 on top; None if its file is missing."""
        if image.name_full not in self.pixels:
            self.pixels[image.name_full] = self._read(image)
        return self.pixels[image.name_full]

    def _read(self, image):
        width, height = image.size
        if not width or not height:  # sizes are known once the file was read
            image.pixels[0:1] if len(image.pixels) else None
            width, height = image.size
        if not width or not height or max(width, height) > LARGEST_SIDE:
            self.report.note(f"image '{image.name}': its file is missing or unreadable ({image.filepath or 'packed'}); "
                             "it is shown pink")
            return None
        values = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(values)
        values = values.reshape(height, width, image.channels)[::-1]
        full = np.ones((height, width, 4), np.float32)
        if image.channels < 3:
            full[..., :3] = values[..., :1]
            if image.channels == 2:
                full[..., 3] = values[..., 1]
        else:
            full[..., :image.channels] = values
        if not image.is_float and is_srgb(image):
            full[..., :3] = to_linear(full[..., :3])
        return full

    def _file_bytes(self, image):
        """The image's own PNG or JPEG, if it has not been changed in Blender."""
        if image.is_dirty or image.source != "FILE" or image.is_float:
            return None, None
        data = None
        if image.packed_file:
            data = bytes(image.packed_file.data)
        else:
            path = image.filepath_from_user()
            if os.path.isfile(path):
                with open(path, "rb") as file:
                    data = file.read()
        if data and data[:8] == b"\x89PNG\r\n\x1a\n":
            return data, "image/png"
        if data and data[:3] == b"\xff\xd8\xff":
            return data, "image/jpeg"
        return None, None

    def sampler(self, texture):
        key = texture.wrap, texture.nearest
        if key not in self.samplers:
            wrap = {"REPEAT": 10497, "MIRROR": 33648, "CLAMP": 33071}[texture.wrap]
            near = 9728 if texture.nearest else 9729
            self.samplers[key] = self.writer.add(
                "samplers", {"wrapS": wrap, "wrapT": wrap, "magFilter": near, "minFilter": 9987})
        return self.samplers[key]

    def is_opaque(self, image):
        pixels = self.linear(image)
        return pixels is None or np.all(pixels[..., 3] == 1)

    def colours(self, texture):
        """(height, width, 4) linear: what a node of the texture shows, and its alpha."""
        pixels = self.linear(texture.image)
        if not texture.premultiplied or self.is_opaque(texture.image):
            return pixels
        return np.dstack([pixels[..., :3] * pixels[..., 3:], np.ones(pixels.shape[:2], np.float32)])

    def colour_image(self, texture, gain):
        """The index of an sRGB image, its linear values times `gain` (3)."""
        image = texture.image
        key = "colour", image.name_full, texture.premultiplied, tuple(np.round(gain, 6))
        if key not in self.indices:
            whole = image.channels < 4 or not texture.premultiplied
            as_is = is_srgb(image) and np.all(gain == 1) and (whole or self.is_opaque(image))
            data, mime = self._file_bytes(image) if as_is else (None, None)
            pixels = self.colours(texture) if data is None else None
            if data is None and pixels is not None:
                data, mime = png_bytes(encode(pixels, gain, image.is_float)), "image/png"
            self.indices[key] = None if data is None else self.writer.add_image(data, mime, image.name)
        return self.indices[key]

    def data_image(self, key, name, make):
        """The index of an image of linear codes that `make` returns as (height, width, 3 or 4), 0..1."""
        if key not in self.indices:
            codes = np.round(255 * np.clip(make(), 0, 1)).astype(np.uint8)
            self.indices[key] = self.writer.add_image(png_bytes(codes), "image/png", name)
        return self.indices[key]

    def channel(self, texture):
        """(height, width): the channel of a texture that a number reads."""
        pixels = self.linear(texture.image)
        if pixels is None:
            return np.ones((1, 1), np.float32)
        if texture.channel in {"r", "g", "b", "a"}:
            return pixels[..., "rgba".index(texture.channel)]
        return pixels[..., :3] @ np.array([0.2126, 0.7152, 0.0722], np.float32)


def is_srgb(image):
    return image.colorspace_settings.name in {"sRGB", "Filmic sRGB"}


def encode(pixels, gain, deep):
    """sRGB codes of linear pixels times `gain`, with alpha where there is any."""
    colour = to_srgb(pixels[..., :3] * gain)
    values = colour if np.all(pixels[..., 3] >= 1) else np.concatenate([colour, pixels[..., 3:]], axis=2)
    most = 65535 if deep else 255
    return np.round(most * np.clip(values, 0, 1)).astype(np.uint16 if deep else np.uint8)


def resized(values, shape):
    """Nearest texels, so that channels of images of different sizes fit into one."""
    if values.shape[:2] == shape:
        return values
    rows = np.arange(shape[0]) * values.shape[0] // shape[0]
    columns = np.arange(shape[1]) * values.shape[1] // shape[1]
    return values[rows][:, columns]
