# SPDX-License-Identifier: GPL-3.0-or-later
"""The program `resolvent` as a child process: progress, cancelling, messages."""
import os
import re
import select
import shutil
import subprocess
import tempfile
import time

import bpy

from .report import CannotRender

POLL_SECONDS = 0.05
STOP_SECONDS = 5
BUNDLED = os.path.join(os.path.dirname(__file__), "program", "bin", "resolvent")
PERCENT = re.compile(r"(\d+) %[^\]]*$")


def preferences():
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences if addon else None


def find_program():
    """The path of the program: the preference, what came with the add-on, or what PATH finds."""
    chosen = preferences()
    path = bpy.path.abspath(chosen.program) if chosen and chosen.program else ""
    if path:
        if not os.access(path, os.X_OK) or os.path.isdir(path):
            raise CannotRender(f"'{path}' is not a program; correct Program in the add-on's preferences, or leave it empty")
        return path
    if os.path.isfile(BUNDLED):
        if not os.access(BUNDLED, os.X_OK):
            make_executable(BUNDLED)
        return BUNDLED
    path = shutil.which("resolvent")
    if not path:
        raise CannotRender("the program 'resolvent' was not found; name it in the preferences of the add-on")
    return path


def make_executable(path):
    """Blender's installer loses what zip files say of that."""
    try:
        os.chmod(path, 0o755)
    except OSError as error:
        raise CannotRender(f"cannot make {path} executable: {error.strerror}; run chmod +x on it") from error


def thread_options(render):
    return ["--threads", str(render.threads)] if render.threads_mode == "FIXED" else []


class Scratch:
    """A folder for one run, which goes with it."""

    folder = None

    def __enter__(self):
        base = bpy.app.tempdir or None
        try:
            self.folder = tempfile.mkdtemp(prefix="resolvent-", dir=base)
        except OSError as error:
            raise CannotRender(f"cannot make a folder in {base or tempfile.gettempdir()}: {error.strerror}; choose another "
                               "temporary folder in Blender's preferences") from error
        return self.folder

    def __exit__(self, *_):
        shutil.rmtree(self.folder, ignore_errors=True)


class Cancelled(Exception):
    """The user stopped the run."""


class Run:
    """One run of the program. poll() until it returns True; then read `messages`."""

    def __init__(self, arguments):
        self.arguments, self.messages = arguments, []
        self.share, self.phase, self.pending = 0.0, "", ""
        self.reader, own = self._terminal()
        try:
            self.process = subprocess.Popen(arguments, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=own)
        except OSError as error:
            os.close(self.reader)
            raise CannotRender(f"cannot start {arguments[0]}: {error.strerror}; check the add-on's preferences") from error
        finally:
            os.close(own)

    @staticmethod
    def _terminal():
        """The program reports its progress often only to a terminal."""
        try:
            return os.openpty()
        except (AttributeError, OSError):
            return os.pipe()

    def _read(self):
        while select.select([self.reader], [], [], 0)[0]:
            try:
                data = os.read(self.reader, 65536)
            except OSError:  # its other end is closed
                return
            if not data:
                return
            self.pending += data.decode(errors="replace")
        *lines, self.pending = re.split(r"[\r\n]+", self.pending)
        for line in lines + ([self.pending] if self.pending.startswith("[") else []):
            self._take(line.replace("\x1b[K", "").strip())

    def _take(self, line):
        bar = line.startswith("[") and PERCENT.search(line)
        if bar:
            self.share, self.phase = int(bar.group(1)) / 100, line[line.index("%") + 1:].strip(" ,")
        elif line and not line.startswith("["):
            self.messages.append(line)

    def poll(self):
        """Whether it has ended. Raises CannotRender with its message if it failed."""
        self._read()
        if self.process.poll() is None:
            return False
        self._read()
        self._take(self.pending.replace("\x1b[K", "").strip())
        self.pending = ""
        os.close(self.reader)
        if self.process.returncode:
            errors = [m for m in self.messages if m.startswith("error")]
            raise CannotRender(errors[-1] if errors else
                               f"the program ended with status {self.process.returncode}: {' '.join(self.messages[-1:])}")
        return True

    def stop(self):
        self.process.terminate()
        try:
            self.process.wait(STOP_SECONDS)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.reader)

    def wait(self, progress=None, is_cancelled=None):
        """Runs to the end. @param progress called with (share, phase) @raise Cancelled"""
        while not self.poll():
            if is_cancelled and is_cancelled():
                self.stop()
                raise Cancelled
            if progress:
                progress(self.share, self.phase)
            time.sleep(POLL_SECONDS)
        return self.messages
