"""Options of a solve."""
from __future__ import annotations

import numbers
from typing import TYPE_CHECKING, Any, Dict, List, Optional

from ._native import ffi, lib
from .arrays import choice, number, pointer, probes
from .context import count, names_of
from .images import file_name
from .rendering import camera_of

if TYPE_CHECKING:
    from .scene import Scene

QUALITIES = ("draft", "medium", "high")
COUNTS = ("element_target", "rays_per_element", "refinements", "light_samples", "photon_count", "direct_levels",
          "max_orders", "seed")
SIZES = ("max_elements", "max_bytes")
NUMBERS = ("tolerance", "contact_share")
FOLDERS = ("checkpoint", "earlier")
TARGETS = ("max_seconds", "max_rounds")


class Wishes:
    """An rsv_solve_desc, the objects that it borrows, and the target error."""

    def __init__(self, scene: Scene, quality: str, goal: Any, error: Optional[float], options: Dict[str, Any]):
        self.keep: List[Any] = []
        self.desc = ffi.new("rsv_solve_desc *",
                            lib.rsv_default_solve_desc(choice("quality", quality, QUALITIES)))
        self.target = None
        if error is not None:
            self.target = ffi.new("rsv_error_target *", lib.rsv_default_error_target(number("error", error)))
        for name, value in options.items():
            self._set(name, value)
        if goal is not None:
            self._aim(scene, goal)

    def _set(self, name: str, value: Any) -> None:
        if name in COUNTS:
            setattr(self.desc, name, count(name, value))
        elif name in SIZES:
            setattr(self.desc, name, count(name, value, 2**63))
            if self.target is not None and name == "max_elements":
                self.target.max_elements = count(name, value, 2**63)
        elif name in NUMBERS:
            setattr(self.desc, name, number(name, value))
        elif name in FOLDERS:
            self.keep.append(ffi.new("char[]", file_name(name, value)))
            setattr(self.desc, name, self.keep[-1])
        elif name == "direct_level":
            self.desc.direct_level = bool(value)
        elif name == "solver":
            self.desc.solver = choice(name, value, names_of(lib.rsv_solver_names()))
        elif name in TARGETS and self.target is not None:
            value = number(name, value) if name == "max_seconds" else count(name, value, least=1)
            setattr(self.target, name, value)
        else:
            self._refuse(name)

    def _refuse(self, name: str) -> None:
        if name in TARGETS:
            raise TypeError(f"solve: {name} requires `error`")
        known = sorted((*COUNTS, *SIZES, *NUMBERS, *FOLDERS, *TARGETS, "direct_level", "solver"))
        raise TypeError(f"solve: there is no option '{name}'; there are {', '.join(known)}")

    def _aim(self, scene: Scene, goal: Any) -> None:
        if isinstance(goal, (str, numbers.Integral)):
            self.desc.goal_camera = camera_of(scene, goal)
            return
        if not isinstance(goal, (tuple, list)) or len(goal) != 2:
            raise TypeError("goal: expected a camera's name or index, or (points, normals)")
        given, _ = probes(goal[0], goal[1], scene.origin)
        if not len(given):
            raise ValueError("goal: there are no points")
        self.keep.append(given)
        self.desc.goal_points, self.desc.goal_point_count = pointer("rsv_probe", given), len(given)
