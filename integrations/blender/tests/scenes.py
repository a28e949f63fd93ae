# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes by script: all kinds of lamps, world, area shapes, glass, principled materials, instances, modifiers, mirrors."""
import bpy
import numpy as np

SIZE = 128, 96


def reset():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="resolvent_render")
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Standard"
    return scene


def material(name, shader="ShaderNodeBsdfDiffuse", **inputs):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    tree = m.node_tree
    tree.nodes.clear()
    output, node = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(shader)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    for key, value in inputs.items():
        key = key.replace("_", " ")
        if key in node.inputs:
            socket = node.inputs[key]
            socket.default_value = tuple(value) + (1,) * (len(socket.default_value) - len(value)) \
                if hasattr(value, "__len__") else value
        else:
            setattr(node, key.replace(" ", "_"), value)
    return m


def mesh(name, vertices, faces, material=None):
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, [], faces)
    if material:
        data.materials.append(material)
    ob = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def box(name, centre, size, material, inward=False):
    x, y, z = (s / 2 for s in size)
    vertices = [(i * x, j * y, k * z) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    ob = mesh(name, vertices, [f[::-1] for f in faces] if inward else faces, material)
    ob.location = centre
    return ob


def plane(name, size, material, z=0):
    s = size / 2
    return mesh(name, [(-s, -s, z), (s, -s, z), (s, s, z), (-s, s, z)], [(0, 1, 2, 3)], material)


def sphere(name, centre, radius, material, segments=32):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=centre, segments=segments, ring_count=segments // 2)
    ob = bpy.context.object
    ob.name = name
    for p in ob.data.polygons:
        p.use_smooth = True
    if material:
        ob.data.materials.append(material)
    return ob


def lamp(kind, location=(0, 0, 0), aim=None, name=None, **fields):
    data = bpy.data.lights.new(name or kind.lower(), kind)
    ob = bpy.data.objects.new(name or kind.lower(), data)
    bpy.context.scene.collection.objects.link(ob)
    ob.location = location
    if aim is not None:
        turn_to(ob, aim)
    for key, value in fields.items():
        setattr(data, key, value)
    return ob


def turn_to(ob, aim):
    from mathutils import Vector
    ob.rotation_euler = (Vector(aim) - ob.location).to_track_quat("-Z", "Y").to_euler()


def camera(location, aim, lens=35, **fields):
    data = bpy.data.cameras.new("Camera")
    ob = bpy.data.objects.new("Camera", data)
    bpy.context.scene.collection.objects.link(ob)
    ob.location, data.lens = location, lens
    turn_to(ob, aim)
    for key, value in fields.items():
        setattr(data, key, value)
    bpy.context.scene.camera = ob
    return ob


def world(colour=(0, 0, 0), strength=1.0):
    w = bpy.data.worlds.new("World")
    w.use_nodes = True
    node = next(n for n in w.node_tree.nodes if n.type == "BACKGROUND")
    node.inputs["Color"].default_value = (*colour, 1)
    node.inputs["Strength"].default_value = strength
    bpy.context.scene.world = w
    return w, node


def room(height=3.0):
    """Five walls, 4 m wide, open towards the camera at -y."""
    white = material("white", Color=(0.7, 0.7, 0.7))
    red, green = material("red", Color=(0.6, 0.1, 0.08)), material("green", Color=(0.12, 0.5, 0.15))
    h = height
    for name, corners, m in (
            ("floor", [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], white),
            ("ceiling", [(-2, -2, h), (-2, 2, h), (2, 2, h), (2, -2, h)], white),
            ("back", [(-2, 2, 0), (2, 2, 0), (2, 2, h), (-2, 2, h)], white),
            ("left", [(-2, -2, 0), (-2, 2, 0), (-2, 2, h), (-2, -2, h)], red),
            ("right", [(2, -2, 0), (2, -2, h), (2, 2, h), (2, 2, 0)], green)):
        mesh(name, corners, [(0, 1, 2, 3)], m)
    camera((0, -6.2, 1.5), (0, 0, 1.5), lens=42)
    return white


def point_lamps():
    white = room()
    box("block", (0.6, 0.4, 0.5), (1, 1, 1), white)
    lamp("POINT", (-0.8, 0, 2.2), energy=60, shadow_soft_size=0.1, color=(1, 0.8, 0.6))
    lamp("POINT", (1.2, -1, 1.8), energy=20, shadow_soft_size=0, name="small")


def spots():
    white = room()
    box("block", (0.3, 0.6, 0.4), (0.8, 0.8, 0.8), white)
    lamp("SPOT", (-1, -1, 2.6), (0.2, 0.4, 0), energy=200, spot_size=1.0, spot_blend=0.15, shadow_soft_size=0)
    lamp("SPOT", (1.5, 0, 2.5), (0.5, 1, 0.5), energy=100, spot_size=1.4, spot_blend=1.0, shadow_soft_size=0,
         color=(0.6, 0.8, 1), name="wide")


def suns():
    white = material("white", Color=(0.6, 0.6, 0.6))
    plane("ground", 14, white)
    box("block", (-1, 0, 0.75), (1, 1, 1.5), white)
    sphere("ball", (1, 0.3, 0.6), 0.6, white)
    lamp("SUN", (0, 0, 5), (1, 2, 0), energy=2.5, angle=0.00918, color=(1, 0.9, 0.8))
    lamp("SUN", (0, 0, 5), (-3, 1, 0), energy=1.0, angle=0.25, name="soft")
    world((0.2, 0.3, 0.5), 0.7)
    camera((0, -7, 3.5), (0, 0, 0.5), lens=45)


def area_shapes():
    white = room()
    box("block", (0.4, 0.2, 0.6), (0.8, 0.8, 1.2), white)
    lamp("AREA", (-0.9, 0, 2.7), energy=30, shape="SQUARE", size=0.8)
    lamp("AREA", (1.2, 0.5, 2.6), energy=15, shape="DISK", size=0.5, color=(1, 0.6, 0.3), name="disk")
    tilted = lamp("AREA", (-1.8, -0.5, 1), (0.5, 0.5, 0.5), energy=20, shape="RECTANGLE", size=0.3, size_y=0.9, name="strip")
    tilted.scale = (1.5, 1, 1)
    lamp("AREA", (1.8, -1, 1.2), (0, 1, 1), energy=10, shape="ELLIPSE", size=0.3, size_y=0.7, name="ellipse")


def emissive():
    white = room()
    box("block", (-0.6, 0.5, 0.5), (1, 1, 1), white)
    glow = material("panel", "ShaderNodeEmission", Color=(1, 0.9, 0.7), Strength=6.0)
    panel = plane("panel", 0.8, glow)
    panel.location = (0.8, 0, 1.4)
    panel.rotation_euler = (0.3, 1.2, 0)  # both its sides emit
    mixed = material("warm", "ShaderNodeBsdfPrincipled", Base_Color=(0.5, 0.3, 0.2), Specular=0.0, Roughness=1.0,
                     Emission=(1, 0.4, 0.1), Emission_Strength=1.5)
    sphere("ember", (0.9, 0.6, 0.3), 0.3, mixed)


def environment():
    white = material("white", Color=(0.7, 0.7, 0.7))
    plane("ground", 12, white)
    sphere("ball", (-0.8, 0, 0.7), 0.7, material("clay", Color=(0.6, 0.3, 0.2)))
    sphere("mirror", (0.9, 0.2, 0.7), 0.7, material("mirror", "ShaderNodeBsdfGlossy", Color=(0.9, 0.9, 0.9), Roughness=0.0))
    w, node = world()
    height, width = 64, 128
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    v, u = np.mgrid[0:height, 0:width] / np.array([height, width]).reshape(2, 1, 1)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., 0] = 0.3 + 0.5 * u + 6 * np.exp(-((u - 0.3) ** 2 + (v - 0.7) ** 2) / 0.003)
    pixels[..., 1] = 0.4 + 0.3 * v + 5 * np.exp(-((u - 0.3) ** 2 + (v - 0.7) ** 2) / 0.003)
    pixels[..., 2] = 0.6 - 0.4 * u + 4 * np.exp(-((u - 0.3) ** 2 + (v - 0.7) ** 2) / 0.003)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    tree = w.node_tree
    texture, mapping, where = (tree.nodes.new(k) for k in (
        "ShaderNodeTexEnvironment", "ShaderNodeMapping", "ShaderNodeTexCoord"))
    texture.image = image
    mapping.inputs["Rotation"].default_value = (0.2, 0, 0.9)
    tree.links.new(where.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], node.inputs["Color"])
    node.inputs["Strength"].default_value = 0.8
    camera((0, -6, 2.2), (0, 0, 0.6), lens=45)


