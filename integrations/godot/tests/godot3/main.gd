## Tests of the scripts that run in Godot 3 and 4: godot3 --path FOLDER -s main.gd. The environment names the baked
## files.
extends SceneTree

const LightBasis = preload("addons/resolvent/light_basis.gd")
const Baked = preload("addons/resolvent/baked_document.gd")
const Probes = preload("addons/resolvent/probe_grid.gd")
const Platform = preload("addons/resolvent/platform.gd")

var failures = 0


func _init():
	var folder = OS.get_environment("BAKED")
	test_vertices(folder)
	test_texels(folder)
	test_sky()
	test_hostile_bases(folder)
	test_hostile_documents()
	test_probes(folder)
	test_irradiance()
	print("all passed" if failures == 0 else "FAILED: " + str(failures))
	OS.exit_code = 1 if failures > 0 else 0
	quit()


func check(condition, what):
	if not condition:
		failures += 1
		print("FAILED: ", what)


func near(a, b, most, what):
	check(abs(a - b) <= most, what + ": " + str(a) + " is not " + str(b))


# The JSON and the binary part of a .glb file.
func open_glb(path):
	var bytes = Platform.read_file(path)
	var stream = StreamPeerBuffer.new()
	stream.data_array = bytes
	stream.seek(12)
	var length = stream.get_u32()
	return {"json": Platform.parse_json(Platform.bytes_between(bytes, 20, 20 + length).get_string_from_utf8()),
		"binary": Platform.bytes_between(bytes, 28 + length, bytes.size())}


func values_of(glb, accessor, width):
	var view = glb.json.bufferViews[int(accessor.bufferView)]
	var from = int(view.get("byteOffset", 0)) + int(accessor.get("byteOffset", 0))
	return Platform.floats(glb.binary, from, int(accessor.count) * width)


# The sum of the basis at baked strengths is the light in COLOR_0, and every vertex has the address of its own light.
func test_vertices(folder):
	var glb = open_glb(folder + "/box.glb")
	var basis = LightBasis.read(folder + "/box.light.safetensors")
	var baked = Baked.describe(glb.json)
	check(basis.error == "" and baked.error == "", "the box is not read: " + basis.error + baked.error)
	check(basis.names == ["light"] and basis.receivers == "vertex", "its light is " + str(basis.names))
	check(baked.receivers == "vertex" and baked.receiver_count == basis.receiver_count, "receivers " + str(baked))
	var values = Platform.floats(LightBasis.layer(basis, 0), 0, 3 * basis.receiver_count)
	Baked.address_vertices(glb.json, baked)
	var uri = glb.json.buffers[-1].uri
	var data = Marshalls.base64_to_raw(uri.substr(uri.find(",") + 1))
	check(data.size() == 8 * baked.receiver_count, "addresses have " + str(data.size()) + " bytes")
	for primitive in Baked.lit_primitives(glb.json):
		var light = values_of(glb, glb.json.accessors[int(primitive.extras.resolvent_light)], 3)
		var address = glb.json.accessors[int(primitive.attributes["TEXCOORD_1"])]
		var first = Baked.first_receiver(primitive)
		check(address.count * 3 == light.size() and not primitive.attributes.has("COLOR_0"), "a vertex has no address")
		var at = Platform.floats(data, int(address.byteOffset), 2)
		check(at[0] + Baked.COLUMNS * at[1] == first, "a primitive's first address is " + str(at))
		for k in range(0, light.size(), 29):
			var wanted = PI * baked.light_scale * light[k]
			near(values[3 * first + k], wanted, 1e-5 + 1e-5 * wanted, "irradiance")


func test_texels(folder):
	var baked = Baked.describe(open_glb(folder + "/map.glb").json)
	var basis = LightBasis.read(folder + "/map.light.safetensors")
	check(baked.error == "" and baked.receivers == "texel" and baked.set == 1 and baked.texture == 0, "map " + str(baked))
	check(basis.error == "" and basis.receivers == "texel" and baked.intensity > 1, "its basis " + str(basis.error))
	check(LightBasis.baked_scales(basis) == [1.0], "scales as baked")


func test_sky():
	var shares = LightBasis.turn_shares(4, 10, 10)
	check(shares == [1.0, 0.0, 0.0, 0.0], "the first angle " + str(shares))
	shares = LightBasis.turn_shares(4, 10, 10 - 45)
	check(shares == [0.5, 0.0, 0.0, 0.5], "half a step back " + str(shares))
	near(LightBasis.turn_shares(8, 0, 30 + 720)[1], 2.0 / 3, 1e-6, "two turns further")
	var header = '{"__metadata__": {"format": "resolvent-light-basis", "light.name": "[\\"a\\", \\"sky\\", \\"sky\\"]",' \
		+ '"surroundings.turns": "2", "surroundings.rotation": "30"}, "basis.value": {"dtype": "F32", "shape": [3, 1, 3],' \
		+ '"data_offsets": [0, 36]}}'
	var basis = LightBasis.parse(file_of(header, 36))
	check(basis.error == "" and basis.first_turn == 1 and basis.rotation == 30, "a sky " + str(basis))
	check(LightBasis.baked_scales(basis) == [1.0, 1.0, 0.0], "its other angles are off as baked")


