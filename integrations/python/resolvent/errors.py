"""Exceptions. Each is also a subclass of the matching built-in exception."""
from __future__ import annotations

from ._native import ffi, lib


class ResolventError(Exception):
    """Base of this package's exceptions, except TypeError and ValueError for wrong arguments."""


class ArgumentError(ResolventError, ValueError):
    """The library refused an argument. The message says which one, and what to do."""


class FileError(ResolventError, OSError):
    """A file cannot be opened, read or written."""


class FormatError(ResolventError, ValueError):
    """The content of a file or array is malformed."""


class UnsupportedError(ResolventError, NotImplementedError):
    """Valid, but not supported."""


class SceneError(ResolventError, ValueError):
    """The scene has no bounded or meaningful solution."""


class OutOfMemoryError(ResolventError, MemoryError):
    """Out of memory."""


class Cancelled(ResolventError):
    """Stopped by Context.cancel, or because the progress function returned False."""


class ResolventWarning(UserWarning):
    """A warning of the library: parts of a file that are ignored, light that could not be checked, ..."""


_OF_STATUS = {
    lib.RSV_ERROR_ARGUMENT: ArgumentError,
    lib.RSV_ERROR_IO: FileError,
    lib.RSV_ERROR_FORMAT: FormatError,
    lib.RSV_ERROR_UNSUPPORTED: UnsupportedError,
    lib.RSV_ERROR_SCENE: SceneError,
    lib.RSV_ERROR_MEMORY: OutOfMemoryError,
    lib.RSV_ERROR_CANCELLED: Cancelled,
}


def error_of(status: int) -> ResolventError:
    """The exception for a status that is not RSV_OK, with the calling thread's message."""
    message = ffi.string(lib.rsv_last_error()).decode("utf-8", "replace")
    return _OF_STATUS.get(status, ResolventError)(message)