def sky_texture():
    white = material("white", Color=(0.7, 0.7, 0.7))
    plane("ground", 12, white)
    box("block", (0, 0, 0.6), (1.2, 1.2, 1.2), white)
    w, node = world()
    sky = w.node_tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type = "PREETHAM" if "PREETHAM" in {i.identifier for i in sky.bl_rna.properties["sky_type"].enum_items} \
        else "NISHITA"
    sky.sun_direction = (0.4, -0.5, 0.7)
    w.node_tree.links.new(sky.outputs[0], node.inputs["Color"])
    node.inputs["Strength"].default_value = 0.05
    camera((0, -6, 2.2), (0, 0, 0.6), lens=45)


def glass():
    room()
    sphere("ball", (-0.6, 0.3, 0.7), 0.7, material("glass", "ShaderNodeBsdfGlass", Color=(1, 1, 1), Roughness=0.0, IOR=1.5), 48)
    sphere("metal", (0.9, 0.8, 0.6), 0.6, material("metal", "ShaderNodeBsdfGlossy", Color=(0.9, 0.6, 0.3), Roughness=0.2), 48)
    lamp("AREA", (0, 0, 2.8), energy=60, shape="SQUARE", size=1.2)


def principled():
    room()
    for k, (rough, specular, metal, base) in enumerate((
            (0.5, 0.5, 0.0, (0.6, 0.6, 0.6)), (0.2, 0.5, 0.0, (0.2, 0.3, 0.7)), (0.9, 0.2, 0.0, (0.7, 0.5, 0.2)),
            (0.4, 0.5, 1.0, (0.8, 0.7, 0.5)))):
        m = material(f"preset {k}", "ShaderNodeBsdfPrincipled", Base_Color=base, Roughness=rough, Specular=specular,
                     Metallic=metal, distribution="MULTI_GGX")
        sphere(f"ball {k}", (-1.35 + 0.9 * k, 0.4, 0.42), 0.42, m, 48)
    plastic = material("plastic", "ShaderNodeBsdfPrincipled", Base_Color=(0.65, 0.65, 0.65), Roughness=0.6)
    bpy.data.objects["back"].data.materials[0] = plastic
    lamp("AREA", (0, -0.3, 2.8), energy=60, shape="DISK", size=1.2)