# A safetensors file with this header and so many bytes behind it.
func file_of(header, count):
	var stream = StreamPeerBuffer.new()
	stream.put_u64(header.length())
	stream.put_data(header.to_utf8())
	for _k in range(count):
		stream.put_u8(0)
	return stream.data_array


func refused(basis, words):
	var said = basis.error.find(words) >= 0 and basis.error.find("\n") < 0
	check(said, "'" + basis.error + "' does not say '" + words + "'")


func test_hostile_bases(folder):
	refused(LightBasis.read(folder + "/nowhere"), "nowhere: the file cannot be read")
	var whole = Platform.read_file(folder + "/box.light.safetensors")
	for size in [0, 7, 8, 100, 600, whole.size() - 1]:
		check(LightBasis.parse(Platform.bytes_between(whole, 0, size)).error != "", "a basis of " + str(size) + " bytes")
	refused(LightBasis.parse(file_of("[]", 0)), "not JSON")
	refused(LightBasis.parse(file_of("{}", 0)), "not a light basis")
	refused(LightBasis.parse(file_of('{"__metadata__": 3}', 0)), "not a light basis")
	var start = '{"__metadata__": {"format": "resolvent-light-basis", "light.name": "[\\"a\\"]"'
	refused(LightBasis.parse(file_of(start + ', "basis.shape": "[1, 1, 3]"}}', 0)), "packed")
	refused(LightBasis.parse(file_of(start + '}}', 0)), "not F32")
	for shape in ['"x"', "[1, 1]", "[1, -1, 3]", "[1, 1e30, 3]", "[null, 1, 3]"]:
		var value = '}, "basis.value": {"dtype": "F32", "data_offsets": [0, 12], "shape": ' + shape + "}}"
		refused(LightBasis.parse(file_of(start + value, 12)), "not F32")
	var two = '}, "basis.value": {"dtype": "F32", "data_offsets": [0, 24], "shape": [2, 1, 3]}}'
	refused(LightBasis.parse(file_of(start + two, 24)), "does not name each light")
	var none = '}, "basis.value": {"dtype": "F32", "data_offsets": [0, 0], "shape": [1, 0, 3]}}'
	refused(LightBasis.parse(file_of(start + none, 0)), "truncated")


func test_hostile_documents():
	check(Baked.describe({}).receivers == "", "an empty document has no light")
	var map = {"extensions": {"MOZ_lightmap": {"index": 0}}}
	var other = {"extensions": {"MOZ_lightmap": {"index": 1, "texCoord": 9}}}
	refused(Baked.describe({"materials": [map, other]}), "sets of texture coordinates")
	other.extensions.MOZ_lightmap.texCoord = 1
	refused(Baked.describe({"materials": [map, other]}), "several lightmaps")
	for extras in [3, "x", [], {}, {"resolvent_first_receiver": -5}]:
		var mesh = {"primitives": [{"attributes": {"POSITION": 0}, "extras": extras}]}
		check(Baked.describe({"meshes": [mesh]}).receivers == "", "extras without light: " + str(extras))
	var lost = {"primitives": [{"attributes": {"POSITION": 7}, "extras": {"resolvent_first_receiver": 0}}]}
	refused(Baked.describe({"meshes": [lost], "accessors": []}), "POSITION")


func test_probes(folder):
	var grid = Probes.read(folder + "/probes.json")
	check(grid.error == "", "probes are not read: " + grid.error)
	var corner = -1
	for probe in range(grid.valid.size()):
		corner = probe if corner < 0 and grid.valid[probe] else corner
	var place = []
	var index = corner
	for axis in range(3):
		place.append(grid.origin[axis] + grid.spacing[axis] * (index % int(grid.size[axis])))
		index = int(index / int(grid.size[axis]))
	var found = Probes.at(grid, place)
	for k in range(27):
		near(found[k], grid.light[27 * corner + k], 1e-5, "coefficient at a probe")
	check(Probes.at(grid, [1000.0, 1000.0, -1000.0]).size() in [0, 27], "far away")
	for k in range(grid.valid.size()):
		grid.valid[k] = 0
	check(Probes.at(grid, place) == [], "no valid probe")
	refused(Probes.read(folder + "/box.glb"), "not a file of")
	refused(Probes.read(folder + "/short.json"), "does not hold")
	refused(Probes.read(folder + "/flat.json"), "do not describe a grid")


# Radiance 1 from everywhere gives pi; radiance n.y + 1 gives pi + 2 pi / 3 n.y.
func test_irradiance():
	var light = []
	for _k in range(27):
		light.append(0.0)
	light[0] = 2 * sqrt(PI)
	near(Probes.irradiance(light, Vector3(0, 0, 1))[0], PI, 1e-5, "a sphere of light")
	light[3] = 1 / sqrt(3 / (4 * PI))
	near(Probes.irradiance(light, Vector3(0, 1, 0))[0], PI + 2 * PI / 3, 1e-5, "brighter above")
	near(Probes.irradiance(light, Vector3(0, -1, 0))[0], PI - 2 * PI / 3, 1e-5, "darker below")
	near(Probes.irradiance(light, Vector3(1, 0, 0))[1], 0, 1e-9, "no green")
