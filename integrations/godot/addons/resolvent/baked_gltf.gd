## Reads glTF files baked by `resolvent bake` with their light, in the editor and at run time.
##
## At run time: `GLTFDocument.register_gltf_document_extension(BakedGltf.new(), true)`, then GLTFDocument as usual. The
## light basis is expected beside the file: NAME.glb, NAME.light.safetensors. Without it, light is as baked and cannot
## change.
@tool
extends GLTFDocumentExtension

const Baked = preload("baked_document.gd")
const BakedLight = preload("baked_light.gd")
const BakedMaterial = preload("baked_material.gd")
const LightBasis = preload("light_basis.gd")
const LightTexture = preload("light_texture.gd")

const KEY := "resolvent"
const MOST_LIGHTS := 256 # layers of a texture array that every renderer has


func _get_supported_extensions() -> PackedStringArray:
	return ["MOZ_lightmap"]


## Finds baked light and its basis; vertices get addresses before the engine reads them.
func _import_preflight(state: GLTFState, _extensions: PackedStringArray) -> Error:
	var baked: Dictionary = Baked.describe(state.json)
	if baked.error != "":
		push_error("%s: its baked light is left out: %s" % [state.filename, baked.error])
		return ERR_SKIP
	if baked.receivers == "":
		return ERR_SKIP
	baked.basis = _find_basis(state, baked.receivers)
	if baked.receivers == "vertex":
		Baked.address_vertices(state.json, baked)
	state.set_additional_data(KEY, baked)
	return OK


## The basis beside the file; null if there is none that can be used.
func _find_basis(state: GLTFState, receivers: String) -> Variant:
	var path := state.base_path.path_join(state.filename + ".light.safetensors")
	if not FileAccess.file_exists(path):
		return null
	var basis: Dictionary = LightBasis.read(path)
	if basis.error == "" and (basis.receivers != receivers or basis.value_count != 3):
		basis.error = path + ": it was not baked with this file"
	elif basis.error == "" and basis.names.size() > MOST_LIGHTS:
		basis.error = "%s: it has %d lights; at most %d can be shown" % [path, basis.names.size(), MOST_LIGHTS]
	if basis.error != "":
		push_error(basis.error + "; light is shown as baked")
		return null
	return basis


## Gives the surfaces their materials, before scenes are made of them.
func _import_post_parse(state: GLTFState) -> Error:
	var baked: Dictionary = state.get_additional_data(KEY)
	var texture: Dictionary = LightTexture.create(state, baked)
	if texture.error != "":
		push_error("%s: its baked light is left out: %s" % [state.filename, texture.error])
		return OK
	baked.texture_array = texture
	baked.names = baked.basis.names if baked.basis else ["baked"]
	var image := Image.create_empty(baked.names.size(), 1, false, Image.FORMAT_RGBAF)
	var scales: Array = LightBasis.baked_scales(baked.basis) if baked.basis else [1.0]
	for k in scales.size():
		image.set_pixel(k, 0, Color(scales[k], scales[k], scales[k]))
	baked.light_scale = ImageTexture.create_from_image(image)
	var maker := BakedMaterial.new()
	var made := {}
	for m in state.meshes.size():
		var primitives: Array = state.json.meshes[m].primitives
		var mesh: ImporterMesh = state.meshes[m].mesh
		for p in mini(primitives.size(), mesh.get_surface_count()):
			_give_material(baked, maker, made, mesh, p, primitives[p])
	return OK


func _give_material(baked: Dictionary, maker: RefCounted, made: Dictionary, mesh: ImporterMesh, surface: int,
		primitive: Dictionary) -> void:
	var source := mesh.get_surface_material(surface) as BaseMaterial3D
	if source == null:
		source = StandardMaterial3D.new()
	var lit := _is_lit(baked, primitive)
	var lamp: int = baked.names.find(source.resource_name) if source.emission_enabled else -1
	if not lit and lamp < 0:
		return
	var colored := "" # how vertex colours multiply the base colour
	if primitive.attributes.has("COLOR_0"):
		# without a basis, the light of vertices includes their colours, but not their alpha
		colored = " * vec4(1.0, 1.0, 1.0, COLOR.a)" if lit and baked.receivers == "vertex" and not baked.basis else " * COLOR"
	var key := [source, lit, colored]
	if not made.has(key):
		made[key] = maker.convert(source, baked.receivers if lit else "", baked.set, colored)
		made[key].set_shader_parameter("lamp", lamp)
		made[key].set_shader_parameter("light_scale", baked.light_scale)
		if lit:
			made[key].set_shader_parameter("light", baked.texture_array.texture)
			made[key].set_shader_parameter("light_unit", baked.texture_array.unit)
			made[key].set_shader_parameter("light_count", baked.names.size())
	mesh.set_surface_material(surface, made[key])


func _is_lit(baked: Dictionary, primitive: Dictionary) -> bool:
	if baked.receivers == "vertex":
		return Baked.first_receiver(primitive) >= 0
	return int(primitive.get("material", -1)) in baked.lit_materials


## Adds the node that changes the light.
func _import_post(state: GLTFState, root: Node) -> Error:
	var baked: Dictionary = state.get_additional_data(KEY)
	if not baked.has("light_scale"):
		return OK
	var node := Node.new()
	node.set_script(BakedLight)
	node.name = "BakedLight"
	node.light_names = PackedStringArray(baked.names)
	node.light_scale = baked.light_scale
	if baked.basis:
		node.sky_turns = baked.basis.turns
		node.sky_rotation = baked.basis.rotation
	root.add_child(node)
	node.owner = root
	return OK
