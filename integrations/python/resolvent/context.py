"""Contexts: threads, progress, log, cancellation; and calls of the library."""
from __future__ import annotations

import logging
import operator
import os
import sys
import threading
import warnings
from typing import Any, Callable, Dict, List, Optional, Tuple, TypeVar

from ._native import ffi, lib
from .errors import ResolventError, ResolventWarning, error_of

T = TypeVar("T")
_counting = threading.RLock()
_logger = logging.getLogger("resolvent")


class Handle:
    """A C object, and the objects that must outlive it. It is destroyed once nothing uses it, after its children.
    (Python's garbage collector would destroy the members of a cycle in any order.)"""

    def __init__(self, pointer: Any, destroy: Callable[[Any], None], parent: Optional[Handle] = None, keep: Any = None):
        """@param keep Python objects that the C object borrows"""
        self.pointer, self._destroy, self.parent, self._keep, self._users = pointer, destroy, parent, keep, 1
        if parent is not None:
            parent.retain()

    def retain(self) -> None:
        with _counting:
            self._users += 1

    def release(self) -> None:
        with _counting:
            self._users -= 1
            unused = self._users == 0
        if unused:
            self._destroy(self.pointer)
            self.pointer = None
            if self.parent is not None:
                self.parent.release()


class Owner:
    """Owns a Handle. Immutable: a copy is the object itself."""

    _handle: Handle

    def __copy__(self: T) -> T:
        return self

    def __deepcopy__(self: T, _: Any) -> T:
        return self

    def __reduce__(self) -> Any:
        raise TypeError(f"a {type(self).__name__} cannot be pickled; scenes and lights have `save`")

    def __del__(self) -> None:
        handle = self.__dict__.pop("_handle", None)
        if handle is not None:
            handle.release()


class Object(Owner):
    """An object that belongs to a context."""

    _made_by = ""

    def __init__(self, context: Optional[Context] = None, handle: Optional[Handle] = None):
        if context is None or handle is None:
            raise TypeError(f"a {type(self).__name__} is made by {self._made_by}")
        self._context, self._handle = context, handle

    @property
    def context(self) -> Context:
        """The context of this object."""
        return self._context

    @property
    def _pointer(self) -> Any:
        return self._handle.pointer


class _Listener:
    """State of the callbacks of a context. It does not refer to the context, which would otherwise live until the
    garbage collector runs."""

    def __init__(self, progress: Optional[Callable[[str, float], Optional[bool]]]):
        self.progress = progress
        self.messages: List[Tuple[int, str]] = []
        self.raised: Dict[int, BaseException] = {}  #: by thread


def _note_exception(_kind: Any, value: BaseException, traceback: Any) -> bool:
    """Keeps an exception of a callback, such as KeyboardInterrupt, until the call of the library has returned."""
    handle = traceback.tb_frame.f_locals.get("handle") if traceback is not None else None
    if handle is not None:
        ffi.from_handle(handle).raised[threading.get_ident()] = value
    return False


@ffi.def_extern(name="rsv_py_progress", onerror=_note_exception)
def _tell_progress(handle: Any, phase: Any, fraction: float) -> bool:
    listener = ffi.from_handle(handle)
    if threading.get_ident() in listener.raised:
        return False
    if listener.progress is None:
        return True
    return listener.progress(ffi.string(phase).decode(), fraction) is not False


@ffi.def_extern(name="rsv_py_log", onerror=_note_exception)
def _tell_log(handle: Any, level: int, message: Any) -> None:
    ffi.from_handle(handle).messages.append((level, ffi.string(message).decode("utf-8", "replace")))


