# SPDX-License-Identifier: GPL-3.0-or-later
"""bpy.ops.resolvent.render, .bake, .restore and .export."""
import os

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from . import baking, engine, settings
from .program import Run, Scratch, find_program, thread_options
from .report import CannotRender, Report
from .scene_export import SceneExport

TICK_SECONDS = 0.1


class RESOLVENT_OT_render(bpy.types.Operator):
    """Render a picture with Resolvent, whatever the scene's engine is"""
    bl_idname = "resolvent.render"
    bl_label = "Render"
    mode: EnumProperty(name="Mode", items=settings.MODES + [("scene", "Scene", "As the scene says")], default="scene")
    quality: EnumProperty(name="Quality", items=settings.QUALITIES + [("scene", "Scene", "As the scene says")],
                          default="scene")
    samples: IntProperty(name="Samples", default=-1, min=-1, description="Camera rays per pixel; -1 = as the scene says")
    filepath: StringProperty(name="File", subtype="FILE_PATH",
                             description="Where the picture is written, in the scene's file format; empty = nowhere")

    def execute(self, context):
        scene = context.scene
        before = scene.render.engine
        engine.asked.update(mode=None if self.mode == "scene" else self.mode,
                            quality=None if self.quality == "scene" else self.quality,
                            samples=None if self.samples < 0 else self.samples)
        try:
            scene.render.engine = engine.ResolventEngine.bl_idname
            engine.last["error"] = None
            bpy.ops.render.render(scene=scene.name)
            if self.filepath and not engine.last["error"]:
                path = bpy.path.abspath(self.filepath)
                bpy.data.images["Render Result"].save_render(path, scene=scene)
        except RuntimeError as error:  # the engine's, or of a file that cannot be written
            engine.last["error"] = engine.last["error"] or str(error).strip().replace("Error: ", "")
        finally:
            scene.render.engine = before
            engine.asked.clear()
        scene.resolvent.report = "\n".join(engine.last["report"])
        if engine.last["error"]:
            self.report({"ERROR"}, engine.last["error"])
            return {"CANCELLED"}
        return {"FINISHED"}


