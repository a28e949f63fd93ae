# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates the nodes of a file's one world with Cycles: blender -b FILE -P bake_world.py -- OUT.exr WIDTH HEIGHT"""
import math
import sys

import bpy
import numpy as np

path, width, height = sys.argv[sys.argv.index("--") + 1:]
scene = bpy.data.scenes.new("world")
scene.world = bpy.data.worlds[0]
scene.render.engine = "CYCLES"
scene.cycles.samples, scene.cycles.use_denoising = 16, False
scene.cycles.use_adaptive_sampling = False
scene.render.resolution_x, scene.render.resolution_y = int(width), int(height)
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = path
camera = bpy.data.cameras.new("all around")
camera.type = "PANO"
(camera if hasattr(camera, "panorama_type") else camera.cycles).panorama_type = "EQUIRECTANGULAR"
scene.camera = bpy.data.objects.new("all around", camera)
scene.camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)  # looks along +x
scene.collection.objects.link(scene.camera)
bpy.ops.render.render(write_still=True, scene=scene.name)
image = bpy.data.images.load(path)
pixels = np.empty(int(width) * int(height) * image.channels, np.float32)
image.pixels.foreach_get(pixels)
np.save(path + ".npy", pixels.reshape(int(height), int(width), image.channels)[::-1, :, :3])