class Context(Owner):
    """Threads, progress and warnings of the objects that belong to it.

    Parameters
    ----------
    threads : worker threads; 0 = one per CPU, or OMP_NUM_THREADS. Results do not depend on it.
    progress : called as ``progress(phase, fraction)`` about 50 times a second during long work, from the working
        thread. Return False to cancel. Exceptions that it raises end the call, which raises them.

    Warnings of the library are Python warnings of class ResolventWarning; notes go to the logger "resolvent". While the
    library works, other Python threads can run. Ctrl-C stops the work with KeyboardInterrupt; the context remains
    usable.
    """

    def __init__(self, threads: int = 0, progress: Optional[Callable[[str, float], Optional[bool]]] = None):
        if progress is not None and not callable(progress):
            raise TypeError(f"progress: {type(progress).__name__} cannot be called")
        self._listener = _Listener(progress)
        self._running, self._lock = 0, threading.Lock()
        listener, user, out = ffi.new_handle(self._listener), ffi.new("rsv_py_user *"), ffi.new("rsv_context **")
        status = lib.rsv_py_context_create(count("threads", threads, 1024), listener, user, out)
        if status != lib.RSV_OK:
            raise error_of(status)
        self._handle = Handle(out[0], lib.rsv_context_destroy, keep=(listener, user))

    def __repr__(self) -> str:
        return f"<resolvent.Context at {id(self):#x}>"

    def cancel(self) -> None:
        """Stops calls that are running in other threads: they raise Cancelled."""
        with self._lock:
            if self._running:
                lib.rsv_context_cancel(self._handle.pointer)

    def call(self, function: Callable[..., int], *arguments: Any) -> None:
        """Calls a function of the library that returns a status; raises its error, or that of a callback."""
        self._raise_for(self._run(function, arguments))

    def create(self, function: Callable[..., int], kind: str, destroy: Callable[[Any], None], parent: Optional[Handle],
               *arguments: Any) -> Handle:
        """The same for a function that creates an object in its last parameter."""
        out = ffi.new(kind + " **")
        error = self._run(function, (*arguments, out))
        handle = None if error else Handle(out[0], destroy, parent or self._handle)
        try:
            self._raise_for(error)
        except BaseException:
            if handle is not None:
                handle.release()
            raise
        assert handle is not None
        return handle

    def _run(self, function: Callable[..., int], arguments: Tuple[Any, ...]) -> Optional[ResolventError]:
        with self._lock:
            self._running += 1
        try:
            status = function(*arguments)
            return None if status == lib.RSV_OK else error_of(status)
        finally:
            with self._lock:
                self._running -= 1
                if not self._running:
                    lib.rsv_context_reset_cancel(self._handle.pointer)

    def _raise_for(self, error: Optional[ResolventError]) -> None:
        raised = self._listener.raised.pop(threading.get_ident(), None)
        messages, self._listener.messages = self._listener.messages, []
        if raised is not None:
            raise raised
        if error is not None:
            raise error
        for level, message in messages:
            if level == lib.RSV_LOG_WARNING:
                warnings.warn(message, ResolventWarning, stacklevel=_level_of_caller())
            else:
                _logger.info("%s", message)


def _level_of_caller() -> int:
    """For warnings: stack level of the code that called this package."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == os.path.dirname(__file__):
        level, frame = level + 1, frame.f_back
    return level


def names_of(names: Any) -> List[str]:
    """A NULL-terminated array of names as a list."""
    known: List[str] = []
    while names[len(known)] != ffi.NULL:
        known.append(ffi.string(names[len(known)]).decode())
    return known


_default: Optional[Context] = None


def default_context() -> Context:
    """The context of objects that are created without one."""
    global _default
    if _default is None:
        _default = Context()
    return _default


def count(name: str, value: Any, most: int = 2**32 - 1, least: int = 0) -> int:
    """An integer in a range, or an exception that names the argument."""
    try:
        number = operator.index(value)
    except TypeError:
        number = None
    if number is None or isinstance(value, bool):
        raise TypeError(f"{name}: {type(value).__name__} is not an integer")
    if not least <= number <= most:
        raise ValueError(f"{name}: {number} is not in {least}..{most}")
    return number

