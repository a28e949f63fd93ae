# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's operators: blender -b --factory-startup -P test_addon.py -- FOLDER [TEST]..."""
import os
import stat
import sys
import time
import traceback

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import scenes  # noqa: E402
from compare_cycles import blocks, cycles, read  # noqa: E402

FOLDER = ""


def small(make=scenes.modifiers, quality="draft"):
    scene = scenes.reset()
    make()
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.resolvent.quality = quality
    return scene


def path(name):
    return os.path.join(FOLDER, name)


def refused(operator, words, **arguments):
    """The operator fails with an error that has these words."""
    try:
        done = operator(**arguments)
    except RuntimeError as error:
        assert words in str(error), f"'{error}' does not say '{words}'"
        return
    raise AssertionError(f"{done}, although '{words}' was expected")


def rendered(name, engine, samples=64):
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = engine, samples, False
    scene.render.filepath = path(name)
    bpy.ops.render.render(write_still=True)
    return read(path(name))


def test_modes():
    scene = small()
    reference = None
    for mode in ("reference", "final", "operator"):
        assert bpy.ops.resolvent.render(mode=mode, filepath=path(mode + ".exr")) == {"FINISHED"}
        picture = blocks(read(path(mode + ".exr")))
        reference = picture if reference is None else reference
        assert abs(picture.mean() / reference.mean() - 1) < 0.03, (mode, picture.mean(), reference.mean())
    assert scene.render.engine != "RESOLVENT"


def test_engine():
    scene = small()
    scene.render.engine = "RESOLVENT"
    scene.render.filepath = path("f12.png")
    scene.render.image_settings.file_format = "PNG"
    bpy.ops.render.render(write_still=True)
    assert os.path.getsize(path("f12.png")) > 1000


def snapshot():
    scene = bpy.context.scene
    return sorted((ob.name, ob.data.name if ob.data else "", len(ob.data.polygons) if ob.type == "MESH" else 0,
                   [s.material.name if s.material else "" for s in ob.material_slots], [s.link for s in ob.material_slots],
                   [(m.name, m.show_render, m.show_viewport) for m in ob.modifiers]) for ob in scene.objects)


def bake_and_compare(target):
    """The bake, seen by Cycles without lamps, is the picture of the path tracer; undone, all is as it was."""
    scene = small(quality="medium")
    if target == "vertex":
        for ob in [o for o in scene.objects if o.type == "MESH"]:
            ob.modifiers.new("Dense", "SUBSURF").subdivision_type = "SIMPLE"
            ob.modifiers["Dense"].levels = ob.modifiers["Dense"].render_levels = 4
    boxes = [o for o in scene.objects if o.name == "rounded"]
    boxes[0].material_slots[0].link = "OBJECT"
    boxes[0].material_slots[0].material = bpy.data.materials["red"]
    before, meshes = snapshot(), len(bpy.data.meshes)
    wanted = blocks(cycles(scene, path("wanted.exr"), 256, 0))
    assert bpy.ops.resolvent.bake(target=target, map_size=512) == {"FINISHED"}
    assert any(m.name.endswith("(baked)") for m in bpy.data.materials)
    lamps = [o for o in scene.objects if o.type == "LIGHT"]
    curves = [o for o in scene.objects if o.type == "CURVE"]
    assert "curve" in scene.resolvent.report
    for ob in lamps:
        ob.hide_render = True
    seen = blocks(rendered(f"baked-{target}.exr", "CYCLES", 64))
    for ob in lamps:
        ob.hide_render = False
    assert curves
    error = np.abs(seen / wanted - 1)
    # the curve, which is in the lowest of three rows, stays black
    assert error[:2].max() < 0.03 and abs(np.median(seen / wanted) - 1) < 0.01, (target, np.round(seen / wanted, 3))
    assert bpy.ops.resolvent.restore() == {"FINISHED"}
    assert snapshot() == before, (snapshot(), before)
    assert len(bpy.data.meshes) == meshes and not [i for i in bpy.data.images if i.name.startswith("Lightmap")]
    assert not [m for m in bpy.data.materials if m.name.endswith("(baked)")]


def test_bake_vertex():
    bake_and_compare("vertex")


def test_bake_lightmap():
    bake_and_compare("lightmap")


def test_bake_again():
    """A second bake starts from the scene as it was before the first."""
    scene = small()
    for _ in range(2):
        assert bpy.ops.resolvent.bake(target="vertex") == {"FINISHED"}
    names = [m.name for m in bpy.data.materials if "(baked)" in m.name]
    assert names and not any(n.count("(baked)") > 1 for n in names), names
    assert scene.objects["rounded"].data.color_attributes.get("Resolvent")


