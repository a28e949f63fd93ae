"""Solved light: reading, rendering, relighting, certifying, differentiating, saving."""
from __future__ import annotations

import dataclasses
import functools
from typing import Any, Dict, Iterator, List, Literal, Mapping, NamedTuple, Optional, Tuple, overload

import numpy as np

from ._native import ffi, lib
from .arrays import ArrayLike, choice, copy_of, floats, number, pointer, probes, real, rgb
from .context import Context, Handle, Object, count, default_context, names_of
from .images import Path, file_name
from .transport import Operator
from .rendering import GLOSSES, Layered, camera_of, plan_desc, render_desc, render_planned, rendered
from .reports import (ERROR_STOPS, BakeReport, Certificate, GoalCertificate, SolveReport, report, solve_report)
from .scene import Scene, split_readings
from .solving import Wishes
from .things import Rgb, Vec3, text, vec3

PROBE_MODES = ("lookup", "operator", "reference")


class Source(NamedTuple):
    """A source of light, as `Light.relight` names it."""

    name: str
    strength: Tuple[float, float, float]  #: radiance of a lamp, intensity of a light, 1 for the environment
    position: Tuple[float, float, float]  #: metres
    movable: bool
    node: Optional[str]  #: node that placed the light, if several share a name


@dataclasses.dataclass(frozen=True)
class Basis:
    """The contribution of each source to readings, with all reflections.

    Readings are linear in the strengths. With factors f of the sources, they are
    ``np.tensordot(f, irradiance, 1)``, so `irradiance` is also their derivative with respect to f.
    """

    names: Tuple[str, ...]
    irradiance: np.ndarray  #: (L, ..., 3) W/m2 at the points


@dataclasses.dataclass(frozen=True)
class Gradient:
    """A weighted sum of readings, per channel, and its derivatives."""

    reading: np.ndarray  #: (3,) W/m2
    lights: Dict[str, np.ndarray]  #: with respect to the factor of each source, (3,) W/m2
    albedo: Dict[str, np.ndarray]  #: with respect to the albedo of all elements of each material, (3,) W/m2
    element_albedo: np.ndarray  #: (N, 3): with respect to the albedo of each element
    adjoint: np.ndarray  #: (N, 3): effect of light that starts at each element, after all reflections


