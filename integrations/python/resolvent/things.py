"""Parts of scenes: plain dataclasses with the names, units and defaults of the C structures."""
from __future__ import annotations

import dataclasses
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np

from ._native import ffi, lib
from .arrays import ArrayLike, check_finite, check_shape, choice, floats, number, pointer, real, rgb
from .context import count, names_of

Rgb = Union[float, Sequence[float]]
Vec3 = Sequence[float]

WRAPS = ("repeat", "mirror", "clamp")
ROLES = ("base_color", "opacity", "metallic_roughness", "normal", "emission", "specular", "specular_color",
         "transmission", "clearcoat", "clearcoat_roughness", "sheen_color", "sheen_roughness", "diffuse_transmission",
         "diffuse_transmission_color")
LIGHT_KINDS = ("point", "spot", "directional")


def text(name: str, value: Any) -> bytes:
    """A name as a C string."""
    if not isinstance(value, str):
        raise TypeError(f"{name}: {type(value).__name__} is not a str")
    if "\0" in value:
        raise ValueError(f"{name}: a name holds no zero")
    return value.encode()


def vec3(name: str, value: Any) -> Tuple[float, float, float]:
    x, y, z = floats(name, value, (3,))
    return float(x), float(y), float(z)


def _angle(name: str, value: Any, most: float) -> float:
    angle = number(name, value)
    if not 0 <= angle <= most:
        raise ValueError(f"{name}: {angle} is not in 0..{most:.6g} radians")
    return angle


@dataclasses.dataclass
class Texture:
    """An image on surfaces.

    Parameters
    ----------
    pixels : (height, width) or (height, width, 1..4), row 0 on top; uint8 values 0..255 stand for 0..1, floats are
        linear
    srgb : whether colour channels are sRGB; default: true for uint8 with three or four channels
    wrap : "repeat", "mirror" or "clamp", or a pair for u and v
    nearest : magnified texels are squares, not interpolated
    uv_set : 0 or 1
    scale : factor of a normal map's x and y
    """

    pixels: ArrayLike
    name: str = "texture"
    srgb: Optional[bool] = None
    wrap: Union[str, Sequence[str]] = "repeat"
    nearest: bool = False
    uv_set: int = 0
    scale: float = 1.0

    def _described(self, keep: List[Any]) -> Any:
        array = real("pixels", self.pixels)
        if array.ndim == 2:
            array = array[:, :, np.newaxis]
        if array.ndim != 3 or not 1 <= array.shape[2] <= 4 or 0 in array.shape:
            raise ValueError(f"pixels: shape {array.shape}; expected (height, width) or (height, width, 1..4)")
        if array.dtype != np.uint8 and array.dtype.kind != "f":
            raise TypeError(f"pixels: dtype {array.dtype}; expected uint8 or floats")
        is_codes = array.dtype == np.uint8
        array = np.ascontiguousarray(array, np.uint8 if is_codes else np.float32)
        check_finite("pixels", array)
        wrap = (self.wrap, self.wrap) if isinstance(self.wrap, str) else tuple(self.wrap)
        if len(wrap) != 2:
            raise ValueError(f"wrap: {len(wrap)} names; expected one, or one for each of u and v")
        name = ffi.new("char[]", text("name", self.name))
        keep += [array, name]
        return ffi.new("rsv_texture_desc *", {
            "size": ffi.sizeof("rsv_texture_desc"), "name": name, "height": array.shape[0], "width": array.shape[1], "channel_count": array.shape[2],
            "codes": pointer("uint8_t", array if is_codes else None),
            "values": pointer("float", None if is_codes else array),
            "srgb": is_codes and array.shape[2] > 2 if self.srgb is None else bool(self.srgb),
            "wrap_u": choice("wrap", wrap[0], WRAPS), "wrap_v": choice("wrap", wrap[1], WRAPS),
            "nearest": bool(self.nearest)})


_PLAIN = lib.rsv_default_material()


def _plain_rgb(field: str) -> Tuple[float, float, float]:
    value = getattr(_PLAIN, field)
    return value.r, value.g, value.b