class Job:
    """A scene exported, and the program at work on it. Base of the operators that keep Blender usable meanwhile."""
    for_baking = False

    def begin(self, context):
        """Exports and starts."""
        if context.mode != "OBJECT" and bpy.ops.object.mode_set.poll():
            bpy.ops.object.mode_set(mode="OBJECT")
        self.lines = Report()
        self.scratch = Scratch()
        self.folder = self.scratch.__enter__()
        try:
            depsgraph = context.evaluated_depsgraph_get()
            self.exported = SceneExport(depsgraph, self.folder, self.lines, self.for_baking)
            self.exported.write()
            self.run = Run(self.command(context))
        except BaseException:
            self.end(context)
            raise

    def end(self, context):
        """Removes the folder and says what was left out."""
        self.scratch.__exit__()
        context.scene.resolvent.report = "\n".join(self.lines.lines)
        for line in self.lines.lines:
            self.report({"WARNING"}, line)

    def failed(self, error):
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}

    def conclude(self, context):
        """After the program has ended well."""
        try:
            for message in self.run.messages:
                if message.startswith("warning: "):
                    self.lines.note(message[len("warning: "):])
            self.finish(context)
            return {"FINISHED"}
        except (CannotRender, OSError, ValueError) as error:
            return self.failed(error)
        finally:
            self.end(context)

    def execute(self, context):
        try:
            self.begin(context)
        except CannotRender as error:
            return self.failed(error)
        try:
            self.run.wait()
        except CannotRender as error:
            self.end(context)
            return self.failed(error)
        return self.conclude(context)

    def invoke(self, context, _):
        if bpy.app.background:
            return self.execute(context)
        try:
            self.begin(context)
        except CannotRender as error:
            return self.failed(error)
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self.timer = manager.event_timer_add(TICK_SECONDS, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self.run.stop()
            self.leave(context)
            self.end(context)
            self.report({"INFO"}, "cancelled; nothing was changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            ended = self.run.poll()
        except CannotRender as error:
            self.leave(context)
            self.end(context)
            return self.failed(error)
        context.window_manager.progress_update(int(100 * self.run.share))
        context.workspace.status_text_set(f"Resolvent: {100 * self.run.share:.0f} % {self.run.phase}   (Esc cancels)")
        if not ended:
            return {"RUNNING_MODAL"}
        self.leave(context)
        return self.conclude(context)

    def leave(self, context):
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)


def common_options(context, export, quality):
    scene = context.scene
    quality = scene.resolvent.quality if quality == "scene" else quality
    options = ["--quality", "medium" if quality == "auto" else quality, "--light-units", "watt",
               "--seed", str(scene.resolvent.seed)]
    return options + engine.environment_options(export) + thread_options(scene.render)


class RESOLVENT_OT_bake(Job, bpy.types.Operator):
    """Bake all diffuse light into the meshes of the scene. Restore undoes it"""
    bl_idname = "resolvent.bake"
    bl_label = "Bake"
    bl_options = {"REGISTER", "UNDO"}
    for_baking = True
    target: EnumProperty(name="Bake to", items=settings.TARGETS + [("scene", "Scene", "As the scene says")],
                         default="scene")
    quality: EnumProperty(name="Quality", items=settings.QUALITIES + [("scene", "Scene", "As the scene says")],
                          default="scene")
    map_size: IntProperty(name="Map size", default=0, min=0, max=16384, description="0 = as the scene says")
    into_materials: BoolProperty(name="Into materials", default=True)

    def chosen(self, context, name):
        own = {"target": "bake_target"}.get(name, name)
        value = getattr(self, name)
        return getattr(context.scene.resolvent, own) if value in ("scene", 0) else value

    def invoke(self, context, event):
        self.into_materials = context.scene.resolvent.into_materials
        return Job.invoke(self, context, event)

    def begin(self, context):
        baking.restore_all(context.scene)
        context.view_layer.update()
        Job.begin(self, context)

    def command(self, context):
        if not self.exported.parts:
            self.lines.note("no object can take baked light: instances and curves have to be made real first")
        self.out = os.path.join(self.folder, "baked.glb")
        target = self.chosen(context, "target")
        command = [find_program(), "bake", self.exported.path, "-o", self.out, "--to", target]
        if target == "lightmap":
            command += ["--map-size", str(self.chosen(context, "map_size"))]
            command += ["--new-uv"] if context.scene.resolvent.new_uv else []
        return command + common_options(context, self.exported, self.quality)

    def finish(self, context):
        count = baking.apply(context, self.out, self.exported.parts, self.chosen(context, "target"),
                             self.into_materials, self.lines)
        self.report({"INFO"}, f"light is baked into {count} objects; Restore undoes it")


class RESOLVENT_OT_restore(bpy.types.Operator):
    """Give all objects the meshes, materials and modifiers back that they had before light was baked into them"""
    bl_idname = "resolvent.restore"
    bl_label = "Restore"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        count = baking.restore_all(context.scene)
        self.report({"INFO"}, f"{count} objects are as they were before the bake")
        return {"FINISHED"} if count else {"CANCELLED"}


class RESOLVENT_OT_export(Job, bpy.types.Operator):
    """Write a GLB file with baked light, and what each lamp does by itself, so that web pages and engines can relight it"""
    bl_idname = "resolvent.export"
    bl_label = "Export relightable GLB"
    filepath: StringProperty(name="File", subtype="FILE_PATH")
    target: EnumProperty(name="Light in", items=settings.TARGETS + [("scene", "Scene", "As the scene says")],
                         default="scene")
    quality: EnumProperty(name="Quality", items=settings.QUALITIES + [("scene", "Scene", "As the scene says")],
                          default="scene")

    def path(self, context):
        wanted = self.filepath or context.scene.resolvent.export_path
        if wanted.startswith("//") and not bpy.data.filepath:
            raise CannotRender(f"'{wanted}' is beside the .blend file, which has no place yet: save it, or choose another "
                               "folder")
        path = os.path.abspath(bpy.path.abspath(wanted))
        return path if path.lower().endswith(".glb") else path + ".glb"

    def begin(self, context):
        self.out = self.path(context)
        folder = os.path.dirname(self.out)
        if not os.path.isdir(folder):
            raise CannotRender(f"there is no folder {folder}; make it, or choose another one")
        if not os.access(folder, os.W_OK):
            raise CannotRender(f"the folder {folder} cannot be written to; choose another one")
        Job.begin(self, context)

    def command(self, context):
        own = context.scene.resolvent
        target = own.export_target if self.target == "scene" else self.target
        command = [find_program(), "bake", self.exported.path, "-o", self.out, "--to", target, "--basis"]
        return command + common_options(context, self.exported, self.quality)

    def finish(self, context):
        self.report({"INFO"}, f"{self.out} and the light of each lamp beside it")


CLASSES = RESOLVENT_OT_render, RESOLVENT_OT_bake, RESOLVENT_OT_restore, RESOLVENT_OT_export


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
