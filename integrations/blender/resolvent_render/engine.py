# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: F12."""
import os

import bpy

from .program import Cancelled, Run, Scratch, find_program, thread_options
from .report import CannotRender, Report
from .scene_export import SceneExport, camera_options, picture_size
from .viewport import ViewportEngine

# The mode and samples that an operator asks for; None = the scene's settings.
asked = {}
# Of the last render: lines for the user, and the error if it failed.
last = {"report": [], "error": None}


def setting(scene, name):
    return asked.get(name) if asked.get(name) is not None else getattr(scene.resolvent, name)


def environment_options(export):
    return ["--env", export.environment] if export.environment else []


def picture_command(export, out):
    scene, report = export.scene, export.report
    mode, samples = setting(scene, "mode"), setting(scene, "samples")
    width, height = picture_size(scene.render)
    command = [find_program(), "render", export.path, "-o", out, "--size", f"{width}x{height}", "--mode", mode,
               "--light-units", "watt", "--seed", str(scene.resolvent.seed), "--camera", export.camera]
    quality = setting(scene, "quality")
    if mode != "reference" and quality != "auto":
        command += ["--quality", quality]
    if samples:
        command += ["--spp", str(samples)]
    camera = scene.camera.evaluated_get(export.depsgraph)
    command += camera_options(camera, export.depsgraph, scene.render, mode, report)
    return command + environment_options(export) + thread_options(scene.render)


def note_settings(scene, report):
    render = scene.render
    if render.use_motion_blur:
        report.note("motion blur is left out")
    if render.film_transparent:
        report.note("the film is not transparent: alpha is 1 everywhere")
    if render.use_border:
        report.note("the render region is ignored: the whole picture is rendered")
    if render.use_freestyle:
        report.note("Freestyle lines are left out")


class ResolventEngine(ViewportEngine, bpy.types.RenderEngine):
    bl_idname = "RESOLVENT"
    bl_label = "Resolvent"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True
    bl_use_gpu_context = False

    def render(self, depsgraph):
        report = Report()
        last.update(report=report.lines, error=None)
        try:
            with Scratch() as folder:
                self.picture(depsgraph, folder, report)
        except Cancelled:
            last["error"] = "cancelled"
        except CannotRender as error:
            last["error"] = str(error)
            self.error_set(str(error))
        if last["error"]:  # Blender 3.4 crashes where it is to write a picture and there is none at all
            self.end_result(self.begin_result(0, 0, *picture_size(depsgraph.scene.render)), cancel=True)
        for line in report.lines:
            self.report({"WARNING"}, line)

    def picture(self, depsgraph, folder, report):
        scene = depsgraph.scene
        note_settings(scene, report)
        if scene.camera is None:
            raise CannotRender("the scene has no camera: add one, and make it active")
        self.update_stats("", "Exporting")
        export = SceneExport(depsgraph, folder, report)
        export.write()
        out = os.path.join(folder, "picture.exr")
        run = Run(picture_command(export, out))
        for message in run.wait(self.show_progress, self.test_break):
            if message.startswith("warning: "):
                report.note(message[len("warning: "):])
        width, height = picture_size(scene.render)
        result = self.begin_result(0, 0, width, height)
        result.layers[0].load_from_file(out)
        self.end_result(result)

    def __del__(self):
        if self.live is not None:
            self.live.stop()

    def show_progress(self, share, phase):
        self.update_progress(share)
        self.update_stats("", phase)


def compatible_panels():
    """Panels that Blender shows for its own engines, and that this one obeys, too."""
    exclude = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_eevee_ambient_occlusion"}
    for cls in bpy.types.Panel.__subclasses__():
        engines = getattr(cls, "COMPAT_ENGINES", ())
        if "BLENDER_RENDER" in engines and cls.__name__ not in exclude:
            yield cls
    # lamps, worlds and materials are described for Eevee and Cycles
    for name in ("DATA_PT_EEVEE_light", "EEVEE_WORLD_PT_surface", "EEVEE_MATERIAL_PT_context_material",
                 "EEVEE_MATERIAL_PT_surface", "DATA_PT_spot"):
        cls = getattr(bpy.types, name, None)
        if cls is not None and hasattr(cls, "COMPAT_ENGINES"):
            yield cls


def register():
    bpy.utils.register_class(ResolventEngine)
    for cls in compatible_panels():
        cls.COMPAT_ENGINES.add("RESOLVENT")


def unregister():
    for cls in compatible_panels():
        cls.COMPAT_ENGINES.discard("RESOLVENT")
    bpy.utils.unregister_class(ResolventEngine)
