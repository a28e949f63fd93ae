# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked light into meshes, images and materials, and back out of them."""
import os

import bpy
import numpy as np

from .formats import GlbFile
from .report import CannotRender

ATTRIBUTE = "Resolvent"  # colour attribute and UV map
SUFFIX = " (baked)"


def is_baked(scene):
    return any(ob.resolvent_before.is_baked for ob in scene.objects)


# ---- reading the program's file ---------------------------------------------------------------------


class BakedFile:
    """The file of `resolvent bake`: light by object and primitive."""

    def __init__(self, path):
        self.file = GlbFile(path)
        self.nodes = {}
        for node in self.file.document.get("nodes", []):
            if "mesh" in node:
                self.nodes.setdefault(node.get("name"), node["mesh"])
        own = self.file.document.get("asset", {}).get("extras", {}).get("resolvent", {})
        self.light_scale = own.get("light_scale", 1.0)

    def primitive(self, part):
        mesh = self.nodes.get(part.object_name)
        if mesh is None:
            return None
        return self.file.document["meshes"][mesh]["primitives"][part.primitive]

    def corners(self, part, primitive, values):
        """(triangles of the part, 3, ...): what the program's vertices hold, at the corners of the exported triangles. The
        program may order triangles otherwise, and splits vertices where light or charts end."""
        indices = self.file.accessor(primitive["indices"]).ravel()
        vertex = self.file.accessor(primitive["attributes"]["_VERTEX"]).ravel()
        found = vertex[indices].astype(np.int64).reshape(-1, 3)
        wanted = np.searchsorted(part.vertices, part.data.triangles[part.chosen])
        there, here = np.lexsort(found.T), np.lexsort(wanted.T)
        if not np.array_equal(found[there], wanted[here]):
            raise CannotRender(f"object '{part.object_name}': the baked mesh has other triangles than the exported one")
        result = np.empty((len(here), 3, values.shape[1]))
        result[here] = values[indices].reshape(-1, 3, values.shape[1])[there]
        return result

    def vertex_light(self, part):
        """(triangles of the part, 3, 3): irradiance / pi, or None if its surface reflects no light diffusely."""
        primitive = self.primitive(part)
        if primitive is None or "resolvent_first_receiver" not in primitive.get("extras", {}):
            return None
        light = self.file.accessor(primitive["attributes"]["COLOR_0"])[:, :3] * self.light_scale
        own = primitive["attributes"].get("_COLOR")
        if own is not None:  # the light is multiplied by the colours that the mesh had
            colour = self.file.accessor(own)[:, :3]
            light = np.where(colour > 0, light / np.maximum(colour, 1e-9), 0)
        return self.corners(part, primitive, light)

    def lightmap_uv(self, part):
        """(triangles of the part, 3, 2) by Blender's convention, or None."""
        primitive = self.primitive(part)
        material = primitive and self.file.document["materials"][primitive["material"]]
        use = (material or {}).get("extensions", {}).get("MOZ_lightmap")
        if use is None:
            return None
        uv = self.file.accessor(primitive["attributes"][f"TEXCOORD_{use.get('texCoord', 0)}"])
        return self.corners(part, primitive, uv * (1, -1) + (0, 1))


# ---- meshes -----------------------------------------------------------------------------------------


def apply(context, path, parts, target, into_materials, report):
    """Gives each object a mesh with the light. Returns how many have got one."""
    file = BakedFile(path)
    lights = {"vertex": file.vertex_light, "lightmap": file.lightmap_uv}[target]
    by_object = {}
    for part in parts:
        light = lights(part)
        if light is not None:
            by_object.setdefault(part.object_name, []).append((part, light))
    if not by_object:
        raise CannotRender("no surface of the scene reflects light diffusely: there is nothing to bake")
    image = load_map(context.scene, path) if target == "lightmap" else None
    baker = MaterialBaker(target, image) if into_materials else None
    depsgraph = context.evaluated_depsgraph_get()
    count = 0
    for name, found in by_object.items():
        ob = context.scene.objects.get(name)
        if ob is None or ob.library is not None:
            report.note(f"object '{name}': it is linked from a library, and keeps no baked light; make it local")
        else:
            bake_object(ob, depsgraph, found, target, baker)
            count += 1
    return count


def bake_object(ob, depsgraph, found, target, baker):
    mesh = bpy.data.meshes.new_from_object(ob.evaluated_get(depsgraph), preserve_all_data_layers=True,
                                           depsgraph=depsgraph)
    mesh.name = ob.data.name + SUFFIX
    if target == "vertex":
        write_colours(mesh, found)
    else:
        mesh = write_uv(mesh, found)
    materials = [s.material for s in ob.material_slots]
    remember(ob)
    ob.data = mesh
    mesh.materials.clear()
    lit = {part.material for part, _ in found}
    for material in materials:
        is_lit = (material.name_full if material else None) in lit
        mesh.materials.append(baker.copy(material) if baker and is_lit else material)
    if not materials and baker and None in lit:
        mesh.materials.append(baker.copy(None))
    for slot in ob.material_slots:
        slot.link = "DATA"


