"""Pictures as arrays, in files and in the library: (height, width, 3) float32, linear RGB radiance, row 0 on top."""
from __future__ import annotations

import os
from typing import Any, Dict, Optional, Union

import numpy as np

from ._native import ffi, lib
from .arrays import ArrayLike, copy_of, floats, number
from .context import Context, Handle, default_context

Path = Union[str, "os.PathLike[str]"]


def file_name(name: str, path: Path) -> bytes:
    """A path as a C string."""
    if not isinstance(path, (str, os.PathLike)):
        raise TypeError(f"{name}: {type(path).__name__} is not a path")
    encoded = os.fsencode(path)
    if b"\0" in encoded:
        raise ValueError(f"{name}: a path holds no zero")
    return encoded


def pixels_of(handle: Handle, layer: int) -> np.ndarray:
    image = handle.pointer
    shape = (lib.rsv_image_height(image), lib.rsv_image_width(image), 3)
    return copy_of(lib.rsv_image_const_pixels(image, layer), shape, np.float32)


def layers_of(handle: Handle) -> Dict[str, np.ndarray]:
    """All layers except the picture itself, by name."""
    image = handle.pointer
    return {ffi.string(lib.rsv_image_layer_name(image, k)).decode(): pixels_of(handle, k)
            for k in range(1, lib.rsv_image_layer_count(image))}


def read_image(path: Path, context: Optional[Context] = None) -> np.ndarray:
    """Reads .exr, .hdr, .png or .jpg as (height, width, 3) float32; 8-bit formats are decoded from sRGB to linear."""
    context = context or default_context()
    handle = context.create(lib.rsv_image_read, "rsv_image", lib.rsv_image_destroy, None, context._handle.pointer,
                            file_name("path", path))
    try:
        return pixels_of(handle, 0)
    finally:
        handle.release()


def write_image(path: Path, picture: ArrayLike, layers: Optional[Dict[str, ArrayLike]] = None, exposure: float = 0,
                context: Optional[Context] = None) -> None:
    """Writes (height, width, 3) linear RGB by extension: .exr (32-bit float, all layers), .hdr or .png.

    PNG holds sRGB(picture * 2^exposure), clipped. The file appears complete or not at all.
    """
    context = context or default_context()
    named = [("", floats("picture", picture, ("height", "width", 3)))]
    for name, layer in (layers or {}).items():
        named.append((name, floats(f"layers[{name!r}]", layer, named[0][1].shape)))
    height, width = named[0][1].shape[:2]
    stops = number("exposure", exposure)
    encoded = file_name("path", path)
    handle = context.create(lib.rsv_image_create, "rsv_image", lib.rsv_image_destroy, None, context._handle.pointer,
                            width, height, len(named))
    try:
        for k, (name, layer) in enumerate(named):
            _set_layer(context, handle.pointer, k, name, layer)
        context.call(lib.rsv_image_write, handle.pointer, encoded, stops)
    finally:
        handle.release()


def _set_layer(context: Context, image: Any, index: int, name: str, pixels: np.ndarray) -> None:
    ffi.memmove(lib.rsv_image_pixels(image, index), ffi.from_buffer(pixels), pixels.nbytes)
    if index:
        context.call(lib.rsv_image_set_layer_name, image, index, name.encode())