@dataclasses.dataclass
class Material:
    """A surface, described by glTF's metallic-roughness model (docs/materials.md). The fields are those of rsv_material
    in scene.h.

    Colours are linear RGB, or one number for all three; distances are in metres, radiance in W/(sr m2). `textures` maps
    properties ("base_color", "opacity", "metallic_roughness", "normal", "emission", ...) to the Texture that multiplies
    them.
    """

    name: str = "material"
    base_color: Rgb = _plain_rgb("base_color")
    metallic: float = _PLAIN.metallic
    roughness: float = _PLAIN.roughness
    ior: float = _PLAIN.ior
    specular: float = _PLAIN.specular
    specular_color: Rgb = _plain_rgb("specular_color")
    transmission: float = _PLAIN.transmission
    thickness: float = _PLAIN.thickness
    attenuation_color: Rgb = _plain_rgb("attenuation_color")
    attenuation_distance: float = _PLAIN.attenuation_distance
    emission: Rgb = _plain_rgb("emission")
    double_sided: bool = _PLAIN.double_sided
    unlit: bool = _PLAIN.unlit
    clearcoat: float = _PLAIN.clearcoat
    clearcoat_roughness: float = _PLAIN.clearcoat_roughness
    sheen_color: Rgb = _plain_rgb("sheen_color")
    sheen_roughness: float = _PLAIN.sheen_roughness
    diffuse_transmission: float = _PLAIN.diffuse_transmission
    diffuse_transmission_color: Rgb = _plain_rgb("diffuse_transmission_color")
    scatter_distance: Rgb = _plain_rgb("scatter_distance")
    opacity: float = _PLAIN.opacity
    alpha_cutoff: float = _PLAIN.alpha_cutoff
    camera_emission: float = _PLAIN.camera_emission
    textures: Dict[str, Texture] = dataclasses.field(default_factory=dict)

    @classmethod
    def lambert(cls, albedo: Rgb, name: str = "lambert", emission: Rgb = 0.0) -> Material:
        """A matt surface that reflects the fraction `albedo` of the light, equally in all directions."""
        return cls(name=name, base_color=albedo, specular=0.0, metallic=0.0, emission=emission)

    @classmethod
    def preset(cls, name: str) -> Material:
        """A translucent material from measurements: "marble", "skin1", "wholemilk", ..."""
        struct = ffi.new("rsv_material *")
        if not lib.rsv_material_preset(text("name", name), struct):
            known = ", ".join(names_of(lib.rsv_material_preset_names()))
            raise ValueError(f"name: there is no '{name}'; there are {known}")
        return cls._of(struct, name)

    @classmethod
    def _of(cls, struct: Any, name: Optional[str] = None) -> Material:
        values: Dict[str, Any] = {}
        for field in dataclasses.fields(cls):
            if field.name in ("name", "textures"):
                continue
            value = getattr(struct, field.name)
            values[field.name] = (value.r, value.g, value.b) if isinstance(value, ffi.CData) else value
        own = ffi.string(struct.name).decode("utf-8", "replace") if struct.name != ffi.NULL else "unnamed"
        return cls(name=own if name is None else name, **values)

    def _described(self, textures: Dict[int, int], keep: List[Any]) -> Any:
        """@param textures ids in the scene, by identity of the Texture"""
        struct = ffi.new("rsv_material *", lib.rsv_default_material())
        keep.append(ffi.new("char[]", text("name", self.name)))
        struct.name = keep[-1]
        for field in dataclasses.fields(self):
            if field.name in ("name", "textures"):
                continue
            where, value = f"material '{self.name}': {field.name}", getattr(self, field.name)
            if isinstance(getattr(struct, field.name), ffi.CData):
                setattr(struct, field.name, rgb(where, value))
            elif isinstance(getattr(struct, field.name), bool):
                setattr(struct, field.name, bool(value))
            elif field.name == "attenuation_distance" and value == float("inf"):
                struct.attenuation_distance = value
            else:
                setattr(struct, field.name, number(where, value))
        if self.textures:
            uses = ffi.new("rsv_texture_ref[]", [self._use(role, texture, textures[id(texture)])
                                                 for role, texture in self.textures.items()])
            struct.textures, struct.texture_count = uses, len(uses)
            keep.append(uses)
        return struct

    @staticmethod
    def _use(role: str, texture: Texture, number_of_it: int) -> Any:
        use = lib.rsv_default_texture_ref(choice("textures", role, ROLES), number_of_it)
        use.uv_set, use.scale = count("uv_set", texture.uv_set, 1), number("scale", texture.scale)
        return use


