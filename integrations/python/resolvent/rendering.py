"""Options of pictures, and their results."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple, Union

import numpy as np

from ._native import ffi, lib
from .arrays import choice, number
from .context import Handle, count
from .images import layers_of, pixels_of
from .things import Camera, text

if TYPE_CHECKING:
    from .scene import Scene

MODES = ("operator", "final", "reference")
GLOSSES = ("paths", "reused")
LONGER_SIDE = 512
#: With layers=True: the picture, and its layers by name.
Layered = Tuple[np.ndarray, Dict[str, np.ndarray]]


def camera_of(scene: Scene, camera: Any) -> int:
    """Index of a camera of the scene, by name or index; None = the first."""
    view = lib.rsv_scene_get_view(scene._pointer)
    if camera is None:
        return 0
    if isinstance(camera, str):
        index = lib.rsv_scene_find_camera(scene._pointer, text("camera", camera))
        if index == lib.RSV_NONE:
            names = [ffi.string(view.camera[k].name).decode("utf-8", "replace") for k in range(view.camera_count)]
            raise ValueError(f"camera: there is no '{camera}'; there are {', '.join(names)}")
        return index
    return count("camera", camera, view.camera_count - 1)


def _size(aspect: float, size: Tuple[Optional[int], Optional[int]]) -> Tuple[int, int]:
    """Width and height; what is missing follows from the camera's aspect."""
    width, height = size
    aspect = aspect if aspect > 0 else 1.0
    if width is None and height is None:
        width, height = (LONGER_SIDE, None) if aspect >= 1 else (None, LONGER_SIDE)
    if width is None:
        width = max(1, round(count("height", height, 32768, 1) * aspect))
    if height is None:
        height = max(1, round(count("width", width, 32768, 1) / aspect))
    return count("width", width, 32768, 1), count("height", height, 32768, 1)


def render_desc(scene: Scene, mode: str, camera: Any, size: Tuple[Optional[int], Optional[int]],
                **fields: Any) -> Tuple[Any, List[Any]]:
    """An rsv_render_desc, and the objects that it borrows."""
    keep: List[Any] = []
    desc = ffi.new("rsv_render_desc *", lib.rsv_default_render_desc())
    desc.mode = choice("mode", mode, MODES)
    if isinstance(camera, Camera):
        desc.viewpoint = camera._described(keep, scene.origin)
        keep.append(desc.viewpoint)
        aspect = camera.aspect
    else:
        desc.camera = camera_of(scene, camera)
        aspect = lib.rsv_scene_get_view(scene._pointer).camera[desc.camera].aspect
    desc.width, desc.height = _size(aspect, size)
    for name, value in fields.items():
        if name == "layers":
            desc.layers = bool(value)
        elif name == "noise":
            desc.noise = number(name, value)
        else:
            setattr(desc, name, count(name, value, 1 << 24 if name != "seed" else 2**32 - 1, int(name == "samples")))
    return desc, keep


def plan_desc(error: Optional[float], max_time: Optional[float]) -> Any:
    """An rsv_plan_desc. With only `max_time`: as good as time permits."""
    desc = ffi.new("rsv_plan_desc *", lib.rsv_default_plan_desc())
    if error is not None:
        desc.relative_error = number("error", error)
        if desc.relative_error <= 0:
            raise ValueError(f"error: {error} is not above 0")
    elif max_time is not None:
        desc.relative_error = 0
    desc.max_seconds = math.inf if max_time is None else number("max_time", max_time)
    return desc


def render_planned(scene: Any, light: Any, plan: Any, desc: Any, image: Any) -> int:
    """Renders a planned picture. `light` stays alive; NULL = the plan solves its own."""
    used = ffi.new("rsv_light **", light)
    status = lib.rsv_render_planned(scene, plan, desc, used, image, ffi.NULL)
    if light == ffi.NULL and status == lib.RSV_OK:
        lib.rsv_light_destroy(used[0])
    return status


def rendered(handle: Handle, layers: bool) -> Union[np.ndarray, Layered]:
    """Arrays of an image. Releases the image."""
    try:
        return (pixels_of(handle, 0), layers_of(handle)) if layers else pixels_of(handle, 0)
    finally:
        handle.release()
