## Lights objects that move by the probes of `resolvent bake --to probes`.
##
## Set `source` to NAME.json in the editor, list the objects, and place the node where the baked scene is. If the probes
## were baked with --basis and `baked_light` names the node of the scene, they follow its lights.
@tool
extends Node3D

const BakedMaterial = preload("baked_material.gd")
const LightBasis = preload("light_basis.gd")
const ProbeGrid = preload("probe_grid.gd")

## The file of probes. It is read once; the numbers are stored in this node.
@export_file("*.json") var source := "":
	set = read
## Meshes to light, children included.
@export var objects: Array[NodePath] = []
## The node BakedLight whose changes the probes follow; may be empty.
@export var baked_light: NodePath
@export_storage var grid := {}
@export_storage var light_basis := {}

var _materials: Array[ShaderMaterial] = []
var _meshes: Array[MeshInstance3D] = []
var _light := {}


func _ready() -> void:
	if Engine.is_editor_hint():
		return
	var followed := get_node_or_null(baked_light)
	if followed:
		followed.changed.connect(func() -> void: _relight(followed))
		_relight(followed)
	for path in objects:
		add_object(get_node_or_null(path))


## Reads probes, and their basis if there is one beside them.
func read(path: String) -> void:
	source = path
	if path == "" or not FileAccess.file_exists(path): # in an exported game, the numbers are in the scene
		return
	var found: Dictionary = ProbeGrid.read(path)
	if found.error != "":
		push_error(found.error)
		return
	grid = found
	light_basis = {}
	var beside := path.get_basename() + ".light.safetensors"
	if FileAccess.file_exists(beside):
		_read_basis(beside)
	_light = {}


func _read_basis(path: String) -> void:
	var found: Dictionary = LightBasis.read(path)
	if found.error == "" and (found.receivers != "probe" or found.receiver_count * 27 != grid.light.size()
			or found.value_count != 27):
		found.error = path + ": it was not baked with these probes"
	if found.error != "":
		push_error(found.error + "; probes keep their light")
		return
	var layers := []
	for k in found.names.size():
		layers.append((LightBasis.layer(found, k) as PackedByteArray).to_float32_array())
	light_basis = {"names": found.names, "turns": found.turns, "first_turn": found.first_turn, "layers": layers}


## Lights an object from now on: all meshes of the node and below it.
func add_object(node: Node) -> void:
	if node == null:
		push_error("an object to be lit by probes is missing")
		return
	var maker := BakedMaterial.new()
	var meshes := node.find_children("*", "MeshInstance3D", true, false)
	if node is MeshInstance3D:
		meshes.append(node)
	for mesh: MeshInstance3D in meshes:
		for surface in mesh.mesh.get_surface_count():
			var material := mesh.get_active_material(surface) as BaseMaterial3D
			if material == null:
				material = StandardMaterial3D.new()
			var lit := maker.convert(material, "probe", 1, " * COLOR" if material.vertex_color_use_as_albedo else "")
			mesh.set_surface_override_material(surface, lit)
			_meshes.append(mesh)
			_materials.append(lit)


## Irradiance, W/m2, at a place and for a unit normal, both in world space; black where no probe is valid.
func irradiance(place: Vector3, normal: Vector3) -> Vector3:
	var found := _coefficients(place)
	if found.is_empty():
		return Vector3.ZERO
	var sum: Array = ProbeGrid.irradiance(found, global_basis.inverse() * normal)
	return Vector3(sum[0], sum[1], sum[2])


func _coefficients(place: Vector3) -> Array:
	var lit := _light if _light else grid
	return ProbeGrid.at(lit, global_transform.affine_inverse() * place) if lit else []


func _process(_delta: float) -> void:
	for k in _meshes.size():
		var mesh := _meshes[k]
		if not is_instance_valid(mesh) or not mesh.is_inside_tree():
			continue
		var found := _coefficients(mesh.global_transform * mesh.get_aabb().get_center())
		if found.is_empty(): # the object keeps its light
			continue
		var probe := PackedVector3Array()
		for c in 9:
			probe.append(Vector3(found[3 * c], found[3 * c + 1], found[3 * c + 2]))
		_materials[k].set_shader_parameter("probe", probe)
		_materials[k].set_shader_parameter("to_probes", global_basis.inverse())


## Probes are relit as the scene is; lights that the scene does not have stay as baked.
func _relight(scene: Node) -> void:
	if light_basis.is_empty():
		return
	var light := PackedFloat32Array()
	light.resize(grid.light.size())
	for k in light_basis.names.size():
		var factor: Color = scene.factor(light_basis.names[k], maxi(k - light_basis.first_turn, -1))
		var layer: PackedFloat32Array = light_basis.layers[k]
		for n in range(0, light.size(), 3):
			light[n] += factor.r * layer[n]
			light[n + 1] += factor.g * layer[n + 1]
			light[n + 2] += factor.b * layer[n + 2]
	_light = grid.duplicate()
	_light.light = light
