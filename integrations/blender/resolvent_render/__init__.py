# SPDX-License-Identifier: GPL-3.0-or-later
"""Resolvent in Blender: pictures, baked light and relightable files."""
bl_info = {
    "name": "Resolvent",
    "author": "Resolvent",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties > Resolvent",
    "description": "Global illumination by the light-transport operator: render, bake, relight, export",
    "category": "Render",
}

from . import engine, operators, panel, settings  # noqa: E402

MODULES = settings, engine, operators, panel


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