def instances():
    white = room()
    data = box("tower", (-1.2, 1, 0.4), (0.4, 0.4, 0.8), white).data
    for k in range(3):  # linked duplicates
        ob = bpy.data.objects.new(f"tower {k}", data)
        bpy.context.scene.collection.objects.link(ob)
        ob.location, ob.scale = (-0.4 + 0.8 * k, 1, 0.4), (1, 1 + 0.3 * k, 1)
    group = bpy.data.collections.new("group")
    pyramid = mesh("pyramid", [(-.3, -.3, 0), (.3, -.3, 0), (.3, .3, 0), (-.3, .3, 0), (0.1, 0, .7)],
                   [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)], material("blue", Color=(0.2, 0.3, 0.7)))
    bpy.context.scene.collection.objects.unlink(pyramid)
    group.objects.link(pyramid)
    for k in range(2):  # collection instances, one of them mirrored
        empty = bpy.data.objects.new(f"instance {k}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        bpy.context.scene.collection.objects.link(empty)
        empty.location, empty.scale = (-0.7 + 1.4 * k, -0.4, 0), (1 - 2 * k, 1, 1.3)
    lamp("POINT", (0, -0.5, 2.2), energy=70, shadow_soft_size=0.03)


def modifiers():
    white = room()
    a = box("rounded", (-0.9, 0.4, 0.6), (0.9, 0.9, 0.9), white)
    a.modifiers.new("Subdivision", "SUBSURF").render_levels = 3
    b = box("row", (0.5, 1.2, 0.25), (0.3, 0.3, 0.5), material("blue", Color=(0.2, 0.3, 0.7)))
    array = b.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace = 3, (1.5, 0, 0)
    c = mesh("half", [(0, 0, 0), (0.5, 0, 0), (0.5, 0, 0.8), (0, 0, 0.8)], [(0, 1, 2, 3)], white)
    c.location = (0.9, 0, 0)
    c.modifiers.new("Mirror", "MIRROR")
    c.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.1
    curve = bpy.data.curves.new("curve", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.06
    spline = curve.splines.new("POLY")
    spline.points.add(3)
    for p, co in zip(spline.points, ((-1.5, -0.5, 0.1), (-0.5, -1, 0.5), (0.5, -0.8, 0.1), (1.5, -1, 0.6))):
        p.co = (*co, 1)
    curve.materials.append(material("yellow", Color=(0.7, 0.6, 0.1)))
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("curve", curve))
    lamp("AREA", (0, 0, 2.8), energy=60, shape="SQUARE", size=1.0)


def textured():
    """Images, UV maps, mapping, vertex colours, cut-outs and the shapes of cameras."""
    room()
    rows, columns = np.mgrid[0:64, 0:64]
    image = bpy.data.images.new("squares", 64, 64)
    pixels = np.ones((64, 64, 4), np.float32)
    pixels[..., 0], pixels[..., 1] = 0.3 + 0.6 * ((rows // 8 + columns // 8) % 2), rows / 64
    pixels[..., 2], pixels[..., 3] = columns / 64, (rows // 16 + columns // 16) % 2
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    m = material("picture", Color=(1, 1, 1))
    tree = m.node_tree
    texture, mapping, where = (tree.nodes.new(k) for k in ("ShaderNodeTexImage", "ShaderNodeMapping", "ShaderNodeTexCoord"))
    texture.image, texture.interpolation = image, "Closest"  # Cycles interpolates sRGB codes, Resolvent light
    mapping.inputs["Rotation"].default_value = (0, 0, 0.4)
    mapping.inputs["Scale"].default_value = (2, 1.5, 1)
    mapping.inputs["Location"].default_value = (0.1, 0.3, 0)
    tree.links.new(where.outputs["UV"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    diffuse = next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE")
    tree.links.new(texture.outputs["Color"], diffuse.inputs["Color"])
    back = bpy.data.objects["back"].data
    layer = back.uv_layers.new(name="UVMap")
    for loop, uv in zip(layer.data, ((0, 0), (1, 0), (1, 1), (0, 1))):
        loop.uv = uv
    back.materials[0] = m
    leaf = material("leaf", "ShaderNodeBsdfPrincipled", Base_Color=(0.2, 0.5, 0.1), Specular=0.0, Roughness=1.0)
    tree = leaf.node_tree
    mask = tree.nodes.new("ShaderNodeTexImage")
    mask.image = image
    tree.links.new(mask.outputs["Alpha"], next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Alpha"])
    screen = mesh("screen", [(0, 0, 0), (1.2, 0, 0), (1.2, 0, 1.2), (0, 0, 1.2)], [(0, 1, 2, 3)], leaf)
    screen.data.uv_layers.new(name="UVMap")
    screen.location = (0.2, -0.3, 0)
    painted = box("painted", (-0.9, 0, 0.5), (1, 1, 1), material("painted", Color=(1, 1, 1)))
    colours = painted.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    for k, c in enumerate(colours.data):
        c.color = (0.1 + 0.1 * k, 0.8 - 0.08 * k, 0.3, 1)
    tree = painted.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Paint"
    tree.links.new(node.outputs[0], next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").inputs["Color"])
    lamp("AREA", (0, -0.3, 2.8), energy=60, shape="SQUARE", size=1.0)
    shifted = bpy.context.scene.camera.data
    shifted.shift_x, shifted.shift_y, shifted.sensor_fit = 0.05, -0.03, "VERTICAL"


ALL = {f.__name__: f for f in (point_lamps, spots, suns, area_shapes, emissive, environment, sky_texture, glass, principled,
                               instances, modifiers, textured)}