class Light(Object):
    """The light of a scene, solved on the elements of its operator. Immutable: `relight` returns another one.

    Created by `Scene.solve`, `Light.relight` or `Light.load`. Thread-safe.
    """

    _made_by = "Scene.solve, Light.relight or Light.load"

    #: After `Scene.solve(error=...)`: the certificate of the solution, and why refinement ended; otherwise None.
    certificate: Optional[Certificate] = None
    error_stop: Optional[str] = None

    # ---- creating ----------------------------------------------------------------------------------

    @classmethod
    def _solved(cls, scene: Scene, wishes: Wishes) -> Light:
        if wishes.target is None:
            handle = scene._context.create(lib.rsv_light_create, "rsv_light", lib.rsv_light_destroy, scene._handle,
                                           scene._pointer, wishes.desc)
            return cls(scene._context, handle)
        found, stop = ffi.new("rsv_certificate *"), ffi.new("rsv_error_stop *")

        def solve(light: Any) -> int:
            return lib.rsv_solve_to_error(scene._pointer, wishes.desc, wishes.target, light, found, stop)

        light = cls(scene._context, scene._context.create(solve, "rsv_light", lib.rsv_light_destroy, scene._handle))
        light.certificate, light.error_stop = report(Certificate, found), ERROR_STOPS[stop[0]]
        return light

    @classmethod
    def load(cls, path: Path, context: Optional[Context] = None) -> Light:
        """Reads an operator file from `Light.save` or ``resolvent solve``: scene, operator and solution."""
        context, name = context or default_context(), file_name("path", path)
        pointer_of_context, out = context._handle.pointer, ffi.new("rsv_light **")

        def load(scene: Any) -> int:
            return lib.rsv_light_load(pointer_of_context, name, scene, out)

        scene = context.create(load, "rsv_scene", lib.rsv_scene_destroy, None)
        light = cls(context, Handle(out[0], lib.rsv_light_destroy, scene))
        scene.release()  # held by the light
        return light

    def save(self, path: Path, name: Optional[str] = None) -> None:
        """Writes an operator file (docs/operator-files.md). `name` is the name of the scene in it."""
        scene_name = ffi.NULL if name is None else text("name", name)
        self._context.call(lib.rsv_light_save, self._pointer, scene_name, file_name("path", path))

    def copy(self) -> Light:
        """Another light of the same operator. It needs memory only for fields."""
        handle = self._context.create(lib.rsv_light_copy, "rsv_light", lib.rsv_light_destroy, self._handle.parent,
                                      self._pointer)
        return Light(self._context, handle)

    # ---- properties --------------------------------------------------------------------------------

    def __repr__(self) -> str:
        return f"<resolvent.Light: {self.report.elements} elements, mean {self.report.mean_irradiance:.4g} W/m2>"

    @property
    def report(self) -> SolveReport:
        """Result and accuracy of the solve."""
        return solve_report(lib.rsv_light_report(self._pointer))

    @property
    def scene(self) -> Scene:
        """The scene of this light, with the strengths, colours and positions that it was relit with."""
        return Scene(self._context, self._borrow_scene())

    @functools.cached_property
    def operator(self) -> Operator:
        """The light-transport operator G K, which relit lights share."""
        retained = lib.rsv_operator_retain(lib.rsv_light_operator(self._pointer))
        # of the light's colours, whose scene the light holds
        handle = Handle(retained, lib.rsv_operator_release, self._handle)
        return Operator(self._context, handle, Scene(self._context, self._borrow_scene()))

    def _borrow_scene(self) -> Handle:
        borrowed = ffi.cast("rsv_scene *", lib.rsv_light_scene(self._pointer))
        return Handle(borrowed, lambda pointer: None, self._handle)

    def _field(self, field: Any) -> np.ndarray:
        elements = lib.rsv_operator_element_count(lib.rsv_light_operator(self._pointer))
        return copy_of(field, (elements, 3), np.float32)

    @property
    def source_field(self) -> np.ndarray:
        """E0, (N, 3) float32, W/m2: direct light at the elements."""
        return self._field(lib.rsv_light_source_field(self._pointer))

    @property
    def irradiance_field(self) -> np.ndarray:
        """E = E0 + G K E, (N, 3) float32, W/m2, on the elements."""
        return self._field(lib.rsv_light_irradiance_field(self._pointer))

    @property
    def order_count(self) -> int:
        """Number of orders that are kept separately: 0 is direct light, n has been reflected n times."""
        return lib.rsv_light_order_count(self._pointer)

    # ---- readings and pictures ---------------------------------------------------------------------

    @overload
    def irradiance(self, points: ArrayLike, normals: ArrayLike, mode: str = "lookup", *, samples: int = 4096,
                   seed: int = 0, return_error: Literal[False] = False) -> np.ndarray: ...

    @overload
    def irradiance(self, points: ArrayLike, normals: ArrayLike, mode: str = "lookup", *, samples: int = 4096,
                   seed: int = 0, return_error: Literal[True]) -> Tuple[np.ndarray, np.ndarray]: ...

    def irradiance(self, points: ArrayLike, normals: ArrayLike, mode: str = "lookup", *, samples: int = 4096,
                   seed: int = 0, return_error: bool = False) -> Any:
        """Irradiance at virtual receivers, which cast no shadow.

        Parameters
        ----------
        points, normals : (..., 3), broadcast against each other; metres; normals of any length. A point on a surface
            belongs to the side that its normal points to.
        mode : "lookup", the stored solution at the nearest surface point; "operator", one gather of rays through the
            solution, with direct light sampled; "reference", path traced
        samples : rays or paths per point; not for "lookup"
        return_error : also return the standard error

        Returns
        -------
        (..., 3) float32, W/m2; with `return_error` a tuple (irradiance, standard error).
        """
        given, shape = probes(points, normals, self.scene.origin)
        readings = np.empty((len(given), 6), np.float32)
        desc = ffi.new("rsv_probe_desc *", lib.rsv_default_probe_desc())
        desc.mode, desc.seed = choice("mode", mode, PROBE_MODES), count("seed", seed)
        desc.samples = count("samples", samples, least=1)
        self._context.call(lib.rsv_probe_irradiance, self._pointer, desc, pointer("rsv_probe", given), len(given),
                           pointer("rsv_probe_reading", readings))
        return split_readings(readings, shape, return_error)

    @overload
    def render(self, camera: Any = None, *, mode: str = "final", width: Optional[int] = None,
               height: Optional[int] = None, error: Optional[float] = None, max_time: Optional[float] = None,
               samples: Optional[int] = None, noise: float = 0.0, gather_rays: int = 0, gloss: str = "paths",
               layers: Literal[False] = False, seed: int = 0, path_depth: int = 64) -> np.ndarray: ...

    @overload
    def render(self, camera: Any = None, *, mode: str = "final", width: Optional[int] = None,
               height: Optional[int] = None, error: Optional[float] = None, max_time: Optional[float] = None,
               samples: Optional[int] = None, noise: float = 0.0, gather_rays: int = 0, gloss: str = "paths",
               layers: Literal[True], seed: int = 0, path_depth: int = 64) -> Layered: ...

    def render(self, camera: Any = None, *, mode: str = "final", width: Optional[int] = None,
               height: Optional[int] = None, error: Optional[float] = None, max_time: Optional[float] = None,
               samples: Optional[int] = None, noise: float = 0.0, gather_rays: int = 0, gloss: str = "paths",
               layers: bool = False, seed: int = 0, path_depth: int = 64) -> Any:
        """Renders a picture.

        Parameters
        ----------
        camera : a Camera, or the name or index of a camera of the scene; None = the first
        mode : "final", direct light per pixel; "operator", all light looked up; "reference", path traced
        width, height : pixels; what is missing follows from the camera's aspect, with a longer side of 512
        error : mode "final": target RMS error of pixels, relative to the pixels around them, 0.005..1. Default 0.07,
            unless `samples`, `noise` or `gather_rays` is given. The solution is not changed.
        max_time : mode "final": the best picture possible in this many seconds, stopping early if `error` is reached
        samples : camera rays per pixel instead; modes "operator" and "reference": default 9 and 64
        noise : target standard error of a pixel, relative to the pixels around it; 0 = `samples` everywhere
        gather_rays : mode "final": gather rays per camera ray; 0 = look up indirect light
        gloss : mode "operator": reflections of rough surfaces by "paths", or "reused" among neighbouring pixels (fast,
            slightly biased)

        Returns
        -------
        (height, width, 3) float32, W/(sr m2), row 0 on top; with `layers` a tuple of this and a dict of pictures by
        order of reflection: "emission", "direct", "bounce1", ...
        """
        scene, asked = self.scene, error is not None or max_time is not None
        fixed = samples is not None or noise or gather_rays
        if asked and (mode != "final" or fixed):
            raise ValueError("error, max_time: they choose the samples of mode final; leave out mode, samples, noise and "
                             "gather_rays, or both of them")
        if mode == "reference":
            kind: Any = layers
            return scene.reference(camera, width=width, height=height, samples=64 if samples is None else samples,
                                   layers=kind, seed=seed, path_depth=path_depth)
        desc, keep = render_desc(scene, mode, camera, (width, height), samples=9 if samples is None else samples,
                                 noise=noise, gather_rays=gather_rays, layers=layers, seed=seed, path_depth=path_depth)
        if mode == "operator":
            call = (lib.rsv_render_operator, self._pointer, desc, choice("gloss", gloss, GLOSSES))
        elif fixed or (scene._has_fog and not asked):
            call = (lib.rsv_render, self._pointer, desc)
        else:
            call = (render_planned, scene._pointer, self._pointer, plan_desc(error, max_time), desc)
        handle = self._context.create(call[0], "rsv_image", lib.rsv_image_destroy, None, *call[1:])
        del keep
        return rendered(handle, layers)

    def bake(self, path: Path, target: str = "vertex", **options: Any) -> BakeReport:
        """Bakes the light into a copy of the scene's glTF file (docs/bake.md).

        `target` is "vertex", "lightmap" or "probes"; `options` are fields of rsv_bake_desc (bake.h): tolerance, unlit,
        density, map_size, padding, keep_uv, directional, basis, turns, probe_spacing, ...
        """
        desc, result = ffi.new("rsv_bake_desc *", lib.rsv_default_bake_desc()), ffi.new("rsv_bake_report *")
        known = [name for name, _ in ffi.typeof("rsv_bake_desc").fields if name != "size"]
        for name, value in options.items():
            if name not in known:
                raise TypeError(f"bake: there is no option '{name}'; there are {', '.join(sorted(known))}")
            old = getattr(desc, name)
            setattr(desc, name, bool(value) if isinstance(old, bool) else
                    count(name, value) if isinstance(old, int) else number(name, value))
        choice("target", target, names_of(lib.rsv_bake_target_names()))
        self._context.call(lib.rsv_bake, self._pointer, text("target", target), file_name("path", path), desc, result)
        return report(BakeReport, result)

    # ---- errors ------------------------------------------------------------------------------------

    def certify(self, *, samples: int = 2048, gather_rays: int = 512, light_samples: int = 64,
                seed: int = 0) -> Certificate:
        """The error of the solution, from its residual at random points on surfaces (docs/certificate.md)."""
        result = ffi.new("rsv_certificate *")
        desc = _certify_desc(samples, gather_rays, light_samples, seed)
        self._context.call(lib.rsv_certify, self._pointer, desc, result)
        return report(Certificate, result)

    def certify_goal(self, goal: Any = None, *, samples: int = 2048, gather_rays: int = 512, light_samples: int = 64,
                     seed: int = 0) -> GoalCertificate:
        """The error of the mean reading of a camera (name or index; None = the first) or of (points, normals)."""
        result = ffi.new("rsv_goal_certificate *")
        desc = _certify_desc(samples, gather_rays, light_samples, seed)
        if isinstance(goal, (tuple, list)):
            if len(goal) != 2:
                raise TypeError("goal: expected a camera's name or index, or (points, normals)")
            given, _ = probes(goal[0], goal[1], self.scene.origin)
            self._context.call(lib.rsv_certify_points, self._pointer, desc, pointer("rsv_probe", given), len(given),
                               result)
        else:
            self._context.call(lib.rsv_certify_goal, self._pointer, desc, camera_of(self.scene, goal), result)
        return report(GoalCertificate, result)

    # ---- other lights ------------------------------------------------------------------------------

    def relight(self, lights: Optional[Mapping[str, Rgb]] = None, albedo: Optional[Mapping[str, Rgb]] = None,
                move: Optional[Mapping[str, Vec3]] = None, env_rotation: Optional[float] = None) -> Light:
        """Returns the light with other strengths and colours. No rays are traced for the operator.

        Parameters
        ----------
        lights : factors of the strengths of sources, by name: of punctual lights, the nodes that placed them, emissive
            materials, and "environment"; one number or RGB, 0..1e6
        albedo : base colours, 0..1, of diffuse, opaque materials without textures
        move : metres by which to move sources
        env_rotation : rotation of the environment about +y, degrees, counter-clockwise from above

        Returns
        -------
        A new Light; this one is not changed. Raises UnsupportedError if a change needs a new solve.
        """
        desc = _RelightDesc(lights or {}, albedo or {}, move or {}, env_rotation)
        changed = self.copy()
        self._context.call(lib.rsv_light_relight, changed._pointer, desc.struct)
        return changed

    @functools.cached_property
    def sources(self) -> Tuple[Source, ...]:
        """The sources, as `relight` names them."""
        return _sources(self._relighter()[0], self.scene.origin)

    def _relighter(self) -> Tuple[_Owned, Light]:
        """A relighter on a copy, and the copy, which must outlive it."""
        copy = self.copy()
        handle = self._context.create(lib.rsv_relighter_create, "rsv_relighter", lib.rsv_relighter_destroy,
                                      copy._handle, copy._pointer)
        return _Owned(handle), copy

    def _one_by_one(self, settle: bool) -> Iterator[Tuple[str, Light]]:
        """Yields each source's name and a light with that source alone: solved with `settle`, otherwise only E0."""
        owned, copy = self._relighter()
        names = list(dict.fromkeys(source.name for source in _sources(owned, np.zeros(3))))
        for name in names:
            factors = {other: float(other == name) for other in names}
            desc = _RelightDesc(factors, {}, {}, None)
            self._context.call(lib.rsv_relighter_change, owned.handle.pointer, desc.struct)
            if settle:
                self._context.call(lib.rsv_relighter_settle, owned.handle.pointer)
            yield name, copy

    def basis(self, points: ArrayLike, normals: ArrayLike, mode: str = "lookup", *, samples: int = 4096,
              seed: int = 0) -> Basis:
        """The contribution of each source to readings: their derivatives with respect to strengths.

        Takes the arguments of `irradiance`. Solves once for each source, without tracing rays for the operator.
        """
        names, readings = [], []
        for name, alone in self._one_by_one(settle=True):
            names.append(name)
            readings.append(alone.irradiance(points, normals, mode, samples=samples, seed=seed))
        _, shape = probes(points, normals, np.zeros(3))
        stacked = np.stack(readings) if readings else np.zeros((0,) + shape + (3,), np.float32)
        return Basis(tuple(names), stacked)

    def gradient(self, points: ArrayLike, normals: ArrayLike, weights: Optional[ArrayLike] = None) -> Gradient:
        """Derivatives of a weighted sum of readings, by one adjoint solution for any number of parameters.

        The readings are those of the elements,
        ``light.operator.interpolation(points, normals) @ light.irradiance_field``.

        Parameters
        ----------
        points, normals : (..., 3) as in `irradiance`
        weights : (...) weights of the sum; None = the mean
        """
        w = self.operator.interpolation(points, normals)
        if weights is None:
            factors = np.full(w.shape[0], 1.0 / max(1, w.shape[0]))
        else:
            _, shape = probes(points, normals, np.zeros(3))
            factors = floats("weights", np.broadcast_to(real("weights", weights), shape), shape)
        importance = np.repeat((w.T @ factors.ravel())[:, np.newaxis], 3, axis=1)
        irradiance = self.irradiance_field.astype(np.float64)
        adjoint = self.operator.solve_adjoint(importance)
        by_element = self.operator.albedo_gradient(irradiance, adjoint)
        material = self.operator.materials
        names = [m.name for m in self.scene.materials]
        by_material: Dict[str, np.ndarray] = {}
        for k in np.unique(material):
            by_material[names[k]] = by_material.get(names[k], 0) + by_element[material == k].sum(axis=0)
        lights = {name: (adjoint * alone.source_field).sum(axis=0) for name, alone in self._one_by_one(settle=False)}
        return Gradient((importance * irradiance).sum(axis=0), lights, by_material, by_element, adjoint)


