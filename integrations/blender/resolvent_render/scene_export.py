# SPDX-License-Identifier: GPL-3.0-or-later
"""An evaluated scene of Blender as a GLB file and surroundings."""
import math
import os

import bpy
import numpy as np

from .formats import GlbWriter
from .lamps import add_lamp
from .materials import MaterialMaker
from .report import CannotRender
from .world import write_environment

Y_UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)
MOST_TRIANGLES = 200_000_000
MESH_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
LIGHTMAP_NAMES = ("Resolvent", "Lightmap", "LightMap", "lightmap")


def world_matrix(matrix):
    return Y_UP @ np.array(matrix)


class MeshData:
    """The triangles of an evaluated mesh, without what glTF does not have.

    positions, normals (n, 3), uvs {name: (n, 2)}, colours (n, 4) or None: of n vertices, which differ where any of these
    does; triangles (m, 3) of these; materials (m,) slots; corners (m, 3) of the mesh's loops.
    """

    def __init__(self, mesh, active_uv, uv_names, colour_name):
        mesh.calc_loop_triangles()
        if hasattr(mesh, "calc_normals_split"):
            mesh.calc_normals_split()
        count = len(mesh.loop_triangles)
        self.corners = _column(mesh.loop_triangles, "loops", 3 * count, np.int32).reshape(-1, 3)
        self.materials = _column(mesh.loop_triangles, "material_index", count, np.int32)
        vertex = _column(mesh.loops, "vertex_index", len(mesh.loops), np.int32)
        co = _column(mesh.vertices, "co", 3 * len(mesh.vertices), np.float32).reshape(-1, 3)
        if hasattr(mesh, "corner_normals"):
            normal = _column(mesh.corner_normals, "vector", 3 * len(mesh.loops), np.float32).reshape(-1, 3)
        else:
            normal = _column(mesh.loops, "normal", 3 * len(mesh.loops), np.float32).reshape(-1, 3)
        layers = {None: active_uv} if active_uv else {}
        layers.update({n: n for n in uv_names if n in mesh.uv_layers})
        uvs = {k: _column(mesh.uv_layers[n].data, "uv", 2 * len(mesh.loops), np.float32).reshape(-1, 2)
               for k, n in layers.items()}
        colour = _colours(mesh, colour_name, vertex)
        self._weld(vertex, co, normal, uvs, colour)

    def _weld(self, vertex, co, normal, uvs, colour):
        used = self.corners.ravel()
        parts = [vertex[:, None].view(np.int32), np.round(normal * 32767).astype(np.int32)]
        parts += [uv.view(np.int32) for uv in uvs.values()] + ([colour.view(np.int32)] if colour is not None else [])
        rows = np.ascontiguousarray(np.hstack(parts)[used])
        keys = rows.view(np.dtype((np.void, rows.shape[1] * 4))).ravel()
        _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        loop = used[first]
        self.triangles = inverse.reshape(-1, 3).astype(np.uint32)
        self.positions, self.normals = co[vertex[loop]], normal[loop]
        self.uvs = {k: uv[loop] for k, uv in uvs.items()}
        self.colours = None if colour is None else colour[loop]


def _column(collection, name, count, dtype):
    values = np.empty(count, dtype)
    collection.foreach_get(name, values)
    return values


def _colours(mesh, name, vertex):
    attribute = mesh.color_attributes.get(name) if name else None
    if attribute is None and name == "":
        attribute = mesh.color_attributes.active_color
    if attribute is None:
        return None
    values = _column(attribute.data, "color", 4 * len(attribute.data), np.float32).reshape(-1, 4)
    values = values[vertex] if attribute.domain == "POINT" else values
    values[:, 3] = 1
    return np.ascontiguousarray(np.clip(values, 0, 1))