def test_bake_keeps_paint():
    scene = small(scenes.textured)
    assert bpy.ops.resolvent.bake(target="vertex", into_materials=False) == {"FINISHED"}
    mesh = scene.objects["painted"].data
    assert mesh.color_attributes.get("Paint") and mesh.color_attributes.get("Resolvent")
    light = np.empty(4 * len(mesh.loops), np.float32)
    mesh.color_attributes["Resolvent"].data.foreach_get("color", light)
    light = light.reshape(-1, 4)[:, :3]
    hue = light.mean(axis=0) / light.mean()  # the paint's is 0.65, 1.2, 1.15 times that; walls are red and green
    print("hue of the light", hue)
    assert np.abs(hue - 1).max() < 0.12, "the paint is in the light"


def test_export():
    scene = small(scenes.area_shapes)
    out = path("relightable")
    assert bpy.ops.resolvent.export(filepath=out, target="vertex") == {"FINISHED"}
    from resolvent_render.formats import GlbFile
    document = GlbFile(out + ".glb").document
    assert "Blender" not in document["asset"]["generator"], "its lights would be taken for candela"
    assert {"floor", "disk"} <= {n.get("name") for n in document["nodes"]}
    with open(out + ".light.safetensors", "rb") as file:
        header = file.read(4096)
    assert all(name.encode() in header for name in ("disk", "strip", "ellipse")), header[:1000]
    assert scene.resolvent.report == "" or "curve" not in scene.resolvent.report


def test_reports():
    """What cannot be handed over is named."""
    scene = small(scenes.spots)
    lamp = scene.objects["spot"].data
    lamp.shadow_soft_size, lamp.use_square = 0.2, True
    m = scenes.material("odd", Color=(1, 1, 1))
    noise = m.node_tree.nodes.new("ShaderNodeTexNoise")
    m.node_tree.links.new(noise.outputs["Color"], m.node_tree.nodes["Diffuse BSDF"].inputs["Color"])
    scene.objects["floor"].data.materials[0] = m
    hair = scenes.material("toon", "ShaderNodeBsdfToon")
    scene.objects["back"].data.materials[0] = hair
    lost = bpy.data.images.new("lost", 4, 4)
    lost.source, lost.filepath = "FILE", "//nowhere/lost.png"
    m = scenes.material("missing", Color=(1, 1, 1))
    texture = m.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = lost
    m.node_tree.links.new(texture.outputs["Color"], m.node_tree.nodes["Diffuse BSDF"].inputs["Color"])
    scene.objects["left"].data.materials[0] = m
    scene.render.film_transparent = True
    assert bpy.ops.resolvent.render(mode="operator", filepath=path("odd.exr")) == {"FINISHED"}
    for words in ("radius of spots", "square spots", "Noise Texture", "Toon BSDF", "'lost'", "transparent"):
        assert words in scene.resolvent.report, (words, scene.resolvent.report)


def test_bad_input():
    bpy_render, bpy_bake, bpy_export = bpy.ops.resolvent.render, bpy.ops.resolvent.bake, bpy.ops.resolvent.export
    scene = small()
    scene.camera = None
    refused(bpy_render, "no camera")
    scene = scenes.reset()
    scenes.camera((0, -5, 0), (0, 0, 0))
    refused(bpy_render, "no surfaces")
    refused(bpy_bake, "no surfaces")
    scene = small()
    refused(bpy_export, "save it", filepath="//x.glb")
    refused(bpy_export, "no folder", filepath=path("nowhere/x.glb"))
    locked = path("locked")
    os.makedirs(locked, exist_ok=True)
    os.chmod(locked, stat.S_IRUSR | stat.S_IXUSR)
    if not os.access(locked, os.W_OK):  # root may write everywhere
        refused(bpy_export, "cannot be written", filepath=locked + "/x.glb")
    open(path("file"), "w").close()
    refused(bpy_render, "file", mode="reference", samples=1, filepath=path("file/x.exr"))
    bpy.context.preferences.addons["resolvent_render"].preferences.program = "/nowhere/resolvent"
    refused(bpy_render, "not a program", filepath=path("none.exr"))
    assert not os.path.exists(path("none.exr"))
    assert scene.render.engine != "RESOLVENT"


def test_no_light():
    """Without lamps and with a black world, pictures are black and the report says why."""
    scene = small()
    for ob in [o for o in scene.objects if o.type == "LIGHT"]:
        bpy.data.objects.remove(ob)
    assert bpy.ops.resolvent.render(mode="reference", samples=1, filepath=path("dark.exr")) == {"FINISHED"}
    assert "nothing emits light" in scene.resolvent.report and read(path("dark.exr")).max() == 0
    scene = small(scenes.glass)
    scenes.bpy.data.objects["floor"].hide_render = True


