# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user chooses, kept with the scene."""
import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

MODES = [("final", "Final", "Direct light per pixel, all further light from the solution"),
         ("operator", "Operator", "All light looked up in the solution: quick"),
         ("reference", "Reference", "An unbiased path tracer, slow, to judge the others by")]
QUALITIES = [("auto", "Automatic", "Pictures: elements, rays and samples for an error of 7 %; otherwise medium"),
             ("draft", "Draft", "Quick"), ("medium", "Medium", ""), ("high", "High", "")]
TARGETS = [("vertex", "Vertex colours", "Light in a colour attribute 'Resolvent' of each mesh"),
           ("lightmap", "Lightmap", "Light in an image; UV maps are made where they are missing")]


class ResolventSettings(bpy.types.PropertyGroup):
    mode: EnumProperty(name="Mode", items=MODES, default="final")
    quality: EnumProperty(name="Quality", items=QUALITIES, default="auto",
                          description="Elements and rays of the solution")
    samples: IntProperty(name="Samples", default=0, min=0, max=1 << 24,
                         description="Camera rays per pixel; 0 = by mode and quality")
    seed: IntProperty(name="Seed", default=0, min=0, description="Another set of random numbers")
    bake_target: EnumProperty(name="Bake to", items=TARGETS, default="lightmap")
    map_size: IntProperty(name="Map size", default=1024, min=16, max=16384,
                          description="Texels along the longer side of the lightmap")
    new_uv: BoolProperty(name="New UV maps", default=False,
                         description="Make texture coordinates even where a mesh has a map called Resolvent or Lightmap")
    into_materials: BoolProperty(name="Into materials", default=True,
                                 description="Show the baked light in copies of the materials")
    export_path: StringProperty(name="File", default="//relightable.glb", subtype="FILE_PATH")
    export_target: EnumProperty(name="Light in", items=TARGETS, default="vertex")
    report: StringProperty(name="Report", description="What of the scene could not be handed over as it is")


class ResolventSlot(bpy.types.PropertyGroup):
    """A material slot before the bake."""
    material: bpy.props.PointerProperty(type=bpy.types.Material)
    link: StringProperty()


class ResolventBefore(bpy.types.PropertyGroup):
    """What an object was before light was baked into it."""
    mesh: bpy.props.PointerProperty(type=bpy.types.Mesh)
    modifiers: StringProperty()  # names, separated by newlines, that were on in renders / in the viewport
    viewport_modifiers: StringProperty()
    slots: bpy.props.CollectionProperty(type=ResolventSlot)
    is_baked: BoolProperty()


class ResolventPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name="Program", subtype="FILE_PATH",
                            description="The program resolvent; empty = what came with the add-on, or what PATH finds")

    def draw(self, context):
        self.layout.prop(self, "program")


CLASSES = ResolventSettings, ResolventSlot, ResolventBefore, ResolventPreferences


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.resolvent = bpy.props.PointerProperty(type=ResolventSettings)
    bpy.types.Object.resolvent_before = bpy.props.PointerProperty(type=ResolventBefore)


def unregister():
    del bpy.types.Object.resolvent_before
    del bpy.types.Scene.resolvent
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