class BakedPart:
    """How a primitive of the file relates to the mesh of an object that is baked."""

    def __init__(self, object_name, primitive, data, chosen, material, vertices):
        self.object_name, self.primitive, self.data = object_name, primitive, data
        self.chosen, self.material = chosen, material  # triangles of the mesh, in the file's order; a name or None
        self.vertices = vertices  # of the data, in the file's order


class SceneExport:
    """Writes `scene.glb` and its surroundings into a folder.

    After write(): path, environment (or None), camera (its name or None), triangles, lamps, parts.
    """

    def __init__(self, depsgraph, folder, report, for_baking=False):
        self.depsgraph, self.folder, self.report, self.for_baking = depsgraph, folder, report, for_baking
        self.scene = depsgraph.scene
        # without the name of the host: `--light-units auto` takes files of its exporter for photometric ones
        self.writer = GlbWriter("Resolvent add-on")
        self.makers = MaterialMaker(self.writer, report)
        self.meshes, self.suns, self.parts = {}, [], []
        self.triangles, self.lamps, self.camera, self.glowing = 0, 0, None, False

    def write(self):
        """Raises CannotRender with one line where there is nothing to show or to write to."""
        for instance in self.depsgraph.object_instances:
            self._add_instance(instance)
        self._add_camera()
        self._check_libraries()
        if not self.triangles:
            raise CannotRender("the scene has no surfaces that are rendered: add a mesh, or turn on its visibility in "
                               "renders")
        try:
            self.environment = write_environment(self.scene.world, self.suns, self.folder, self.report)
            self.path = os.path.join(self.folder, "scene.glb")
            self.writer.write(self.path)
        except OSError as error:
            raise CannotRender(f"cannot write the scene to {self.folder}: {error.strerror}; choose another temporary "
                               "folder in Blender's preferences") from error
        self.glowing = any("emissiveFactor" in m for m in self.writer.document.get("materials", []))
        if not self.lamps and not self.glowing and self.environment is None:
            self.report.note("nothing emits light: there is no lamp, no emissive material, and the world is black")

    def _check_libraries(self):
        missing = sorted({os.path.basename(l.filepath) for l in bpy.data.libraries if getattr(l, "is_missing", False)
                          or not os.path.exists(bpy.path.abspath(l.filepath, library=l.library))})
        if missing:
            self.report.note(f"linked libraries are missing, and what is in them is not shown: {', '.join(missing)}")

    # ---- objects ------------------------------------------------------------------------------------

    def _add_instance(self, instance):
        ob = instance.object
        if not instance.show_self and not instance.is_instance:
            return
        if ob.type == "LIGHT":
            self.lamps += 1
            add_lamp(self.writer, ob.name, ob.data, world_matrix(instance.matrix_world), self.suns, self.report)
        elif ob.type in MESH_TYPES:
            self._add_surface(instance)
        elif ob.type in {"VOLUME", "GPENCIL", "CURVES", "POINTCLOUD", "LIGHT_PROBE"}:
            if ob.type != "LIGHT_PROBE":
                self.report.note(f"object '{ob.name}': {ob.type.lower()} objects are not shown")
        self._note_visibility(ob)

    def _note_visibility(self, ob):
        off = [n for n in ("camera", "diffuse", "glossy", "transmission", "shadow") if not getattr(ob, f"visible_{n}")]
        if off and ob.type in MESH_TYPES:
            self.report.note(f"object '{ob.name}': its ray visibility ({', '.join(off)} off) is ignored")
        if ob.type in MESH_TYPES and (ob.is_holdout or ob.is_shadow_catcher):
            self.report.note(f"object '{ob.name}': it is shown as a surface, not as holdout or shadow catcher")
        for system in ob.particle_systems if hasattr(ob, "particle_systems") else ():
            if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                self.report.note(f"object '{ob.name}': hair is not shown")

    def _add_surface(self, instance):
        ob = instance.object
        alone = self.for_baking and not instance.is_instance and ob.type == "MESH"
        key = (ob.data.as_pointer() if ob.data else 0, ob.type,
               tuple(s.material.name_full if s.material else "" for s in ob.material_slots))
        if alone:
            key += (ob.name_full,)
        if self.for_baking and not alone:
            self.report.note(f"object '{ob.name}': instances, curves and texts are lit, but keep no baked light; make "
                             "meshes of them first")
        if key not in self.meshes:
            self.meshes[key] = self._add_mesh(ob, alone)
        mesh, count = self.meshes[key]
        if mesh is None:
            return
        matrix = world_matrix(instance.matrix_world)
        if not np.isfinite(matrix).all() or not np.abs(matrix[:3, :3]).any():
            self.report.note(f"object '{ob.name}': its transform is not usable; it is left out")
            return
        self.triangles += count
        self.writer.add_root({"name": ob.name, "mesh": mesh, "matrix": matrix.T.ravel().tolist()})

    def _add_mesh(self, ob, alone):
        """(index or None, triangles)"""
        mesh = ob.to_mesh()
        if mesh is None:
            return None, 0
        try:
            if self.triangles + len(mesh.polygons) > MOST_TRIANGLES:
                raise CannotRender(f"object '{ob.name}' brings the scene above {MOST_TRIANGLES} triangles; simplify its "
                                   "modifiers")
            materials = [s.material for s in ob.material_slots] or [None]
            indices = [self.makers.index(m) for m in materials]
            names = [m.name_full for m in materials if m]
            uv_names = [n for name in names for n in self.makers.uv_names.get(name, [])]
            colours = [self.makers.colour_names[n] for n in names if n in self.makers.colour_names]
            active = next((l.name for l in mesh.uv_layers if l.active_render), None)
            if self.for_baking and not uv_names:
                uv_names = [n for n in LIGHTMAP_NAMES if n in mesh.uv_layers and n != active][:1]
            data = MeshData(mesh, active, uv_names[:1], colours[0] if colours else None)
            if len(set(uv_names)) > 1:
                self.report.note(f"object '{ob.name}': its materials name several UV maps, of which one is used")
        finally:
            ob.to_mesh_clear()
        return self._write_mesh(ob, data, materials, indices, alone)

    def _write_mesh(self, ob, data, materials, indices, alone):
        if not len(data.triangles):
            return None, 0
        if not np.isfinite(data.positions).all():
            self.report.note(f"object '{ob.name}': vertices are not finite; it is left out")
            return None, 0
        primitives, slots = [], np.clip(data.materials, 0, len(indices) - 1)
        for slot in np.unique(slots):
            chosen = np.flatnonzero(slots == slot)
            primitive, vertices = self._write_primitive(data, chosen, indices[slot], alone)
            if alone:
                name = materials[slot].name_full if materials[slot] else None
                self.parts.append(BakedPart(ob.name, len(primitives), data, chosen, name, vertices))
            primitives.append(primitive)
        return self.writer.add("meshes", {"name": ob.name, "primitives": primitives}), len(data.triangles)

    def _write_primitive(self, data, chosen, material, alone):
        vertices, triangles = np.unique(data.triangles[chosen], return_inverse=True)
        attributes = {"POSITION": self.writer.add_attribute(data.positions[vertices], True)}
        normals = data.normals[vertices]
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        if (lengths > 0.5).all():
            attributes["NORMAL"] = self.writer.add_attribute(normals / lengths)
        for name, uv in data.uvs.items():
            attributes["TEXCOORD_0" if name is None else "TEXCOORD_1"] = self.writer.add_attribute(
                uv[vertices] * (1, -1) + (0, 1))
        if "TEXCOORD_1" in attributes and "TEXCOORD_0" not in attributes:
            attributes["TEXCOORD_0"] = attributes["TEXCOORD_1"]
        if data.colours is not None:
            attributes["COLOR_0"] = self.writer.add_attribute(data.colours[vertices])
        if alone:
            attributes["_VERTEX"] = self.writer.add_attribute(np.arange(len(vertices), dtype=np.float32))
        return {"attributes": attributes, "indices": self.writer.add_indices(triangles), "material": material}, vertices

    # ---- camera -------------------------------------------------------------------------------------

    def _add_camera(self):
        ob = self.scene.camera
        if ob is None or ob.type != "CAMERA":
            return
        lens, ratio = camera_lens(ob.data, self.scene.render, self.report)
        self.writer.add("cameras", dict(lens, name=ob.name))
        matrix = world_matrix(ob.evaluated_get(self.depsgraph).matrix_world)
        lengths = np.linalg.norm(matrix[:3, :3], axis=0)
        matrix[:3, :3] /= np.where(lengths > 0, lengths, 1)
        self.camera, self.aspect = ob.name, ratio
        self.writer.add_root({"name": ob.name, "camera": 0, "matrix": matrix.T.ravel().tolist()})