def test_missing_library():
    """Objects of a library that is gone are named; the rest is rendered."""
    scenes.reset()
    scenes.box("linked", (0, 0, 0), (1, 1, 1), scenes.material("m"))
    library = path("library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=library)
    small()
    with bpy.data.libraries.load(library, link=True) as (found, to):
        to.objects = ["linked"]
    bpy.context.scene.collection.objects.link(bpy.data.objects["linked"])
    file = path("user.blend")
    bpy.ops.wm.save_as_mainfile(filepath=file)
    os.remove(library)
    bpy.ops.wm.open_mainfile(filepath=file)
    scene = bpy.context.scene
    assert bpy.ops.resolvent.render(mode="reference", samples=1, filepath=path("linked.exr")) == {"FINISHED"}
    assert "libraries are missing" in scene.resolvent.report, scene.resolvent.report


def test_cancel():
    """A run that is stopped ends at once and leaves nothing behind."""
    scene = small()
    scene.render.resolution_x, scene.render.resolution_y = 320, 240
    from resolvent_render import engine
    from resolvent_render.program import Cancelled, Run, Scratch
    from resolvent_render.report import Report
    from resolvent_render.scene_export import SceneExport
    with Scratch() as folder:
        export = SceneExport(bpy.context.evaluated_depsgraph_get(), folder, Report())
        export.write()
        engine.asked.update(mode="reference", samples=4000)
        try:
            run = Run(engine.picture_command(export, os.path.join(folder, "picture.exr")))
        finally:
            engine.asked.clear()
        start, phases = time.time(), []
        try:
            run.wait(lambda share, phase: phases.append(phase), lambda: any(phases) or time.time() > start + 60)
            raise AssertionError("it was not stopped")
        except Cancelled:
            pass
        assert run.process.returncode not in (None, 0)
        assert any(phases), "no progress was shown"
        assert not os.path.exists(os.path.join(folder, "picture.exr"))
    assert not os.path.exists(folder)


def test_live():
    """What the viewport shows after a lamp was recoloured and moved is what a new solution has."""
    from resolvent_render.viewport import FRAMES, Live, Solved, lamp_objects, lamp_state

    def solved():
        depsgraph = bpy.context.evaluated_depsgraph_get()
        live = Live()
        live.begin(depsgraph)
        live.run.wait()
        result = Solved(live.scratch.folder, live.pending)
        live.run = None
        live.stop()
        return result, {o.name: lamp_state(o) for o in lamp_objects(depsgraph)}

    def mean_radiance(s, lamps):
        for s.frames_left in range(FRAMES, 0, -1):
            colours = s.colours(lamps)
        corner = [s.positions[s.triangles[:, k]] for k in range(3)]
        area = np.linalg.norm(np.cross(corner[1] - corner[0], corner[2] - corner[0]), axis=1)
        return (colours[s.triangles].mean(axis=1) * area[:, None]).sum(axis=0) / area.sum()

    for make, name in ((scenes.modifiers, "area"), (scenes.point_lamps, "point"), (scenes.spots, "wide")):
        scene = small(make)
        first, _ = solved()
        lamp = scene.objects[name]
        lamp.location.x -= 0.5
        lamp.data.color = (1, 0.5, 0.2)
        second, lamps = solved()
        shown, wanted = mean_radiance(first, lamps), mean_radiance(second, lamps)
        print(make.__name__, "shown / wanted", shown / wanted)
        assert np.abs(shown / wanted - 1).max() < 0.05, (make.__name__, shown, wanted)


def test_unused_extremes():
    """Scales of zero, empty meshes, faces without area and degenerate lamps are passed over."""
    scene = small()
    flat = scenes.box("flat", (0, 0, 1), (1, 1, 1), scenes.material("m"))
    flat.scale = (0, 0, 0)
    scenes.mesh("empty", [], [])
    scenes.mesh("line", [(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)])
    scenes.lamp("AREA", (0, 0, 1), size=0.0, name="nothing")
    scenes.lamp("POINT", (0, 0, 1), energy=-5.0, name="negative")
    assert bpy.ops.resolvent.render(mode="reference", samples=1, filepath=path("odd.exr")) == {"FINISHED"}
    assert np.isfinite(read(path("odd.exr"))).all()
    assert "negative" in scene.resolvent.report


QUICK = "test_live", "test_engine", "test_reports", "test_bad_input", "test_no_light", "test_cancel", "test_unused_extremes"
TESTS = {name: f for name, f in list(globals().items()) if name.startswith("test_")}


def main(folder, *names):
    global FOLDER
    FOLDER = folder
    os.makedirs(folder, exist_ok=True)
    failed = []
    for name in QUICK if names == ("quick",) else names or TESTS:
        start = time.time()
        try:
            TESTS[name]()
            print(f"{name}: passed ({time.time() - start:.1f} s)", flush=True)
        except Exception:
            traceback.print_exc()
            failed.append(name)
            print(f"{name}: FAILED", flush=True)
    sys.stdout.flush()
    sys.exit(bool(failed))


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1:])