@dataclasses.dataclass
class Mesh:
    """Triangles and their materials.

    Parameters
    ----------
    vertices : (V, 3) metres
    triangles : (T, 3) vertex indices, counter-clockwise seen from the front; None = vertices 0, 1, 2, then 3, 4, 5, ...
    material : a Material, or a sequence of them for `triangle_materials`
    triangle_materials : (T,) index of each triangle's material in that sequence
    normals : (V, 3) for smooth shading; None = flat
    uvs : (V, 2) texture coordinates, or two such arrays; (0, 0) is the upper left corner
    vertex_colors, triangle_colors : (V or T, 3 or 4) linear RGB and opacity, which multiply the material's
    tangents : (V, 4) direction of increasing u, and the sign of the bitangent
    transforms : (4, 4) or (K, 4, 4), object to world, for column vectors; K transforms place K instances
    """

    vertices: ArrayLike
    triangles: Optional[ArrayLike] = None
    material: Union[Material, Sequence[Material]] = dataclasses.field(default_factory=Material)
    triangle_materials: Optional[ArrayLike] = None
    normals: Optional[ArrayLike] = None
    uvs: Optional[Any] = None
    vertex_colors: Optional[ArrayLike] = None
    triangle_colors: Optional[ArrayLike] = None
    tangents: Optional[ArrayLike] = None
    transforms: Optional[ArrayLike] = None
    name: str = "mesh"

    def _materials(self) -> List[Material]:
        materials = [self.material] if isinstance(self.material, Material) else list(self.material)
        for k, material in enumerate(materials):
            if not isinstance(material, Material):
                raise TypeError(f"mesh '{self.name}': material {k} is a {type(material).__name__}, not a Material")
        if not materials:
            raise ValueError(f"mesh '{self.name}': there is no material")
        return materials


@dataclasses.dataclass
class PunctualLight:
    """A light without an area. (Area lights are emissive materials.)

    `intensity` is in W/sr; for directional lights it is the irradiance at normal incidence, W/m2. `direction` is the
    direction in which light travels. Cone angles are half angles in radians. The intensity of a spot is multiplied by
    cos^exponent. Between the cones it falls off as t^2, or t^2 (3 - 2 t) with `smooth_cone`, where t is linear in the
    cosine.
    """

    kind: str = "point"
    intensity: Rgb = 1.0
    position: Vec3 = (0.0, 0.0, 0.0)
    direction: Vec3 = (0.0, -1.0, 0.0)
    name: str = "light"
    inner_cone_angle: float = 0.0
    outer_cone_angle: float = np.pi / 4
    exponent: float = 0.0
    smooth_cone: bool = False

    @classmethod
    def _of(cls, struct: Any, origin: np.ndarray) -> PunctualLight:
        at, d, i = struct.position, struct.direction, struct.intensity
        return cls(LIGHT_KINDS[struct.kind], (i.r, i.g, i.b), tuple(np.array([at.x, at.y, at.z]) + origin),
                   (d.x, d.y, d.z), ffi.string(struct.name).decode("utf-8", "replace"), struct.inner_cone_angle,
                   struct.outer_cone_angle, struct.exponent, struct.smooth_cone)

    def _described(self, keep: List[Any]) -> Any:
        where = f"light '{self.name}': "
        direction = np.array(vec3(where + "direction", self.direction))
        if not direction.any():
            raise ValueError(where + "direction is zero")
        name = ffi.new("char[]", text("name", self.name))
        keep.append(name)
        return ffi.new("rsv_punctual_light *", {
            "name": name, "kind": choice(where + "kind", self.kind, LIGHT_KINDS),
            "position": vec3(where + "position", self.position),
            "direction": tuple(direction / np.linalg.norm(direction)),
            "intensity": rgb(where + "intensity", self.intensity),
            "inner_cone_angle": _angle(where + "inner_cone_angle", self.inner_cone_angle, np.pi / 2),
            "outer_cone_angle": _angle(where + "outer_cone_angle", self.outer_cone_angle, np.pi / 2),
            "exponent": number(where + "exponent", self.exponent), "smooth_cone": bool(self.smooth_cone)})