class _Owned:
    """Releases a handle when it is destroyed."""

    def __init__(self, handle: Handle):
        self.handle = handle

    def __del__(self) -> None:
        self.handle.release()


def _sources(owned: _Owned, origin: np.ndarray) -> Tuple[Source, ...]:
    found: List[Source] = []
    for k in range(lib.rsv_relighter_source_count(owned.handle.pointer)):
        s = lib.rsv_relighter_source(owned.handle.pointer, k)
        place = np.array([s.position.x, s.position.y, s.position.z]) + origin
        node = None if s.node == ffi.NULL else ffi.string(s.node).decode("utf-8", "replace")
        found.append(Source(ffi.string(s.name).decode("utf-8", "replace"), (s.strength.r, s.strength.g, s.strength.b),
                            (float(place[0]), float(place[1]), float(place[2])), bool(s.movable), node))
    return tuple(found)


def _certify_desc(samples: int, gather_rays: int, light_samples: int, seed: int) -> Any:
    desc = ffi.new("rsv_certify_desc *", lib.rsv_default_certify_desc())
    desc.samples, desc.gather_rays = count("samples", samples), count("gather_rays", gather_rays)
    desc.light_samples, desc.seed = count("light_samples", light_samples), count("seed", seed)
    return desc


class _RelightDesc:
    """An rsv_relight_desc, and the objects that it borrows."""

    def __init__(self, lights: Mapping[str, Rgb], albedo: Mapping[str, Rgb], move: Mapping[str, Vec3],
                 env_rotation: Optional[float]):
        self.struct = ffi.new("rsv_relight_desc *", lib.rsv_default_relight_desc())
        self._keep: List[Any] = []
        self._set("light", "rsv_light_scale", self._items("lights", lights, rgb))
        self._set("albedo", "rsv_albedo_change", self._items("albedo", albedo, rgb))
        self._set("move", "rsv_light_move", self._items("move", move, vec3))
        if env_rotation is not None:
            self.struct.turn, self.struct.rotation = True, number("env_rotation", env_rotation)

    def _items(self, argument: str, given: Mapping[str, Any], convert: Any) -> List[Any]:
        if not isinstance(given, Mapping):
            raise TypeError(f"{argument}: {type(given).__name__} is not a dict of names")
        items = []
        for name, value in given.items():
            self._keep.append(ffi.new("char[]", text(argument, name)))
            items.append((self._keep[-1], convert(f"{argument}['{name}']", value)))
        return items

    def _set(self, field: str, kind: str, items: List[Any]) -> None:
        array = ffi.new(kind + "[]", items)
        self._keep.append(array)
        setattr(self.struct, field, array)
        setattr(self.struct, field + "_count", len(items))
