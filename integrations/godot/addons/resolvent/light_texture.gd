## The texture array with baked light: one layer for each light of the basis, or one for the light as baked.
@tool
extends RefCounted

const Baked = preload("baked_document.gd")
const LightBasis = preload("light_basis.gd")

const LARGEST_HALF := 60000.0


## @return a dictionary: `error`, one line, or ""; `texture`, a Texture2DArray of half floats, which every GPU can
## filter; `unit`, the irradiance that 1 stands for, W/m2
static func create(state: GLTFState, baked: Dictionary) -> Dictionary:
	var size := _size(state, baked)
	var receivers: int = baked.receiver_count if baked.receivers == "vertex" else size.x * size.y
	if size.x <= 0 or size.y > 16384 or receivers <= 0:
		return {"error": "its lightmap cannot be read, or it has too many vertices with light"}
	if baked.basis and baked.basis.receiver_count != receivers:
		return {"error": "the light basis beside it was baked with another file; remove it, or bake both again"}
	var layers: Array[PackedFloat32Array] = []
	if baked.basis:
		for k in baked.basis.names.size():
			layers.append((LightBasis.layer(baked.basis, k) as PackedByteArray).to_float32_array())
	elif baked.receivers == "vertex":
		layers.append(_vertex_light(state, baked))
	else:
		layers.append(_map_light(state, baked, size))
	return _pack(layers, size)


static func _size(state: GLTFState, baked: Dictionary) -> Vector2i:
	if baked.receivers == "vertex":
		return Vector2i(Baked.COLUMNS, ceili(float(baked.receiver_count) / Baked.COLUMNS))
	var image := _map_image(state, baked)
	return image.get_size() if image else Vector2i.ZERO


static func _pack(layers: Array[PackedFloat32Array], size: Vector2i) -> Dictionary:
	var largest := 0.0
	for layer in layers:
		if layer.is_empty():
			return {"error": "its light cannot be read"}
		var sorted := layer.duplicate()
		sorted.sort()
		largest = maxf(largest, maxf(sorted[-1], -sorted[0]))
		if not is_finite(largest) or layer.has(NAN):
			return {"error": "its light is not finite everywhere"}
	var unit := maxf(largest / LARGEST_HALF, 1.0)
	var images: Array[Image] = []
	for layer in layers:
		layer.resize(3 * size.x * size.y) # vertices do not fill the last row
		var image := Image.create_from_data(size.x, size.y, false, Image.FORMAT_RGBF, layer.to_byte_array())
		if unit > 1.0:
			image.adjust_bcs(1.0 / unit, 1.0, 1.0)
		image.convert(Image.FORMAT_RGBH)
		images.append(image)
	var texture := Texture2DArray.new()
	if texture.create_from_images(images) != OK:
		return {"error": "its texture cannot be made"}
	return {"error": "", "texture": texture, "unit": unit}


## Irradiance of all vertices as baked, times their own colours: that of COLOR_0.
static func _vertex_light(state: GLTFState, baked: Dictionary) -> PackedFloat32Array:
	var light := PackedFloat32Array()
	light.resize(3 * baked.receiver_count)
	for primitive in Baked.lit_primitives(state.json):
		var values := _colors(state, int(primitive.extras.resolvent_light))
		var width := 4 if values.size() > 0 and _is_rgba(state, int(primitive.extras.resolvent_light)) else 3
		var first: int = 3 * Baked.first_receiver(primitive)
		for k in values.size() / width:
			for c in 3:
				light[first + 3 * k + c] = PI * baked.light_scale * values[width * k + c]
	return light


static func _is_rgba(state: GLTFState, accessor: int) -> bool:
	return state.json.accessors[accessor].type == "VEC4"


## Floats of an accessor; none if it does not hold floats, one after the other.
static func _colors(state: GLTFState, index: int) -> PackedFloat32Array:
	if index < 0 or index >= state.json.accessors.size():
		return []
	var accessor: Dictionary = state.json.accessors[index]
	var view: Dictionary = state.json.bufferViews[int(accessor.get("bufferView", 0))]
	var stride := 16 if accessor.type == "VEC4" else 12
	if int(accessor.componentType) != 5126 or int(view.get("byteStride", stride)) != stride:
		return []
	var from := int(view.get("byteOffset", 0)) + int(accessor.get("byteOffset", 0))
	return state.buffers[int(view.buffer)].slice(from, from + stride * int(accessor.count)).to_float32_array()


## Irradiance of all texels as baked: unclipped from the .exr beside the file, else from its own map.
static func _map_light(state: GLTFState, baked: Dictionary, size: Vector2i) -> PackedFloat32Array:
	var path := state.base_path.path_join(state.filename + ".lightmap.exr")
	if FileAccess.file_exists(path) and not OS.has_feature("web"): # there, Godot's reader of .exr asks for threads
		var exact := Image.new()
		if exact.load(path) == OK and exact.get_size() == size:
			exact.convert(Image.FORMAT_RGBF)
			return exact.get_data().to_float32_array()
	return _decode(_map_image(state, baked), baked.intensity)


static func _map_image(state: GLTFState, baked: Dictionary) -> Image:
	var textures: Array = state.json.get("textures", [])
	var images: Array = state.json.get("images", [])
	if baked.texture < 0 or baked.texture >= textures.size():
		return null
	var source := int(textures[baked.texture].get("source", -1))
	if source < 0 or source >= images.size() or not images[source].has("bufferView"):
		return null
	var view: Dictionary = state.json.bufferViews[int(images[source].bufferView)]
	var from := int(view.get("byteOffset", 0))
	var image := Image.new()
	var bytes := state.buffers[int(view.buffer)].slice(from, from + int(view.byteLength))
	return image if image.load_png_from_buffer(bytes) == OK else null


## sRGB codes times the intensity.
static func _decode(image: Image, intensity: float) -> PackedFloat32Array:
	image.convert(Image.FORMAT_RGB8)
	var table := PackedFloat32Array()
	for code in 256:
		table.append(intensity * Color8(code, 0, 0).srgb_to_linear().r)
	var codes := image.get_data()
	var light := PackedFloat32Array()
	light.resize(codes.size())
	for k in codes.size():
		light[k] = table[codes[k]]
	return light