@dataclasses.dataclass
class Camera:
    """A camera at `position` that looks at `target`, with y up. `vertical_fov` is in radians; `aspect` is
    width / height, 0 = any.

    For cameras that are rotated about their axis, set `up`. For orthographic cameras, set `vertical_fov` to 0 and
    `vertical_extent` to half the height of the view in metres.
    """

    position: Vec3
    target: Vec3
    vertical_fov: float = np.pi / 4
    aspect: float = 0.0
    name: str = "camera"
    up: Vec3 = (0.0, 1.0, 0.0)
    vertical_extent: float = 0.0

    @classmethod
    def _of(cls, struct: Any, origin: np.ndarray) -> Camera:
        p, f, u = struct.position, struct.forward, struct.up
        position = np.array([p.x, p.y, p.z]) + origin
        return cls(tuple(position), tuple(position + [f.x, f.y, f.z]), struct.vertical_fov, struct.aspect,
                   ffi.string(struct.name).decode("utf-8", "replace"), (u.x, u.y, u.z), struct.vertical_extent)

    def _described(self, keep: List[Any], origin: Optional[np.ndarray] = None) -> Any:
        where = f"camera '{self.name}': "
        position = real(where + "position", self.position) - (0 if origin is None else origin)
        forward = real(where + "target", self.target) - real(where + "position", self.position)
        floats(where + "target", forward, (3,))
        if not forward.any():
            raise ValueError(where + "target is where the camera is")
        forward = forward / np.linalg.norm(forward)
        up = np.array(vec3(where + "up", self.up))
        right = np.cross(forward, up)
        if np.linalg.norm(right) < 1e-6 * np.linalg.norm(up):  # looks up or down
            right = np.cross(forward, [0.0, 0.0, -1.0] if abs(forward[2]) < 0.9 else [0.0, 1.0, 0.0])
        if not right.any():
            raise ValueError(where + "up is zero")
        right = right / np.linalg.norm(right)
        name = ffi.new("char[]", text("name", self.name))
        keep.append(name)
        return ffi.new("rsv_camera *", {
            "name": name, "position": vec3(where + "position", position), "right": tuple(right),
            "up": tuple(np.cross(right, forward)), "forward": tuple(forward),
            "vertical_fov": _angle(where + "vertical_fov", self.vertical_fov, 3.1),
            "vertical_extent": number(where + "vertical_extent", self.vertical_extent),
            "aspect": number(where + "aspect", self.aspect)})


@dataclasses.dataclass
class Fog:
    """A participating medium between surfaces, which absorbs, scatters and emits (rsv_fog in scene.h).

    `extinction` is in 1/m and `emission` in W/(sr m3), both at `base_height` (y in metres) and below. Above it, they
    fall to 1/e over `scale_height` metres. `albedo` is that of single scattering, `anisotropy` the mean cosine of the
    Henyey-Greenstein phase function. `bounds`, (2, 3) metres, is the box that the fog fills; None = chosen
    automatically.
    """

    extinction: Rgb
    albedo: Rgb = 1.0
    anisotropy: float = 0.0
    emission: Rgb = 0.0
    scale_height: float = float("inf")
    base_height: float = 0.0
    bounds: Optional[ArrayLike] = None

    def _described(self) -> Any:
        fog = ffi.new("rsv_fog *", lib.rsv_default_fog())
        fog.extinction, fog.albedo = rgb("fog: extinction", self.extinction), rgb("fog: albedo", self.albedo)
        fog.anisotropy, fog.emission = number("fog: anisotropy", self.anisotropy), rgb("fog: emission", self.emission)
        fog.base_height = number("fog: base_height", self.base_height)
        if self.scale_height != float("inf"):
            fog.scale_height = number("fog: scale_height", self.scale_height)
        if self.bounds is not None:
            box = real("fog: bounds", self.bounds)
            check_shape("fog: bounds", box, (2, 3))
            if not (box[0] < box[1]).all():  # NaN, too
                raise ValueError("fog: bounds[0] is not below bounds[1]")
            fog.bounds_min, fog.bounds_max = tuple(box[0].tolist()), tuple(box[1].tolist())
        return fog


@dataclasses.dataclass
class Environment:
    """Light from infinitely far away.

    `source` is a latitude-longitude image of radiance, (height, width, 3) W/(sr m2), row 0 on top
    (docs/conventions.md); or the path of an .hdr or .exr file; or "sky" or "white". `intensity` multiplies it.
    `rotation` is about +y, in degrees, counter-clockwise from above.
    """

    source: Any
    intensity: float = 1.0
    rotation: float = 0.0
    name: str = "environment"