def picture_size(render):
    """Pixels of the whole picture."""
    share = render.resolution_percentage / 100
    return max(int(render.resolution_x * share), 1), max(int(render.resolution_y * share), 1)


def camera_lens(camera, render, report):
    """(camera of glTF without its name, width / height) of a camera for this picture."""
    width, height = picture_size(render)
    ratio = width * render.pixel_aspect_x / (height * render.pixel_aspect_y)
    if abs(render.pixel_aspect_x - render.pixel_aspect_y) > 1e-6:
        report.note("pixels that are not square are shown square")
        ratio = width / height
    across = camera.sensor_fit == "HORIZONTAL" or (camera.sensor_fit == "AUTO" and ratio >= 1)
    if camera.type == "ORTHO":
        half = camera.ortho_scale / 2
        ymag = half / ratio if across else half
        return {"type": "orthographic", "orthographic": {"xmag": ymag * ratio, "ymag": ymag, "znear": 0,
                                                         "zfar": max(camera.clip_end, 1e-3)}}, ratio
    sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width
    half = sensor / (2 * camera.lens)
    yfov = 2 * math.atan(half / ratio if across else half)
    return {"type": "perspective", "perspective": {"yfov": yfov, "aspectRatio": ratio,
                                                   "znear": max(camera.clip_start, 1e-6)}}, ratio


