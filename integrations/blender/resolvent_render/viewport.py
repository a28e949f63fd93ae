# SPDX-License-Identifier: GPL-3.0-or-later
"""The live viewport: solved light on the meshes, relit while lamps are moved and recoloured.

The program solves the scene once, in the background, and bakes what each lamp does by itself. Another strength or
colour of a lamp is then a sum; for a lamp in another place, direct light is traced to the elements, and bounces through
the operator follow. When nothing has changed for a while, the program solves again.
"""
import os
import time

import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from .formats import GlbFile
from .lamps import SPOT_EXPONENT, area_outline, lamp_power
from .program import Run, Scratch, find_program
from .relight import Basis, Operator, direct_light
from .report import CannotRender, Report
from .scene_export import Y_UP, SceneExport

ELEMENTS = 3000
SWEEPS = 2  # per frame, after a lamp was moved
FRAMES = 6  # until bounces have settled
REST_SECONDS = 1.0
POLL_SECONDS = 0.1
LIFT = 1e-3  # of shadow rays, metres

VERTEX = """
void main() {
    shade = color;
    gl_Position = matrix * vec4(position, 1.0);
}
"""
FRAGMENT = "void main() { fragment = vec4(shade, 1.0); }"


def make_shader():
    info, interface = gpu.types.GPUShaderCreateInfo(), gpu.types.GPUStageInterfaceInfo("resolvent_shade")
    interface.smooth("VEC3", "shade")
    info.push_constant("MAT4", "matrix")
    info.vertex_in(0, "VEC3", "position")
    info.vertex_in(1, "VEC3", "color")
    info.vertex_out(interface)
    info.fragment_out(0, "VEC4", "fragment")
    info.vertex_source(VERTEX)
    info.fragment_source(FRAGMENT)
    return gpu.shader.create_from_info(info)


