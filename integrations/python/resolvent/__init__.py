"""Global illumination by solving the light-transport operator.

    import resolvent

    scene = resolvent.Scene.builtin("cornell-spheres")
    light = scene.solve(quality="draft")
    picture = light.render(width=256, height=256)           # (256, 256, 3) float32, linear RGB radiance
    reading = light.irradiance([[0, 0.01, 0]], [[0, 1, 0]])  # (1, 3) float32, W/m2

Units are SI and radiometric: metres, W/m2 (irradiance), W/(sr m2) (radiance), each as linear RGB. Coordinates are
right-handed, y up. docs/python.md is the tour.
"""
from ._native import ffi as _ffi, lib as _lib

if not _lib.rsv_py_runs_here():
    raise ImportError("resolvent: this build needs a CPU with AVX2, FMA and BMI2; build it with -D RSV_AVX2=OFF")

from .context import Context, default_context
from .errors import (ArgumentError, Cancelled, FileError, FormatError, OutOfMemoryError, ResolventError,
                     ResolventWarning, SceneError, UnsupportedError)
from .images import read_image, write_image
from .light import Basis, Gradient, Light
from .transport import Operator
from .photometry import illuminance, luminance
from .reports import BakeReport, Certificate, GoalCertificate, SolveReport
from .scene import Scene
from .things import Camera, Environment, Fog, Material, Mesh, PunctualLight, Texture

__version__ = _ffi.string(_lib.rsv_version()).decode()

__all__ = [
    "ArgumentError", "BakeReport", "Basis", "Camera", "Cancelled", "Certificate", "Context", "Environment", "FileError",
    "Fog", "FormatError", "GoalCertificate", "Gradient", "Light", "Material", "Mesh", "Operator", "OutOfMemoryError",
    "PunctualLight", "ResolventError", "ResolventWarning", "Scene", "SceneError", "SolveReport", "Texture",
    "UnsupportedError", "default_context", "illuminance", "luminance", "read_image", "write_image",
]