def write_colours(mesh, found):
    colours = np.zeros((len(mesh.loops), 4), np.float32)
    colours[:, 3] = 1
    for part, light in found:
        colours[part.data.corners[part.chosen].ravel(), :3] = light.reshape(-1, 3)
    old = mesh.color_attributes.get(ATTRIBUTE)
    if old:
        mesh.color_attributes.remove(old)
    attribute = mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "CORNER")
    attribute.data.foreach_set("color", colours.ravel())


def write_uv(mesh, found):
    """Charts of a lightmap may part the triangles of a polygon: the mesh becomes triangles first."""
    uv = np.zeros((found[0][0].data.corners.shape[0], 3, 2), np.float32)
    for part, light in found:
        uv[part.chosen] = light
    corners = found[0][0].data.corners
    names = {ATTRIBUTE}
    if max((len(p.vertices) for p in mesh.polygons), default=3) > 3:
        mesh = triangulated(mesh, corners)
        order = np.arange(3 * len(corners))
    else:
        order = corners.ravel()
    for name in names:
        if name in mesh.uv_layers:
            mesh.uv_layers.remove(mesh.uv_layers[name])
    if len(mesh.uv_layers) >= 8:
        raise CannotRender(f"mesh '{mesh.name}': it has 8 UV maps already; remove one")
    active = mesh.uv_layers.active_index
    layer = mesh.uv_layers.new(name=ATTRIBUTE, do_init=False)
    if active >= 0 and len(mesh.uv_layers) > 1:
        mesh.uv_layers.active_index = active
    values = np.zeros((len(mesh.loops), 2), np.float32)
    values[order] = uv.reshape(-1, 2)
    layer.data.foreach_set("uv", values.ravel())
    return mesh


def triangulated(mesh, corners):
    """The same mesh of its loop triangles, in their order: all layers of the corners and the normals are kept."""
    vertex = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertex)
    normals = np.empty(3 * len(mesh.loops), np.float32)
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals)
    else:
        mesh.corner_normals.foreach_get("vector", normals)
    mesh.calc_loop_triangles()
    polygon = np.empty(len(corners), np.int32)
    mesh.loop_triangles.foreach_get("polygon_index", polygon)
    co = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", co)
    new = bpy.data.meshes.new(mesh.name)
    new.from_pydata(co.reshape(-1, 3).tolist(), [], vertex[corners].tolist())
    new.polygons.foreach_set("material_index", _polygon_column(mesh, "material_index", np.int32)[polygon])
    new.polygons.foreach_set("use_smooth", _polygon_column(mesh, "use_smooth", bool)[polygon])
    for layer in mesh.uv_layers:
        values = np.empty(2 * len(mesh.loops), np.float32)
        layer.data.foreach_get("uv", values)
        copy = new.uv_layers.new(name=layer.name, do_init=False)
        copy.data.foreach_set("uv", values.reshape(-1, 2)[corners.ravel()].ravel())
        copy.active_render = layer.active_render
    for attribute in mesh.color_attributes:
        copy_colours(new, attribute, corners)
    if hasattr(new, "use_auto_smooth"):
        new.use_auto_smooth = True
    new.normals_split_custom_set(normals.reshape(-1, 3)[corners.ravel()])
    name = mesh.name
    bpy.data.meshes.remove(mesh)
    new.name = name
    return new


def _polygon_column(mesh, name, dtype):
    values = np.empty(len(mesh.polygons), dtype)
    mesh.polygons.foreach_get(name, values)
    return values


def copy_colours(mesh, attribute, corners):
    values = np.empty(4 * len(attribute.data), np.float32)
    attribute.data.foreach_get("color", values)
    if attribute.domain == "CORNER":
        values = values.reshape(-1, 4)[corners.ravel()].ravel()
    mesh.color_attributes.new(attribute.name, attribute.data_type, attribute.domain).data.foreach_set("color", values)


def load_map(scene, path):
    """The map in full precision, packed into the .blend file."""
    image = bpy.data.images.load(os.path.splitext(path)[0] + ".lightmap.exr")
    image.name = f"Lightmap of {scene.name}"
    for name in ("Linear", "Linear Rec.709"):
        try:
            image.colorspace_settings.name = name
            break
        except TypeError:
            continue
    image.pack()
    image.filepath = ""
    return image


# ---- undoing ----------------------------------------------------------------------------------------


