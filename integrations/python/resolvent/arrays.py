"""Converts arguments to arrays for the library (C order, float32, finite), or raises an exception that names the
argument."""
from __future__ import annotations

from typing import Any, Optional, Sequence, Tuple, Union

import numpy as np

from ._native import ffi

ArrayLike = Any


def real(name: str, value: ArrayLike) -> np.ndarray:
    """An array of real numbers, of any shape, dtype and order."""
    if value is None:
        raise TypeError(f"{name}: None is not an array")
    try:
        array = np.asarray(value)
    except ValueError as error:  # rows of unequal length
        raise ValueError(f"{name}: {error}") from None
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name}: dtype {array.dtype}; expected real numbers")
    return array


def check_finite(name: str, array: np.ndarray) -> None:
    """Raises ValueError, with the position, if anything is infinite or NaN."""
    finite = np.isfinite(array)
    if not finite.all():
        where = tuple(int(k) for k in np.argwhere(~finite)[0])
        raise ValueError(f"{name}{list(where)} is {array[where]}; expected finite numbers")


def _shape_text(shape: Sequence[Union[int, str]]) -> str:
    return "(" + ", ".join(str(s) for s in shape) + ("," if len(shape) == 1 else "") + ")"


def check_shape(name: str, array: np.ndarray, shape: Sequence[Union[int, str]]) -> None:
    """Raises ValueError unless the shape matches; names stand for any length."""
    fits = array.ndim == len(shape) and all(isinstance(s, str) or s == n for s, n in zip(shape, array.shape))
    if not fits:
        raise ValueError(f"{name}: shape {array.shape}; expected {_shape_text(shape)}")


def floats(name: str, value: ArrayLike, shape: Sequence[Union[int, str]]) -> np.ndarray:
    """Finite float32 in C order with that shape; copied if necessary."""
    array = real(name, value)
    check_shape(name, array, shape)
    with np.errstate(over="ignore"):
        result = np.ascontiguousarray(array, dtype=np.float32)
    check_finite(name, result)
    return result.reshape(array.shape)  # ascontiguousarray makes one dimension of none


def indices(name: str, value: ArrayLike, shape: Sequence[Union[int, str]], end: int) -> np.ndarray:
    """uint32 in C order, each below `end`."""
    array = real(name, value)
    check_shape(name, array, shape)
    if array.dtype.kind == "f" and array.size:
        raise TypeError(f"{name}: dtype {array.dtype}; expected integers")
    if array.size and (int(array.min()) < 0 or int(array.max()) >= end):
        outside = (array < 0) | (array >= end)
        where = tuple(int(k) for k in np.argwhere(outside)[0])
        raise ValueError(f"{name}{list(where)} is {array[where]}; expected 0..{end - 1}")
    return np.ascontiguousarray(array, dtype=np.uint32)


def rgb(name: str, value: ArrayLike) -> Tuple[float, float, float]:
    """Three finite numbers; one stands for all three."""
    array = real(name, value)
    if array.ndim == 0:
        array = np.broadcast_to(array, (3,))
    result = floats(name, array, (3,))
    return float(result[0]), float(result[1]), float(result[2])


def number(name: str, value: Any) -> float:
    """One finite number."""
    return float(floats(name, value, ()))


def choice(name: str, value: Any, choices: Sequence[str]) -> int:
    """The index of a name in `choices`."""
    if not isinstance(value, str):
        raise TypeError(f"{name}: {type(value).__name__} is not a name; there are {', '.join(choices)}")
    if value not in choices:
        raise ValueError(f"{name}: there is no '{value}'; there are {', '.join(choices)}")
    return choices.index(value)


def probes(points: ArrayLike, normals: ArrayLike, origin: np.ndarray) -> Tuple[np.ndarray, Tuple[int, ...]]:
    """Points and normals side by side, (N, 6) float32, and their common shape without the last axis."""
    p, n = real("points", points), real("normals", normals)
    for name, array in (("points", p), ("normals", n)):
        if array.size == 0 and array.ndim == 1:
            raise ValueError(f"{name}: shape {array.shape}; expected (..., 3), and (0, 3) where there are none")
        if array.ndim == 0 or array.shape[-1] != 3:
            raise ValueError(f"{name}: shape {array.shape}; expected (..., 3)")
    try:
        shape = np.broadcast_shapes(p.shape, n.shape) if hasattr(np, "broadcast_shapes") else np.broadcast(p, n).shape
    except ValueError:
        raise ValueError(f"points and normals: shapes {p.shape} and {n.shape} do not go together") from None
    both = np.empty(shape[:-1] + (6,), dtype=np.float32)
    with np.errstate(over="ignore"):
        both[..., :3] = p - origin if origin.any() else p
        both[..., 3:] = n
    if not np.isfinite(both).all():
        check_finite("points", both[..., :3])
        check_finite("normals", both[..., 3:])
    flat = both.reshape(-1, 6)
    zero = (flat[:, 3] == 0) & (flat[:, 4] == 0) & (flat[:, 5] == 0)  # any(axis=1) takes several times as long
    if zero.any():
        raise ValueError(f"normals: number {int(np.argmax(zero))} is zero; expected a direction")
    return flat, shape[:-1]


def pointer(kind: str, array: Optional[np.ndarray]) -> Any:
    """The array's memory as `kind *`; the array must outlive the use."""
    return ffi.NULL if array is None else ffi.cast(kind + " *", array.ctypes.data)


def copy_of(address: Any, shape: Tuple[int, ...], dtype: Any) -> np.ndarray:
    """A copy of C memory."""
    result = np.empty(shape, dtype)
    if result.nbytes:
        ffi.memmove(ffi.cast("void *", result.ctypes.data), address, result.nbytes)
    return result
