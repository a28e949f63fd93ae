"""Writes the C source of the extension module from the library's public headers.

usage: build_native.py COMPILER INCLUDE_FOLDER OUTPUT.c
"""
import pathlib
import re
import subprocess
import sys
import tempfile

from cffi import FFI

SYSTEM_HEADERS = ("stdbool.h", "stddef.h", "stdint.h")
CONSTANTS = ("RSV_NONE", "RSV_TEXTURE_MAX_SIDE", "RSV_FINGERPRINT_DIGITS")
CALLBACKS = """
typedef struct rsv_py_user { ...; } rsv_py_user;
extern "Python" bool rsv_py_progress(void *handle, const char *phase, double fraction);
extern "Python" void rsv_py_log(void *handle, rsv_log_level level, const char *message);
bool rsv_py_runs_here(void);
rsv_status rsv_py_context_create(int thread_count, void *handle, rsv_py_user *user, rsv_context **context);
"""


def declarations(compiler, include):
    """What the headers declare, without what cffi does not read: attributes, bodies of functions, and declarations
    of the system."""
    with tempfile.TemporaryDirectory() as empty:
        for name in SYSTEM_HEADERS:
            pathlib.Path(empty, name).touch()
        source = subprocess.run(
            [compiler, "-E", "-P", "-nostdinc", "-U__GNUC__", "-I", empty, "-I", include, "-x", "c", "-"],
            input=b"#include <resolvent/resolvent.h>\n", stdout=subprocess.PIPE, check=True).stdout.decode()
    source = re.sub(r"static inline ([^{;]*\))\s*\{.*?\n\}", r"\1;", source, flags=re.DOTALL)  # functions of the headers alone
    source = re.sub(r"__attribute__\(\(.*?\)\)(?=[\s;])", "", source)
    return re.sub(r"\bconst\s+(\w+)\s*\(\s*\*", r"\1 (*", source)  # pointers to constant arrays


def main(compiler, include, output):
    builder = FFI()
    builder.cdef("\n".join(f"#define {name} ..." for name in CONSTANTS))
    builder.cdef(declarations(compiler, include))
    builder.cdef(CALLBACKS)
    builder.set_source("resolvent._native", '#include "native.h"', py_limited_api=True)
    builder.emit_c_code(output)


if __name__ == "__main__":
    main(*sys.argv[1:])