def camera_options(ob, depsgraph, render, mode, report):
    """Options of `resolvent render` for what glTF's cameras do not have."""
    camera, options = ob.data, []
    width, height = picture_size(render)
    longer = width if camera.sensor_fit == "HORIZONTAL" or (camera.sensor_fit == "AUTO" and width >= height) else height
    for name, shift, side in (("--shift-x", camera.shift_x, width), ("--shift-y", camera.shift_y, height)):
        if shift:
            options += [name, repr(shift * longer / side)]
    if camera.type == "PANO":
        kind = (camera if hasattr(camera, "panorama_type") else camera.cycles).panorama_type
        if kind == "EQUIRECTANGULAR":
            return ["--projection", "equirectangular"]
        if kind == "FISHEYE_EQUIDISTANT":
            return ["--projection", "fisheye"]
        report.note(f"camera '{ob.name}': panoramas of kind {kind.lower()} are shown as perspective ones")
    dof = camera.dof
    if dof.use_dof and camera.type == "PERSP" and dof.aperture_fstop > 0:
        # Blender: aperture = focal length / f-number; the program: the same on film of 24 mm height
        lens, _ = camera_lens(camera, render, report)
        focal = 12 / math.tan(lens["perspective"]["yfov"] / 2)
        options += ["--fstop", repr(dof.aperture_fstop * focal / camera.lens), "--focus", repr(focus_distance(ob, dof))]
    return options


def focus_distance(ob, dof):
    if dof.focus_object is None:
        return max(dof.focus_distance, 1e-3)
    axis = ob.matrix_world.to_3x3().col[2].normalized()
    return max(-(dof.focus_object.matrix_world.translation - ob.matrix_world.translation).dot(axis), 1e-3)
