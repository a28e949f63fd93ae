## Shows baked files one after the other, as tests/test_godot4.mjs asks, and answers with what was drawn.
extends Node3D

const BakedGltf = preload("res://addons/resolvent/baked_gltf.gd")

var _shown: Node = null


func _ready() -> void:
	GLTFDocument.register_gltf_document_extension(BakedGltf.new(), true)
	for step in JSON.parse_string(FileAccess.get_file_as_string("res://steps.json")):
		await _show(step)
	print("STEPS DONE")


func _show(step: Dictionary) -> void:
	if step.has("file"):
		if _shown:
			_shown.free()
		var document := GLTFDocument.new()
		var state := GLTFState.new()
		var error := document.append_from_file("res://" + step.file, state)
		_shown = document.generate_scene(state) if error == OK else Node3D.new()
		add_child(_shown)
		var cameras := _shown.find_children("*", "Camera3D", true, false)
		if cameras:
			cameras[0].current = true
		print("OPENED %s: %s" % [step.file, error_string(error)])
	for light in step.get("lights", []):
		var color := Color(light[2], light[3], light[4]).linear_to_srgb()
		_shown.get_node("BakedLight").set_light(light[0], light[1], color)
	for k in 4:
		await RenderingServer.frame_post_draw
	var png := get_viewport().get_texture().get_image().save_png_to_buffer()
	print("PICTURE %s %s" % [step.name, Marshalls.raw_to_base64(png)])
