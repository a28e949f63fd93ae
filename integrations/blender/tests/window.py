# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel, bakes and the live viewport in a window:
blender --factory-startup --enable-event-simulate -P window.py -- FOLDER

Writes panel.png, viewport-0.png (as solved), -1 (a lamp recoloured) and -2 (the lamp moved), and prints how long relighting
took. Exit status 1 if a bake could not be cancelled or did not end, nothing was drawn, or the viewport did not follow.
"""
import os
import sys
import time

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import scenes  # noqa: E402

FOLDER = sys.argv[-1]
SECONDS = 240


def area(kind):
    return next(a for a in bpy.context.window_manager.windows[0].screen.areas if a.type == kind)


def screenshot(name, shown=None):
    path = os.path.join(FOLDER, name)
    bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, screen=window.screen, area=shown or window.screen.areas[0]):
        if shown:
            bpy.ops.screen.screenshot_area(filepath=path)
        else:
            bpy.ops.screen.screenshot(filepath=path)
    image = bpy.data.images.load(path)
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    width, height = image.size
    bpy.data.images.remove(image)
    middle = pixels.reshape(height, width, -1)[height // 4:3 * height // 4, width // 4:3 * width // 4, :3]
    return middle.mean(axis=(0, 1))


def live():
    from resolvent_render import viewport
    return viewport.LAST


def bakes(scene):
    """A bake that Esc cancels, and one that ends."""
    window = bpy.context.window_manager.windows[0]
    scene.resolvent.quality = "draft"
    with bpy.context.temp_override(window=window, screen=window.screen, area=area("VIEW_3D")):
        assert bpy.ops.resolvent.bake("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield
    window.event_simulate(type="ESC", value="PRESS", x=100, y=100)
    window.event_simulate(type="ESC", value="RELEASE", x=100, y=100)
    for _ in range(10):
        yield
    assert not any(ob.resolvent_before.is_baked for ob in scene.objects), "the bake was not cancelled"
    with bpy.context.temp_override(window=window, screen=window.screen, area=area("VIEW_3D")):
        assert bpy.ops.resolvent.bake("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    start = time.time()
    while not any(ob.resolvent_before.is_baked for ob in scene.objects):
        assert time.time() < start + SECONDS, "the bake did not end"
        yield
    print(f"baked in {time.time() - start:.1f} s")
    screenshot("panel.png")
    assert bpy.ops.resolvent.restore() == {"FINISHED"}
    yield


def steps():
    """A generator: each yield lets Blender draw."""
    scene = scenes.reset()
    scenes.modifiers()
    scene.render.engine = "RESOLVENT"
    yield
    properties = area("PROPERTIES")
    properties.spaces.active.context = "RENDER"
    yield
    yield from bakes(scene)
    view = area("VIEW_3D")
    space = view.spaces.active
    space.region_3d.view_perspective = "CAMERA"
    space.overlay.show_overlays = False
    space.shading.type = "RENDERED"
    start = time.time()
    while live() is None or live().solved is None or live().run is not None:
        assert time.time() < start + SECONDS, "the scene was not solved"
        assert live() is None or not live().error, live().error
        yield
    print(f"solved in {time.time() - start:.1f} s, {len(live().solved.positions)} vertices, "
          f"{len(live().solved.operator.positions)} elements")
    for _ in range(5):
        yield
    before = screenshot("viewport-0.png", view)
    lamp = scene.objects["area"]
    lamp.data.color = (1, 0.3, 0.1)
    for _ in range(5):
        yield
    print(f"recoloured: relit in {1000 * live().cpu_seconds:.1f} ms of CPU time")
    warm = screenshot("viewport-1.png", view)
    lamp.location.x = 1.2
    lamp.data.color = (1, 1, 1)
    times = []
    for _ in range(4):
        yield  # draws
        times.append(live().cpu_seconds)
    print(f"moved: relit in {', '.join(f'{1000 * t:.1f}' for t in times)} ms of CPU time")
    moved = screenshot("viewport-2.png", view)
    print("means", before, warm, moved)
    assert before.max() > 0.05, "nothing is drawn"
    assert warm[0] / warm[2] > 1.5 * before[0] / before[2], "the viewport did not follow the colour"
    assert moved[2] > warm[2], "the viewport did not follow the lamp"
    assert max(times) < 0.1, "relighting takes more than 100 ms of CPU time"


class Runner:
    def __init__(self):
        self.steps = steps()

    def __call__(self):
        try:
            next(self.steps)
            return 0.2
        except StopIteration:
            print("the window shows it")
            status = 0
        except BaseException:
            import traceback
            traceback.print_exc()
            status = 1
        sys.stdout.flush()
        if live() is not None:
            live().stop()
        os._exit(status)


bpy.app.timers.register(Runner(), first_interval=1.0, persistent=True)
