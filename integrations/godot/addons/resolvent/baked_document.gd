## What the JSON of a baked glTF file says about its light. Runs in Godot 3 and 4.
##
## Each vertex gets an address: a set of texture coordinates with the column and row of its light in a texture. An
## engine may reorder, duplicate or compress vertices; the address goes with them.

const Platform = preload("platform.gd")
const COLUMNS = 1024 # of the texture with the light of vertices
const SETS = 8 # of texture coordinates that Godot 4 imports


## @return a dictionary. `error` is one line, or "". `receivers` is "vertex", "texel" or "" for a file without baked
## light. `light_scale` is the radiance of white at COLOR_0 = 1, W/(sr m2). For texels, `texture`, `set` (of texture
## coordinates) and `intensity` of MOZ_lightmap, and `lit_materials`, their indices. For vertices, `receiver_count` and
## `set`, which the file does not use yet.
static func describe(json):
	var baked = {"error": "", "receivers": "", "receiver_count": 0, "set": 1, "light_scale": _light_scale(json)}
	var materials = json.get("materials", [])
	for index in range(materials.size()):
		_add_map(baked, index, materials[index].get("extensions", {}).get("MOZ_lightmap"))
	if baked.receivers == "":
		_find_vertices(baked, json)
	if baked.set >= SETS:
		baked.error = "it needs " + str(baked.set + 1) + " sets of texture coordinates; Godot has " + str(SETS)
	return baked


static func _light_scale(json):
	var extras = json.get("asset", {}).get("extras", {})
	var resolvent = extras.get("resolvent", {}) if typeof(extras) == TYPE_DICTIONARY else {}
	return float(resolvent.get("light_scale", 1.0))


static func _add_map(baked, material, map):
	if typeof(map) != TYPE_DICTIONARY:
		return
	if baked.receivers == "":
		baked.lit_materials = []
	baked.lit_materials.append(material)
	if baked.receivers == "texel" and int(map.get("index", -1)) != baked.texture:
		baked.error = "it has several lightmaps"
	baked.receivers = "texel"
	baked.texture = int(map.get("index", -1))
	baked.set = int(map.get("texCoord", 1))
	baked.intensity = float(map.get("intensity", 1.0))


static func _find_vertices(baked, json):
	for primitive in lit_primitives(json):
		baked.receivers = "vertex"
		var count = _vertex_count(json, primitive)
		if count < 0:
			baked.error = "a primitive with light has no accessor for POSITION"
			return
		baked.receiver_count = max(baked.receiver_count, first_receiver(primitive) + count)
		while primitive.attributes.has("TEXCOORD_" + str(baked.set)):
			baked.set += 1


## All primitives with light in their vertices.
static func lit_primitives(json):
	var lit = []
	for mesh in json.get("meshes", []):
		for primitive in mesh.get("primitives", []):
			if first_receiver(primitive) >= 0:
				lit.append(primitive)
	return lit


## The index of a primitive's first vertex in the light basis, or -1.
static func first_receiver(primitive):
	var extras = primitive.get("extras", {})
	return int(extras.get("resolvent_first_receiver", -1)) if typeof(extras) == TYPE_DICTIONARY else -1


static func _vertex_count(json, primitive):
	var accessor = int(primitive.get("attributes", {}).get("POSITION", -1))
	var accessors = json.get("accessors", [])
	return int(accessors[accessor].get("count", -1)) if accessor >= 0 and accessor < accessors.size() else -1


## Adds the addresses of vertices to the document, in one buffer of their own. Vertex colours become those that the
## vertices had before the bake; the accessor with the light is kept in the extras.
static func address_vertices(json, baked):
	var values = []
	for k in range(baked.receiver_count):
		values.append(float(k % COLUMNS))
		values.append(float(int(k / COLUMNS)))
	var bytes = 4 * values.size()
	var uri = "data:application/octet-stream;base64," + Platform.base64_floats(values)
	json.buffers.append({"byteLength": bytes, "uri": uri})
	json.bufferViews.append({"buffer": json.buffers.size() - 1, "byteOffset": 0, "byteLength": bytes})
	for primitive in lit_primitives(json):
		_address(json, baked, primitive)


static func _address(json, baked, primitive):
	var count = _vertex_count(json, primitive)
	json.accessors.append({"bufferView": json.bufferViews.size() - 1, "byteOffset": 8 * first_receiver(primitive),
		"componentType": 5126, "count": count, "type": "VEC2"})
	primitive.attributes["TEXCOORD_" + str(baked.set)] = json.accessors.size() - 1
	primitive.extras.resolvent_light = primitive.attributes.get("COLOR_0", -1)
	primitive.attributes.erase("COLOR_0")
	if primitive.attributes.has("_COLOR"):
		primitive.attributes.COLOR_0 = primitive.attributes._COLOR
