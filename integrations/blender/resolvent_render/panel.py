# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in Render properties."""
import bpy

from . import baking


class RESOLVENT_PT_panel(bpy.types.Panel):
    bl_label = "Resolvent"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"

    def draw(self, context):
        layout, own = self.layout, context.scene.resolvent
        layout.use_property_split, layout.use_property_decorate = True, False
        column = layout.column()
        column.prop(own, "mode")
        if own.mode != "reference":
            column.prop(own, "quality")
        column.prop(own, "samples")
        column.prop(own, "seed")
        layout.operator("resolvent.render", icon="RENDER_STILL").filepath = ""


class RESOLVENT_PT_bake(bpy.types.Panel):
    bl_label = "Bake"
    bl_parent_id = "RESOLVENT_PT_panel"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"

    def draw(self, context):
        layout, own = self.layout, context.scene.resolvent
        layout.use_property_split, layout.use_property_decorate = True, False
        column = layout.column()
        column.prop(own, "bake_target")
        if own.bake_target == "lightmap":
            column.prop(own, "map_size")
            column.prop(own, "new_uv")
        column.prop(own, "into_materials")
        row = layout.row(align=True)
        row.operator("resolvent.bake", icon="LIGHT")
        baked = row.row(align=True)
        baked.enabled = baking.is_baked(context.scene)
        baked.operator("resolvent.restore", icon="LOOP_BACK")


class RESOLVENT_PT_export(bpy.types.Panel):
    bl_label = "Export"
    bl_parent_id = "RESOLVENT_PT_panel"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"

    def draw(self, context):
        layout, own = self.layout, context.scene.resolvent
        layout.use_property_split, layout.use_property_decorate = True, False
        layout.prop(own, "export_path")
        layout.prop(own, "export_target")
        layout.operator("resolvent.export", icon="EXPORT").filepath = ""


class RESOLVENT_PT_report(bpy.types.Panel):
    bl_label = "Report"
    bl_parent_id = "RESOLVENT_PT_panel"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"

    @classmethod
    def poll(cls, context):
        return bool(context.scene.resolvent.report)

    def draw(self, context):
        column = self.layout.column(align=True)
        for line in context.scene.resolvent.report.splitlines():
            column.label(text=line, icon="INFO")


CLASSES = RESOLVENT_PT_panel, RESOLVENT_PT_bake, RESOLVENT_PT_export, RESOLVENT_PT_report


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
