## Does what steps.json lists, for tests/test_godot4.sh: opens files, changes lights, answers with what is drawn.
extends Node3D

const BakedGltf = preload("res://addons/resolvent/baked_gltf.gd")
const ProbeGrid = preload("res://addons/resolvent/probe_grid.gd")
const ProbeLight = preload("res://addons/resolvent/probe_light.gd")

var _shown: Node = null


func _ready() -> void:
	GLTFDocument.register_gltf_document_extension(BakedGltf.new(), true)
	for step: Dictionary in JSON.parse_string(FileAccess.get_file_as_string("res://steps.json")):
		if step.has("file"):
			_open(step.file)
		for light in step.get("lights", []):
			var color := Color(light[2], light[3], light[4]).linear_to_srgb()
			_shown.get_node("BakedLight").set_light(light[0], light[1], color)
		if step.has("sky"):
			_shown.get_node("BakedLight").set_sky_rotation(step.sky)
		if step.has("ball"):
			_add_ball(step)
		await _draw(step.name)
	print("STEPS DONE")


func _open(file: String) -> void:
	if _shown:
		_shown.free()
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	var error := document.append_from_file("res://" + file, state)
	_shown = document.generate_scene(state) if error == OK else Node3D.new()
	add_child(_shown)
	var cameras := _shown.find_children("*", "Camera3D", true, false)
	if cameras:
		cameras[0].current = true
	var baked := _shown.get_node_or_null("BakedLight")
	print("OPENED %s: %s, lights %s" % [file, error_string(error), baked.light_names if baked else "none"])


## A white ball lit by probes, and what they say is there.
func _add_ball(step: Dictionary) -> void:
	var ball := MeshInstance3D.new()
	ball.mesh = SphereMesh.new()
	ball.mesh.radius = step.radius
	ball.mesh.height = 2 * step.radius
	ball.position = Vector3(step.ball[0], step.ball[1], step.ball[2])
	_shown.add_child(ball)
	var probes := ProbeLight.new()
	probes.baked_light = "../BakedLight"
	probes.read("res://" + step.probes)
	_shown.add_child(probes)
	probes.add_object(ball)
	var grid: Dictionary = ProbeGrid.read("res://" + step.probes)
	var as_baked: Array = ProbeGrid.irradiance(ProbeGrid.at(grid, ball.position), Vector3.UP)
	print("PROBES %s as baked %s" % [probes.irradiance(ball.position, Vector3.UP), as_baked])


func _draw(picture: String) -> void:
	for k in 4:
		await RenderingServer.frame_post_draw
	var png := get_viewport().get_texture().get_image().save_png_to_buffer()
	print("PICTURE %s %s" % [picture, Marshalls.raw_to_base64(png)])
