"""Solved light: read, rendered, relit, certified, differentiated, saved."""
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
    """Something that shines, and that `Light.relight` knows by its name."""

    name: str
    strength: Tuple[float, float, float]  #: a lamp's radiance, a light's intensity, of the surroundings 1
    position: Tuple[float, float, float]  #: metres
    movable: bool
    node: Optional[str]  #: that placed a light, where several share a name


@dataclasses.dataclass(frozen=True)
class Basis:
    """What each source does by itself, with all that follows of it.

    Readings are linear in the strengths: of sources with the factors f they are ``np.tensordot(f, irradiance, 1)``; so
    `irradiance` is the derivative of the readings with respect to the factors, too.
    """

    names: Tuple[str, ...]
    irradiance: np.ndarray  #: (L, ..., 3) W/m2 at the points


@dataclasses.dataclass(frozen=True)
class Gradient:
    """A weighted sum of readings, channel by channel, and its derivatives."""

    reading: np.ndarray  #: (3,) W/m2
    lights: Dict[str, np.ndarray]  #: by source: with respect to the factor of its strength, (3,) W/m2
    albedo: Dict[str, np.ndarray]  #: by material: with respect to the albedo of all its elements, (3,) W/m2
    element_albedo: np.ndarray  #: (N, 3): with respect to the albedo of each element
    adjoint: np.ndarray  #: (N, 3): what light that starts at each element counts for, after all reflections


