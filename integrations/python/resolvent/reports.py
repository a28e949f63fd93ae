"""Reports, as frozen dataclasses with the names of the C structures."""
from __future__ import annotations

import dataclasses
from typing import Any, Tuple, Type, TypeVar

from ._native import ffi, lib

STOP_REASONS = ("converged", "max orders", "no light", "stagnated", "diverged", "breakdown")
ERROR_STOPS = ("target reached", "max elements", "max seconds", "max rounds", "stalled")
T = TypeVar("T")


def _plain(value: Any) -> Any:
    if not isinstance(value, ffi.CData):
        return value
    if ffi.typeof(value).item is ffi.typeof("char"):
        return ffi.string(value).decode()
    return tuple(value)


def report(kind: Type[T], struct: Any, **known: Any) -> T:
    """A dataclass with the fields of a C structure that have the same names."""
    names = [f.name for f in dataclasses.fields(kind)]
    return kind(**{n: known[n] if n in known else _plain(getattr(struct, n)) for n in names})


@dataclasses.dataclass(frozen=True)
class SolveReport:
    """Result and accuracy of a solve; rsv_solve_report in solve.h has details. Times are in seconds."""

    stop_reason: str  #: "converged", "max orders", "no light", "stagnated", "diverged" or "breakdown"
    elements: int  #: coarse elements: unknowns of the linear system
    direct_elements: int  #: elements of the direct and caustic levels
    rows: int  #: coarse elements with a row of their own
    entries: int  #: stored entries of G
    bytes: int  #: memory of elements, G and K
    rays: int  #: traced during assembly
    iterations: int  #: applications of G K
    solver: str
    solver_reason: str
    norm_inf: float  #: largest row sum of G K over rows and channels
    spectral_radius: float  #: of G K
    residual_inf: float  #: largest ``|E0 + G K E - E|``, W/m2
    truncation_bound: float  #: W/m2
    mean_irradiance: float  #: area-weighted mean luminance of E, W/m2
    time_bvh: float
    time_assemble: float
    time_solve: float


@dataclasses.dataclass(frozen=True)
class Certificate:
    """The error of a solution: luminance of irradiance, W/m2, root mean square over all surfaces
    (docs/certificate.md)."""

    samples: int  #: points that count
    residual_rms: float
    residual_ci95: Tuple[float, float]  #: 95 % confidence interval
    error_bound_rms: float
    error_estimate_rms: float
    error_estimate_ci95: Tuple[float, float]
    residual_direct_rms: float
    residual_gathered_rms: float
    irradiance_rms: float  #: of the solution; divide the others by it for relative errors
    max_albedo: float
    medium_factor: float
    amplification: float
    rays: int
    seconds: float

    @property
    def relative_error(self) -> float:
        """Estimated error / irradiance; 0 if there is no irradiance."""
        return self.error_estimate_rms / self.irradiance_rms if self.irradiance_rms > 0 else 0.0


@dataclasses.dataclass(frozen=True)
class GoalCertificate:
    """The error of the mean luminance that a camera or sensors read, W/(sr m2) or W/m2."""

    reading: float
    error: float  #: estimate of the true reading minus `reading`
    error_ci95: Tuple[float, float]


@dataclasses.dataclass(frozen=True)
class BakeReport:
    """Result of a bake; rsv_bake_report in bake.h has details."""

    vertices: int
    triangles: int
    input_triangles: int
    charts: int
    map_width: int
    map_height: int
    density: float  #: texels per metre
    coverage: float
    largest_seam: float
    probe_count: Tuple[int, int, int]
    valid_probes: int
    light_scale: float  #: radiance of a white surface that 1 stands for in the file, W/(m2 sr)
    lights: int


def solve_report(struct: Any) -> SolveReport:
    solver = ffi.string(lib.rsv_solver_name(struct.solver)).decode()
    return report(SolveReport, struct, stop_reason=STOP_REASONS[struct.stop_reason], solver=solver)