def lamp_state(ob):
    """What a lamp sends, {field: value} comparable, in the program's coordinates."""
    matrix, light = Y_UP @ np.array(ob.matrix_world), ob.data
    power = lamp_power(light, ob.name, Report())
    axes = matrix[:3, :3] / np.maximum(np.linalg.norm(matrix[:3, :3], axis=0), 1e-9)
    lamp = {"kind": {"SUN": "directional", "SPOT": "spot", "AREA": "area"}.get(light.type, "point"),
            "position": matrix[:3, 3], "direction": -axes[:, 2], "power": power,
            "intensity": power if light.type == "SUN" else power / (4 * np.pi)}
    if light.type == "SPOT":
        outer = np.cos(light.spot_size / 2)
        lamp["cones"], lamp["exponent"] = (outer + (1 - outer) * light.spot_blend, outer), SPOT_EXPONENT
    if light.type == "AREA":
        lamp["intensity"] = power / 4
        outline = area_outline(light)
        lamp["samples"] = [matrix[:3, :3] @ (p * 0.5) + matrix[:3, 3] for p in outline[::max(len(outline) // 4, 1)]]
    return lamp


def same_place(a, b):
    keys = ("position", "direction", "cones", "samples")
    return a["kind"] == b["kind"] and all(np.allclose(a[k], b[k], atol=1e-6) for k in keys if k in a and k in b)


def shown_part(file, primitive, matrix):
    """What is drawn of a primitive: positions in world space, triangles, receivers (-1 = none), base colours, emission."""
    attributes, material = primitive["attributes"], file.document["materials"][primitive["material"]]
    positions = file.accessor(attributes["POSITION"]) @ matrix[:3, :3].T + matrix[:3, 3]
    first = primitive.get("extras", {}).get("resolvent_first_receiver")
    colours = np.broadcast_to(material["pbrMetallicRoughness"].get("baseColorFactor", (1, 1, 1, 1))[:3], positions.shape)
    if "_COLOR" in attributes:
        colours = colours * file.accessor(attributes["_COLOR"])[:, :3]
    strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
    emission = strength * np.array(material.get("emissiveFactor", (0, 0, 0)))
    return {"positions": positions, "triangles": file.accessor(primitive["indices"]).reshape(-1, 3),
            "receivers": np.full(len(positions), -1) if first is None else first + np.arange(len(positions)),
            "colours": colours, "glow": np.broadcast_to(emission, positions.shape)}


def shown_parts(file):
    """All primitives but those of lamps."""
    for node in file.document["nodes"]:
        if "mesh" not in node:
            continue
        matrix = np.array(node.get("matrix", np.eye(4).ravel())).reshape(4, 4).T
        for primitive in file.document["meshes"][node["mesh"]]["primitives"]:
            own = file.document["materials"][primitive["material"]].get("extras", {}).get("resolvent", {})
            if own.get("camera_emission") != 0:
                yield shown_part(file, primitive, matrix)


class Solved:
    """The files of a solution, and the triangles that show it."""

    def __init__(self, folder, lamps):
        self.lamps = lamps  # {name: lamp_state} as solved
        self.basis = Basis(os.path.join(folder, "live.light.safetensors"))
        self.operator = Operator(os.path.join(folder, "live.operator.safetensors"))
        self.field, self.direct, self.frames_left = None, None, FRAMES
        parts = list(shown_parts(GlbFile(os.path.join(folder, "live.glb"))))
        starts = np.cumsum([0] + [len(part["positions"]) for part in parts])
        join = lambda key: np.concatenate([part[key] for part in parts])  # noqa: E731
        self.positions, self.receivers = join("positions").astype(np.float32), join("receivers")
        self.albedo, self.glow = (join(key).astype(np.float32) for key in ("colours", "glow"))
        self.albedo /= np.float32(np.pi)
        self.triangles = np.concatenate([part["triangles"] + start for part, start in zip(parts, starts)]).astype(np.int32)
        self.tree = BVHTree.FromPolygons(self.positions.tolist(), self.triangles.tolist())

    def is_hidden(self, point, towards, distance):
        start = Vector(point) + LIFT * Vector(towards)
        reach = 1e9 if np.isinf(distance) else max(distance - 2 * LIFT, 0)
        return self.tree.ray_cast(start, Vector(towards), reach)[0] is not None

    def scales(self, lamps):
        """{name: scale} of lamps that stay where they were; those that moved get 0."""
        result = {}
        for name, old in self.lamps.items():
            new = lamps.get(name)
            if new is None or not same_place(old, new):
                result[name] = np.zeros(3)
            else:
                result[name] = new["power"] / np.where(old["power"] > 0, old["power"], 1)
        return result

    def moved(self, lamps):
        return [n for n in lamps if n not in self.lamps or not same_place(self.lamps[n], lamps[n])]

    def irradiance(self, lamps):
        """(receivers, 3) under these lamps; for those in new places, as far as light has bounced by now."""
        light = self.basis.light(self.scales(lamps))
        away = self.moved(lamps)
        if not away:
            self.field = None
            return light
        if self.frames_left >= FRAMES - 1:  # just moved: one sample, then all of them
            self.direct = self.trace(lamps, away, most=1 if self.frames_left == FRAMES else None)
        start = self.direct if self.field is None else self.field
        self.field = self.operator.solve(self.direct, start, SWEEPS)
        return light + self.operator.receive(self.field)

    def trace(self, lamps, names, most):
        """(elements, 3): direct light of these lamps, by at most so many samples of each."""
        result = np.zeros(self.operator.positions.shape, np.float32)
        for name in names:
            lamp = dict(lamps[name])
            if most and "samples" in lamp:
                lamp["samples"] = [lamp["position"]]
            result += direct_light(lamp, self.operator.positions, self.operator.normals, self.is_hidden)
        return result

    def colours(self, lamps):
        """(vertices, 3): radiance."""
        light = self.irradiance(lamps)
        seen = light[np.maximum(self.receivers, 0)]
        seen[self.receivers < 0] = light.mean(axis=0) if len(light) else 0  # metal and glass
        return self.albedo * seen + self.glow


class Live:
    """One viewport's state: what is being solved, and what is drawn."""

    def __init__(self):
        self.scratch, self.run, self.solved, self.pending = None, None, None, None
        self.lamps, self.error, self.wanted, self.changed = {}, None, True, 0.0
        self.shader = self.batch = self.offscreen = None
        self.relight_seconds = self.cpu_seconds = 0.0
        self.stale = True

    def begin(self, depsgraph):
        """Starts to solve the scene as it is."""
        self.stop()
        self.wanted = False
        self.scratch = Scratch()
        folder = self.scratch.__enter__()
        self.pending = {o.name: lamp_state(o) for o in lamp_objects(depsgraph)}
        export = SceneExport(depsgraph, folder, Report())
        export.write()
        command = [find_program(), "bake", export.path, "-o", os.path.join(folder, "live.glb"), "--to", "vertex",
                   "--basis", "--operator", "--quality", "draft", "--max-elements", str(ELEMENTS), "--light-units", "watt"]
        self.run = Run(command + (["--env", export.environment] if export.environment else []))

    def poll(self):
        """Whether there is something new to draw."""
        if self.run is None or not self.run.poll():
            return False
        self.run = None
        self.solved = Solved(self.scratch.folder, self.pending)
        self.scratch.__exit__()
        self.scratch, self.batch, self.stale = None, None, True
        return True

    def stop(self):
        if self.run is not None:
            self.run.stop()
            self.run = None
        if self.scratch is not None:
            self.scratch.__exit__()
            self.scratch = None

    def relight(self):
        start, cpu = time.perf_counter(), time.thread_time()
        colours = np.ascontiguousarray(self.solved.colours(self.lamps), np.float32)
        self.upload(colours)
        self.relight_seconds, self.cpu_seconds = time.perf_counter() - start, time.thread_time() - cpu
        self.stale = self.solved.field is not None and self.solved.frames_left > 0
        self.solved.frames_left -= 1

    def upload(self, colours):
        if self.shader is None:
            self.shader = make_shader()
        layout = gpu.types.GPUVertFormat()
        layout.attr_add(id="position", comp_type="F32", len=3, fetch_mode="FLOAT")
        layout.attr_add(id="color", comp_type="F32", len=3, fetch_mode="FLOAT")
        vertices = gpu.types.GPUVertBuf(len=len(colours), format=layout)
        vertices.attr_fill(id="position", data=self.solved.positions)
        vertices.attr_fill(id="color", data=colours)
        indices = gpu.types.GPUIndexBuf(type="TRIS", seq=self.solved.triangles)
        self.batch = gpu.types.GPUBatch(type="TRIS", buf=vertices, elem=indices)

    def draw(self, engine, context, scene):
        region, view = context.region, context.region_data
        size = region.width, region.height
        if self.offscreen is None or (self.offscreen.width, self.offscreen.height) != size:
            self.offscreen = gpu.types.GPUOffScreen(*size, format="RGBA16F")
        matrix = view.window_matrix @ view.view_matrix @ Matrix(Y_UP.T.tolist())
        with self.offscreen.bind():
            gpu.state.active_framebuffer_get().clear(color=(0, 0, 0, 1), depth=1.0)
            gpu.state.depth_test_set("LESS_EQUAL")
            gpu.state.depth_mask_set(True)
            self.shader.bind()
            self.shader.uniform_float("matrix", matrix)
            self.batch.draw(self.shader)
            gpu.state.depth_mask_set(False)
            gpu.state.depth_test_set("NONE")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self.offscreen.texture_color, (0, 0), *size)
        engine.unbind_display_space_shader()


def lamp_objects(depsgraph):
    return [i.object for i in depsgraph.object_instances if i.object.type == "LIGHT"]


LAST = None  # the state of the viewport that was drawn last, for tests


class ViewportEngine:
    """The part of the render engine that draws viewports."""

    live = None

    def view_update(self, context, depsgraph):
        global LAST
        if self.live is None:
            self.live = LAST = Live()
        live = self.live
        live.lamps = {o.name: lamp_state(o) for o in lamp_objects(depsgraph)}
        live.stale = True
        if live.solved is not None:
            live.solved.frames_left = FRAMES
        for update in depsgraph.updates:
            lamp = isinstance(update.id, bpy.types.Light) or \
                isinstance(update.id, bpy.types.Object) and update.id.type in {"LIGHT", "CAMERA"}
            passive = isinstance(update.id, (bpy.types.Scene, bpy.types.Camera, bpy.types.Collection))
            if not (lamp or passive):
                live.wanted = True
        live.changed = time.monotonic()

    def view_draw(self, context, depsgraph):
        live = self.live
        try:
            self.advance(live, depsgraph)
        except CannotRender as error:
            live.error, live.run = str(error), None
        self.update_stats("Resolvent", self.status(live))
        if live.solved is None:
            schedule(self)
            return
        if live.stale or live.batch is None:
            live.relight()
        live.draw(self, context, depsgraph.scene)
        if live.stale or live.run is not None or live.wanted or live.solved.moved(live.lamps):
            schedule(self)

    def advance(self, live, depsgraph):
        live.poll()
        at_rest = time.monotonic() - live.changed > REST_SECONDS
        moved = live.solved is not None and live.solved.moved(live.lamps)
        first = live.solved is None and live.run is None and live.error is None
        if first or (at_rest and live.run is None and (live.wanted or moved)):
            live.error = None
            live.begin(depsgraph)

    @staticmethod
    def status(live):
        if live.error:
            return live.error
        if live.run is not None:
            return f"solving {100 * live.run.share:.0f} %"
        return f"relit in {1000 * live.relight_seconds:.0f} ms"


def schedule(engine):
    """Draws again soon."""
    def redraw():
        try:
            engine.tag_redraw()
        except ReferenceError:
            pass  # the viewport is gone
    bpy.app.timers.register(redraw, first_interval=POLL_SECONDS)