class Light(Object):
    """The light of a scene, solved on the elements of its operator. Constant: relighting makes another one.

    Made by `Scene.solve`, `Light.relight` or `Light.load`. Any number of threads may use it.
    """

    _made_by = "Scene.solve, Light.relight or Light.load"

    #: Of `Scene.solve(error=...)`: the certificate of the solution, and why refining ended; else None.
    certificate: Optional[Certificate] = None
    error_stop: Optional[str] = None

    # ---- making one --------------------------------------------------------------------------------

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
        """Reads what `Light.save`, or ``resolvent solve``, wrote: the scene, the operator and the solution."""
        context, name = context or default_context(), file_name("path", path)
        pointer_of_context, out = context._handle.pointer, ffi.new("rsv_light **")

        def load(scene: Any) -> int:
            return lib.rsv_light_load(pointer_of_context, name, scene, out)

        scene = context.create(load, "rsv_scene", lib.rsv_scene_destroy, None)
        light = cls(context, Handle(out[0], lib.rsv_light_destroy, scene))
        scene.release()  # held by the light
        return light

    def save(self, path: Path, name: Optional[str] = None) -> None:
        """Writes an operator file (docs/operator-files.md). `name` is what it calls the scene."""
        scene_name = ffi.NULL if name is None else text("name", name)
        self._context.call(lib.rsv_light_save, self._pointer, scene_name, file_name("path", path))

    def copy(self) -> Light:
        """Another light of the same operator: costs memory for fields alone."""
        handle = self._context.create(lib.rsv_light_copy, "rsv_light", lib.rsv_light_destroy, self._handle.parent,
                                      self._pointer)
        return Light(self._context, handle)

    # ---- what it is --------------------------------------------------------------------------------

    def __repr__(self) -> str:
        return f"<resolvent.Light: {self.report.elements} elements, mean {self.report.mean_irradiance:.4g} W/m2>"

    @property
    def report(self) -> SolveReport:
        """What the solve did, and how good its answer is."""
        return solve_report(lib.rsv_light_report(self._pointer))

    @property
    def scene(self) -> Scene:
        """The scene as this light has it: with the strengths, colours and places that it was relit with."""
        return Scene(self._context, self._borrow_scene())

    @functools.cached_property
    def operator(self) -> Operator:
        """The light-transport operator G K, which lights that were relit share."""
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
        """E0, (N, 3) float32, W/m2: what arrives at the elements straight from the sources."""
        return self._field(lib.rsv_light_source_field(self._pointer))

    @property
    def irradiance_field(self) -> np.ndarray:
        """E = E0 + G K E, (N, 3) float32, W/m2, on the elements."""
        return self._field(lib.rsv_light_irradiance_field(self._pointer))

    @property
    def order_count(self) -> int:
        """Orders of light that are kept apart: 0 is direct light, n has been reflected n times."""
        return lib.rsv_light_order_count(self._pointer)

    # ---- looking at it -----------------------------------------------------------------------------

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
        points, normals : (..., 3), broadcast against each other; metres; normals need not be unit. A point on a surface
            is taken to be on the side that its normal points to.
        mode : "lookup", the stored solution at the nearest surface point; "operator", one gather of rays through it,
            with direct light sampled; "reference", path traced
        samples : rays or paths per point, but for "lookup"
        return_error : also return the standard error

        Returns
        -------
        (..., 3) float32, W/m2; with `return_error` a tuple of two.
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
        """A picture.

        Parameters
        ----------
        camera : a Camera, or the name or index of one of the scene's; None = its first
        mode : "final", direct light per pixel; "operator", all light looked up; "reference", path traced
        width, height : pixels; what is not given follows from the camera's aspect, 512 the longer side
        error : mode "final": RMS error of pixels that is wanted, relative to what is around them, 0.005 to 1; where
            neither this nor `samples`, `noise` or `gather_rays` says how, 0.07. The solution stays as it is.
        max_time : mode "final": the best picture that so many seconds allow, with `error` no better than that
        samples : camera rays per pixel instead; modes "operator" and "reference": default 9 and 64
        noise : wanted standard error of a pixel as a share of what is around it; 0 = `samples` everywhere
        gather_rays : mode "final": per camera ray; 0 = look the indirect light up
        gloss : mode "operator": what rough surfaces reflect is found by "paths" or "reused" among neighbours (fast, a
            little biased)

        Returns
        -------
        (height, width, 3) float32, W/(sr m2), row 0 on top; with `layers` that, and a dict of the same by order of
        reflection: "emission", "direct", "bounce1", ...
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
        """Writes the light into a copy of the scene's glTF file (docs/bake.md).

        `target` is "vertex", "lightmap" or "probes"; `options` are fields of rsv_bake_desc (bake.h) by name: tolerance,
        unlit, density, map_size, padding, keep_uv, directional, basis, turns, probe_spacing, ...
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

    # ---- how wrong it is ---------------------------------------------------------------------------

    def certify(self, *, samples: int = 2048, gather_rays: int = 512, light_samples: int = 64,
                seed: int = 0) -> Certificate:
        """How wrong the solution is, by its residual at random points of the surfaces (docs/certificate.md)."""
        result = ffi.new("rsv_certificate *")
        desc = _certify_desc(samples, gather_rays, light_samples, seed)
        self._context.call(lib.rsv_certify, self._pointer, desc, result)
        return report(Certificate, result)

    def certify_goal(self, goal: Any = None, *, samples: int = 2048, gather_rays: int = 512, light_samples: int = 64,
                     seed: int = 0) -> GoalCertificate:
        """The error of what a camera (name or index; None = the first) or (points, normals) read, in the mean."""
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
        """The same surfaces under other lights and in other colours. No ray is traced for the operator.

        Parameters
        ----------
        lights : factors of the strengths of sources, by name: of punctual lights or the nodes that placed them, of
            materials that emit, and "environment"; one number or RGB, 0..1e6
        albedo : base colours, 0..1, of materials that are diffuse, opaque and of one colour
        move : metres by which sources move
        env_rotation : degrees to which the surroundings turn about +y, counter-clockwise from above

        Returns
        -------
        Another Light; this one stays as it is. UnsupportedError where a change is beyond relighting: solve again.
        """
        desc = _RelightDesc(lights or {}, albedo or {}, move or {}, env_rotation)
        changed = self.copy()
        self._context.call(lib.rsv_light_relight, changed._pointer, desc.struct)
        return changed

    @functools.cached_property
    def sources(self) -> Tuple[Source, ...]:
        """What shines, as `relight` knows it."""
        return _sources(self._relighter()[0], self.scene.origin)

    def _relighter(self) -> Tuple[_Owned, Light]:
        """One on a copy, which it keeps alive."""
        copy = self.copy()
        handle = self._context.create(lib.rsv_relighter_create, "rsv_relighter", lib.rsv_relighter_destroy,
                                      copy._handle, copy._pointer)
        return _Owned(handle), copy

    def _one_by_one(self, settle: bool) -> Iterator[Tuple[str, Light]]:
        """Yields each source's name, and the light with it alone. With `settle` solved, else with E0 alone."""
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
        """What each source does at points, by itself: the derivatives of readings with respect to strengths.

        Arguments as of `irradiance`. One solve for each source, none of which traces a ray for the operator.
        """
        names, readings = [], []
        for name, alone in self._one_by_one(settle=True):
            names.append(name)
            readings.append(alone.irradiance(points, normals, mode, samples=samples, seed=seed))
        _, shape = probes(points, normals, np.zeros(3))
        stacked = np.stack(readings) if readings else np.zeros((0,) + shape + (3,), np.float32)
        return Basis(tuple(names), stacked)

    def gradient(self, points: ArrayLike, normals: ArrayLike, weights: Optional[ArrayLike] = None) -> Gradient:
        """Derivatives of a weighted sum of readings, by one adjoint solution, however many parameters there are.

        The readings are those of the elements,
        ``light.operator.interpolation(points, normals) @ light.irradiance_field``.

        Parameters
        ----------
        points, normals : (..., 3) as in `irradiance`
        weights : (...) of the sum; None = its mean
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
    """A handle that is released with this."""

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
    """A rsv_relight_desc, and what it borrows."""

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
