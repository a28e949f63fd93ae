"""Scenes: from files, built-in, or from arrays."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Literal, Optional, Sequence, Tuple, Union, overload

import numpy as np

from ._native import ffi, lib
from .arrays import ArrayLike, choice, copy_of, floats, indices, number, pointer, probes, real
from .context import Context, Object, count, default_context, names_of
from .images import Path, file_name
from .rendering import Layered, plan_desc, render_desc, render_planned, rendered
from .solving import Wishes
from .things import Camera, Environment, Fog, Material, Mesh, PunctualLight, Texture, text

if TYPE_CHECKING:
    from .light import Light

AXES = ("x", "y", "z")


class Scene(Object):
    """Meshes, materials, lights and cameras. Immutable and thread-safe.

    Created by `Scene.load`, `Scene.builtin` or `Scene.from_meshes`.
    """

    _made_by = "Scene.load, Scene.builtin or Scene.from_meshes"

    # ---- creating ----------------------------------------------------------------------------------

    @classmethod
    def load(cls, path: Path, *, environment: Any = None, fog: Optional[Fog] = None,
             metres_per_unit: float = 1.0, up: str = "y", crease_angle: float = np.pi / 4,
             context: Optional[Context] = None) -> Scene:
        """Reads glTF 2.0 (.gltf, .glb), .obj, .ply, .fbx, .dae or .stl.

        Parameters
        ----------
        environment : an Environment, or a value for its `source`; None = the environment of the file
        fog : a medium in the air; docs/media.md says which modes support it
        metres_per_unit, up : of .obj, .ply and .stl, which state neither
        crease_angle : radians; meshes without normals are shaded smoothly across flatter edges (not in glTF)
        """
        context = context or default_context()
        desc = ffi.new("rsv_load_desc *", lib.rsv_default_load_desc())
        desc.metres_per_unit = number("metres_per_unit", metres_per_unit)
        desc.up, desc.crease_angle = choice("up", up, AXES), number("crease_angle", crease_angle)
        handle = context.create(lib.rsv_scene_load_with, "rsv_scene", lib.rsv_scene_destroy, None,
                                context._handle.pointer, file_name("path", path), desc)
        return cls(context, handle)._surrounded(environment)._filled(fog)

    @classmethod
    def builtin(cls, name: str, *, environment: Any = None, fog: Optional[Fog] = None, body: Optional[Scene] = None,
                body_triangles: int = 60000, context: Optional[Context] = None) -> Scene:
        """A built-in scene: "cornell-spheres", "gallery:4", "terraces:1e5", ... (`Scene.builtin_names()`).

        `body` is a scene whose triangles replace the scene's own body, if it has one.
        """
        context = context or (body.context if isinstance(body, Scene) else default_context())
        desc = ffi.new("rsv_builtin_desc *", lib.rsv_default_builtin_desc())
        desc.body_triangles = count("body_triangles", body_triangles)
        if body is not None:
            desc.body = body._pointer
        handle = context.create(lib.rsv_scene_builtin_with, "rsv_scene", lib.rsv_scene_destroy, None,
                                context._handle.pointer, text("name", name), desc)
        return cls(context, handle)._surrounded(environment)._filled(fog)

    @staticmethod
    def builtin_names() -> List[str]:
        """Names of the built-in scenes."""
        return names_of(lib.rsv_scene_builtin_names())

    @classmethod
    def from_meshes(cls, meshes: Union[Mesh, Iterable[Mesh]], *, lights: Iterable[PunctualLight] = (),
                    cameras: Iterable[Camera] = (), environment: Any = None, fog: Optional[Fog] = None,
                    context: Optional[Context] = None) -> Scene:
        """A scene from arrays, which are copied. Without a camera, it gets one named "framing" that shows all of it."""
        context = context or default_context()
        handle = context.create(lib.rsv_scene_create, "rsv_scene", lib.rsv_scene_destroy, None, context._handle.pointer)
        scene = cls(context, handle)
        builder = _Builder(scene)
        for mesh in [meshes] if isinstance(meshes, Mesh) else meshes:
            builder.add_mesh(mesh)
        for light in lights:
            context.call(lib.rsv_scene_add_light, handle.pointer, light._described(builder.keep))
        for camera in cameras:
            context.call(lib.rsv_scene_add_camera, handle.pointer, camera._described(builder.keep))
        context.call(lib.rsv_scene_commit, handle.pointer)
        return scene._surrounded(environment)._filled(fog)

    def _surrounded(self, environment: Any) -> Scene:
        if environment is None:
            return self
        e = environment if isinstance(environment, Environment) else Environment(environment)
        intensity, rotation = number("environment: intensity", e.intensity), number("environment: rotation", e.rotation)
        if isinstance(e.source, (str, os.PathLike)):
            named = isinstance(e.source, str) and lib.rsv_environment_is_builtin(text("environment", e.source))
            function = lib.rsv_scene_set_builtin_environment if named else lib.rsv_scene_load_environment
            source = text("environment", e.source) if named else file_name("environment", e.source)
            self._context.call(function, self._pointer, source, intensity, rotation)
            return self
        pixels = floats("environment", e.source, ("height", "width", 3))
        name = ffi.new("char[]", text("environment: name", e.name))
        struct = ffi.new("rsv_environment *", {
            "name": name, "pixels": pointer("rsv_rgb", pixels), "height": pixels.shape[0], "width": pixels.shape[1],
            "intensity": intensity, "rotation": rotation})
        self._context.call(lib.rsv_scene_set_environment, self._pointer, struct)
        return self

    def _filled(self, fog: Optional[Fog]) -> Scene:
        if fog is None:
            return self
        if not isinstance(fog, Fog):
            raise TypeError(f"fog: {type(fog).__name__} is not a Fog")
        self._context.call(lib.rsv_scene_set_fog, self._pointer, fog._described())
        return self

    # ---- contents ----------------------------------------------------------------------------------

    @property
    def _view(self) -> Any:
        return lib.rsv_scene_get_view(self._pointer)

    def __repr__(self) -> str:
        v = self._view
        return f"<resolvent.Scene: {v.triangle_count} triangles, {v.material_count} materials, {v.light_count} lights>"

    @property
    def origin(self) -> np.ndarray:
        """(3,) float64, metres: the library's coordinates are relative to this point, 0 in most scenes. This package
        converts them: all coordinates here are those of the file."""
        return copy_of(self._view.origin, (3,), np.float64)

    def _placed(self, array: np.ndarray) -> np.ndarray:
        origin = self.origin
        return array + origin if origin.any() else array

    @property
    def vertices(self) -> np.ndarray:
        """(V, 3) metres, world space; float32, or float64 far from the origin."""
        return self._placed(copy_of(self._view.position, (self._view.vertex_count, 3), np.float32))

    @property
    def normals(self) -> np.ndarray:
        """(V, 3) float32, unit shading normals."""
        return copy_of(self._view.normal, (self._view.vertex_count, 3), np.float32)

    @property
    def triangles(self) -> np.ndarray:
        """(T, 3) uint32, counter-clockwise seen from the front."""
        return copy_of(self._view.triangle, (self._view.triangle_count, 3), np.uint32)

    @property
    def triangle_materials(self) -> np.ndarray:
        """(T,) uint32, indices into `materials`."""
        return copy_of(self._view.triangle_material, (self._view.triangle_count,), np.uint32)

    @property
    def triangle_objects(self) -> np.ndarray:
        """(T,) uint32, indices into `object_names`."""
        return copy_of(self._view.triangle_object, (self._view.triangle_count,), np.uint32)

    @property
    def object_names(self) -> List[str]:
        """One name for each placed mesh."""
        view = self._view
        return [ffi.string(view.object_name[k]).decode("utf-8", "replace") for k in range(view.object_count)]

    @property
    def materials(self) -> List[Material]:
        """The materials, without their textures."""
        return [Material._of(self._view.material[k]) for k in range(self._view.material_count)]

    @property
    def lights(self) -> List[PunctualLight]:
        """The punctual lights. Area lights are emissive materials."""
        return [PunctualLight._of(self._view.light[k], self.origin) for k in range(self._view.light_count)]

    @property
    def cameras(self) -> List[Camera]:
        """The cameras, at least one."""
        return [Camera._of(self._view.camera[k], self.origin) for k in range(self._view.camera_count)]

    @property
    def bounds(self) -> np.ndarray:
        """(2, 3): smallest and largest coordinates, metres."""
        low, high = self._view.bounds_min, self._view.bounds_max
        return self._placed(np.array([[low.x, low.y, low.z], [high.x, high.y, high.z]]))

    @property
    def environment(self) -> Optional[Environment]:
        """The environment, with its intensity applied to the pixels; None = black."""
        e = self._view.environment
        if e == ffi.NULL:
            return None
        return Environment(copy_of(e.pixels, (e.height, e.width, 3), np.float32), 1.0, e.rotation,
                           ffi.string(e.name).decode("utf-8", "replace"))

    def fingerprint(self) -> str:
        """SHA-256 of everything in the scene, hexadecimal."""
        digits = ffi.new("char[]", lib.RSV_FINGERPRINT_DIGITS + 1)
        self._context.call(lib.rsv_scene_fingerprint, self._pointer, digits)
        return ffi.string(digits).decode()

    def save(self, path: Path) -> None:
        """Writes binary glTF; `Scene.load` reads the same scene back."""
        self._context.call(lib.rsv_scene_save, self._pointer, file_name("path", path))

    # ---- light -------------------------------------------------------------------------------------

    def solve(self, quality: str = "medium", *, goal: Any = None, error: Optional[float] = None,
              **options: Any) -> Light:
        """Solves the light of the scene.

        Parameters
        ----------
        quality : "draft", "medium" or "high"
        goal : a camera (name or index) or (points, normals), both (..., 3): refine only what affects these
        error : refine, starting at `quality`, until the certified relative error (of the goal, if there is one) is
            below this value, 1e-4..1; `Light.certificate` holds the certificate
        options : fields of rsv_solve_desc (solve.h): element_target, rays_per_element, refinements, light_samples,
            photon_count, direct_levels, direct_level, solver ("auto", "gmres", ...), max_orders, tolerance, seed,
            max_elements, max_bytes, checkpoint, earlier; with `error` also max_seconds and max_rounds
        """
        from .light import Light  # lights have scenes, too

        return Light._solved(self, Wishes(self, quality, goal, error, options))

    def render(self, camera: Any = None, *, width: Optional[int] = None, height: Optional[int] = None,
               error: Optional[float] = None, max_time: Optional[float] = None, layers: bool = False,
               seed: int = 0) -> Any:
        """Renders one picture, like `resolvent render`: elements, rays and samples are chosen together. For several
        pictures, `solve` once instead.

        Parameters
        ----------
        camera : a Camera, or the name or index of a camera of the scene; None = the first
        width, height : pixels; what is missing follows from the camera's aspect, with a longer side of 512
        error : target RMS error of pixels, relative to the pixels around them, 0.005..1; default 0.07
        max_time : the best picture possible in this many seconds, stopping early if `error` is reached

        Returns
        -------
        (height, width, 3) float32, W/(sr m2); with `layers` a tuple of this and a dict of pictures by order of
        reflection
        """
        desc, keep = render_desc(self, "final", camera, (width, height), layers=layers, seed=seed)
        handle = self._context.create(render_planned, "rsv_image", lib.rsv_image_destroy, None, self._pointer, ffi.NULL,
                                      plan_desc(error, max_time), desc)
        del keep
        return rendered(handle, layers)

    @property
    def _has_fog(self) -> bool:
        return lib.rsv_scene_get_view(self._pointer).fog != ffi.NULL

    @overload
    def reference(self, camera: Any = None, *, width: Optional[int] = None, height: Optional[int] = None,
                  samples: int = 64, layers: Literal[False] = False, seed: int = 0,
                  path_depth: int = 64) -> np.ndarray: ...

    @overload
    def reference(self, camera: Any = None, *, width: Optional[int] = None, height: Optional[int] = None,
                  samples: int = 64, layers: Literal[True], seed: int = 0, path_depth: int = 64) -> Layered: ...

    def reference(self, camera: Any = None, *, width: Optional[int] = None, height: Optional[int] = None,
                  samples: int = 64, layers: bool = False, seed: int = 0, path_depth: int = 64) -> Any:
        """Renders a picture with the path tracer, which needs no solution.

        Returns
        -------
        (height, width, 3) float32, W/(sr m2); with `layers` a tuple of this and a dict of pictures by order of
        reflection: "emission", "direct", "bounce1", ...
        """
        desc, keep = render_desc(self, "reference", camera, (width, height), samples=samples, layers=layers, seed=seed,
                                 path_depth=path_depth)
        handle = self._context.create(_render_reference, "rsv_image", lib.rsv_image_destroy, None, self._pointer, desc)
        del keep
        return rendered(handle, layers)

    @overload
    def reference_irradiance(self, points: ArrayLike, normals: ArrayLike, *, samples: int = 4096, seed: int = 0,
                             return_error: Literal[False] = False) -> np.ndarray: ...

    @overload
    def reference_irradiance(self, points: ArrayLike, normals: ArrayLike, *, samples: int = 4096, seed: int = 0,
                             return_error: Literal[True]) -> Tuple[np.ndarray, np.ndarray]: ...

    def reference_irradiance(self, points: ArrayLike, normals: ArrayLike, *, samples: int = 4096, seed: int = 0,
                             return_error: bool = False) -> Any:
        """Path-traced irradiance at points: like `Light.irradiance`, without a solution."""
        given, shape = probes(points, normals, self.origin)
        readings = np.empty((len(given), 6), np.float32)
        self._context.call(lib.rsv_probe_reference, self._pointer, pointer("rsv_probe", given), len(given),
                           count("samples", samples, least=1), count("seed", seed),
                           pointer("rsv_probe_reading", readings))
        return split_readings(readings, shape, return_error)


def split_readings(readings: np.ndarray, shape: Tuple[int, ...], return_error: bool) -> Any:
    """Irradiance, and with `return_error` its standard error."""
    irradiance = np.ascontiguousarray(readings[:, :3]).reshape(shape + (3,))
    return (irradiance, np.ascontiguousarray(readings[:, 3:]).reshape(shape + (3,))) if return_error else irradiance


def _render_reference(scene: Any, desc: Any, image: Any) -> int:
    return lib.rsv_render_reference(scene, desc, image, ffi.NULL)


class _Builder:
    """Adds meshes to a scene before commit. Shared materials and textures are added once."""

    def __init__(self, scene: Scene):
        self._context, self._scene = scene._context, scene._pointer
        self._material: Dict[int, int] = {}
        self._texture: Dict[int, int] = {}
        self.keep: List[Any] = []

    def _add_texture(self, texture: Texture) -> None:
        if not isinstance(texture, Texture):
            raise TypeError(f"textures: {type(texture).__name__} is not a Texture")
        if id(texture) not in self._texture:
            number_of_it = ffi.new("uint32_t *")
            self._context.call(lib.rsv_scene_add_texture, self._scene, texture._described(self.keep), number_of_it)
            self._texture[id(texture)] = number_of_it[0]
            self.keep.append(texture)

    def _add_material(self, material: Material) -> int:
        if id(material) not in self._material:
            for texture in material.textures.values():
                self._add_texture(texture)
            number_of_it = ffi.new("uint32_t *")
            self._context.call(lib.rsv_scene_add_material, self._scene, material._described(self._texture, self.keep),
                               number_of_it)
            self._material[id(material)] = number_of_it[0]
            self.keep.append(material)
        return self._material[id(material)]

    def add_mesh(self, mesh: Mesh) -> None:
        if not isinstance(mesh, Mesh):
            raise TypeError(f"meshes: {type(mesh).__name__} is not a Mesh")
        arrays = _MeshArrays(mesh)
        materials = mesh._materials()
        transforms = _transforms(mesh)
        for k, material in enumerate(materials):
            if arrays.material is not None and not (arrays.material == k).any():
                continue
            self._add_part(mesh, arrays.of_material(k), self._add_material(material), transforms)

    def _add_part(self, mesh: Mesh, arrays: _MeshArrays, material: int, transforms: np.ndarray) -> None:
        name = ffi.new("char[]", text("name", mesh.name))
        uvs = [pointer("float", uv) for uv in arrays.uvs]
        desc = ffi.new("rsv_mesh_desc *", {
            "size": ffi.sizeof("rsv_mesh_desc"), "name": name, "positions": pointer("rsv_vec3", arrays.vertices),
            "normals": pointer("rsv_vec3", arrays.normals), "vertex_count": len(arrays.vertices),
            "indices": pointer("uint32_t", arrays.triangles), "triangle_count": len(arrays.triangles),
            "material": material, "uvs": [ffi.cast("float (*)[2]", uv) for uv in uvs],
            "tangents": ffi.cast("float (*)[4]", pointer("float", arrays.tangents)),
            "colors": ffi.cast("float (*)[4]", pointer("float", arrays.colors))})
        mesh_id = ffi.new("uint32_t *")
        self._context.call(lib.rsv_scene_add_mesh, self._scene, desc, mesh_id)
        for transform in transforms:
            columns = ffi.new("float[16]", [float(x) for x in transform.T.ravel()])
            self._context.call(lib.rsv_scene_add_instance, self._scene, mesh_id[0], columns, name)


def _transforms(mesh: Mesh) -> np.ndarray:
    if mesh.transforms is None:
        return np.eye(4, dtype=np.float32)[np.newaxis]
    array = real(f"mesh '{mesh.name}': transforms", mesh.transforms)
    array = array[np.newaxis] if array.ndim == 2 else array
    return floats(f"mesh '{mesh.name}': transforms", array, ("K", 4, 4))


class _MeshArrays:
    """The checked arrays of a mesh. With colours per triangle, each corner becomes a separate vertex."""

    def __init__(self, mesh: Mesh):
        where = f"mesh '{mesh.name}': "
        self.vertices = floats(where + "vertices", mesh.vertices, ("V", 3))
        size = len(self.vertices)
        if mesh.triangles is None:
            if size % 3:
                raise ValueError(f"{where}{size} vertices without triangles; expected three for each")
            self.triangles = np.arange(size, dtype=np.uint32).reshape(-1, 3)
        else:
            self.triangles = indices(where + "triangles", mesh.triangles, ("T", 3), size)
        if not len(self.triangles):
            raise ValueError(f"{where}it has no triangle")
        self.normals = self._optional(where + "normals", mesh.normals, (size, 3))
        self.tangents = self._optional(where + "tangents", mesh.tangents, (size, 4))
        self.uvs = self._uvs(where, mesh.uvs, size)
        self.colors = _colors(where + "vertex_colors", mesh.vertex_colors, size)
        self.material = self._triangle_materials(where, mesh)
        by_triangle = _colors(where + "triangle_colors", mesh.triangle_colors, len(self.triangles))
        if by_triangle is not None:
            self._separate(where, by_triangle)

    @staticmethod
    def _optional(name: str, value: Any, shape: Sequence[Union[int, str]]) -> Optional[np.ndarray]:
        return None if value is None else floats(name, value, shape)

    @staticmethod
    def _uvs(where: str, value: Any, size: int) -> List[Optional[np.ndarray]]:
        if value is None:
            return [None, None]
        is_pair = isinstance(value, (list, tuple)) and len(value) == 2 and np.ndim(value[0]) == 2
        sets = list(value) if is_pair else [value]
        return [floats(f"{where}uvs", uv, (size, 2)) for uv in sets] + [None] * (2 - len(sets))

    def _triangle_materials(self, where: str, mesh: Mesh) -> Optional[np.ndarray]:
        number_of_them = len(mesh._materials())
        if mesh.triangle_materials is None:
            if number_of_them > 1:
                raise ValueError(f"{where}{number_of_them} materials; triangle_materials must say which has which")
            return None
        return indices(where + "triangle_materials", mesh.triangle_materials, (len(self.triangles),), number_of_them)

    def _separate(self, where: str, colors: np.ndarray) -> None:
        if self.colors is not None:
            raise ValueError(f"{where}vertex_colors and triangle_colors are both given; one is all there can be")
        corner = self.triangles.ravel()
        self.vertices = self.vertices[corner]
        self.normals = None if self.normals is None else self.normals[corner]
        self.tangents = None if self.tangents is None else self.tangents[corner]
        self.uvs = [None if uv is None else uv[corner] for uv in self.uvs]
        self.colors = np.repeat(colors, 3, axis=0)
        self.triangles = np.arange(len(corner), dtype=np.uint32).reshape(-1, 3)

    def of_material(self, index: int) -> _MeshArrays:
        """The triangles of one material, and the vertices that they use."""
        if self.material is None:
            return self
        part = object.__new__(_MeshArrays)
        used, inverse = np.unique(self.triangles[self.material == index], return_inverse=True)
        part.vertices, part.triangles = self.vertices[used], inverse.astype(np.uint32).reshape(-1, 3)
        part.normals = None if self.normals is None else self.normals[used]
        part.tangents = None if self.tangents is None else self.tangents[used]
        part.uvs = [None if uv is None else uv[used] for uv in self.uvs]
        part.colors = None if self.colors is None else self.colors[used]
        part.material = None
        return part


def _colors(name: str, value: Any, size: int) -> Optional[np.ndarray]:
    """(size, 4) float32, with an opacity of 1 if there is none."""
    if value is None:
        return None
    array = real(name, value)
    channels = array.shape[1] if array.ndim == 2 and array.shape[1] == 4 else 3
    colors = floats(name, array, (size, channels))
    return colors if channels == 4 else np.ascontiguousarray(np.c_[colors, np.ones(size, np.float32)])