def remember(ob):
    before = ob.resolvent_before
    before.mesh, before.is_baked = ob.data, True
    before.slots.clear()
    for slot in ob.material_slots:
        old = before.slots.add()
        old.material, old.link = slot.material, slot.link
    before.modifiers = "\n".join(m.name for m in ob.modifiers if m.show_render)
    before.viewport_modifiers = "\n".join(m.name for m in ob.modifiers if m.show_viewport)
    for modifier in ob.modifiers:
        modifier.show_render = modifier.show_viewport = False


def restore(ob):
    before, baked = ob.resolvent_before, ob.data
    if before.mesh is not None:
        ob.data = before.mesh
    copies = [m for m in baked.materials if m and m.name.endswith(SUFFIX)] if baked is not ob.data else []
    for slot, old in zip(ob.material_slots, before.slots):
        if old.link == "OBJECT":
            slot.link, slot.material = "OBJECT", old.material
    before.slots.clear()
    for modifier in ob.modifiers:
        modifier.show_render = modifier.name in before.modifiers.split("\n")
        modifier.show_viewport = modifier.name in before.viewport_modifiers.split("\n")
    before.mesh, before.is_baked = None, False
    if baked is not ob.data and not baked.users:
        bpy.data.meshes.remove(baked)
    return copies


def restore_all(scene):
    """Undoes all bakes. Returns how many objects had one."""
    count, copies = 0, []
    for ob in scene.objects:
        if ob.resolvent_before.is_baked:
            copies += restore(ob)
            count += 1
    for material in set(copies):
        if not material.users:
            bpy.data.materials.remove(material)
    for image in [i for i in bpy.data.images if i.name.startswith("Lightmap of ") and not i.users]:
        bpy.data.images.remove(image)
    return count


# ---- materials --------------------------------------------------------------------------------------


class MaterialBaker:
    """Copies of materials whose diffuse light is the baked one."""

    def __init__(self, target, image):
        self.target, self.image, self.copies = target, image, {}

    def copy(self, material):
        key = material.name_full if material else None
        if key not in self.copies:
            self.copies[key] = self._make(material)
        return self.copies[key]

    def _make(self, material):
        new = material.copy() if material else bpy.data.materials.new("default")
        new.name = (material.name if material else "default") + SUFFIX
        if not new.use_nodes:
            colour = new.diffuse_color[:]
            new.use_nodes = True
            shader = next(n for n in new.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
            shader.inputs["Base Color"].default_value = colour
        for node in list(new.node_tree.nodes):
            if node.type in {"BSDF_PRINCIPLED", "BSDF_DIFFUSE"}:
                self._show_light(new.node_tree, node)
        return new

    def _light(self, tree):
        """A socket with irradiance / pi."""
        if self.target == "vertex":
            node = tree.nodes.new("ShaderNodeVertexColor")
            node.layer_name = ATTRIBUTE
            return node.outputs["Color"]
        uv, texture = tree.nodes.new("ShaderNodeUVMap"), tree.nodes.new("ShaderNodeTexImage")
        uv.uv_map, texture.image = ATTRIBUTE, self.image
        tree.links.new(uv.outputs[0], texture.inputs["Vector"])
        scale = tree.nodes.new("ShaderNodeVectorMath")
        scale.operation = "SCALE"
        scale.inputs["Scale"].default_value = 1 / np.pi
        tree.links.new(texture.outputs["Color"], scale.inputs[0])
        return scale.outputs[0]

    def _show_light(self, tree, node):
        """The node's diffuse lobe gives way to an emission of base colour * light, added to the rest of it."""
        base = node.inputs.get("Base Color") or node.inputs["Color"]
        if "Metallic" in node.inputs and not node.inputs["Metallic"].is_linked \
                and node.inputs["Metallic"].default_value > 0.5:
            return
        users = [link.to_socket for link in node.outputs[0].links]
        product = tree.nodes.new("ShaderNodeVectorMath")
        product.operation = "MULTIPLY"
        if base.is_linked:
            tree.links.new(base.links[0].from_socket, product.inputs[0])
            tree.links.remove(base.links[0])
        else:
            product.inputs[0].default_value = base.default_value[:3]
        base.default_value = (0, 0, 0, 1)
        tree.links.new(self._light(tree), product.inputs[1])
        emission, total = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(product.outputs[0], emission.inputs["Color"])
        tree.links.new(node.outputs[0], total.inputs[0])
        tree.links.new(emission.outputs[0], total.inputs[1])
        for socket in users:
            tree.links.new(total.outputs[0], socket)
        product.location, emission.location, total.location = ((node.location.x + dx, node.location.y + dy)
                                                               for dx, dy in ((-200, 250), (0, 250), (300, 150)))
