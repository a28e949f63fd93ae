## The light basis of `resolvent bake --basis`: what each light contributes to each receiver. Runs in Godot 3 and 4.

const Platform = preload("platform.gd")


## Reads a basis.
##
## @return a dictionary. `error` is one line, or "". Otherwise `names`, an array with the name of each light;
## `receivers`, "vertex", "texel" or "probe"; `receiver_count`; `value_count`, numbers of each receiver; `bytes`, the
## file; `data`, the byte where the F32 [lights, receivers, values] begin; and `turns`, `first_turn`, `rotation`
## (degrees) of a sky that turns.
static func read(path):
	var bytes = Platform.read_file(path)
	if bytes == null:
		return {"error": path + ": the file cannot be read"}
	var basis = parse(bytes)
	if basis.error != "":
		basis.error = path + ": " + basis.error
	return basis


## The same from the bytes of a file.
static func parse(bytes):
	var length = _header_length(bytes)
	if length < 0:
		return {"error": "this is not a complete safetensors file"}
	var header = Platform.parse_json(Platform.bytes_between(bytes, 8, 8 + length).get_string_from_utf8())
	if typeof(header) != TYPE_DICTIONARY:
		return {"error": "its header is not JSON"}
	var metadata = header.get("__metadata__", {})
	if typeof(metadata) != TYPE_DICTIONARY or str(metadata.get("format", "")) != "resolvent-light-basis":
		return {"error": "this is not a light basis; `resolvent bake --basis` writes one"}
	if metadata.has("basis.shape"):
		return {"error": "this light basis is packed; bake it without --packed"}
	return _describe(bytes, 8 + length, header, metadata)


static func _header_length(bytes):
	if bytes.size() < 8:
		return -1
	var length = 0
	for k in range(7, -1, -1):
		if length > bytes.size():
			return -1
		length = 256 * length + bytes[k]
	return length if length <= bytes.size() - 8 else -1


static func _describe(bytes, start, header, metadata):
	var values = header.get("basis.value", {})
	var names = Platform.parse_json(str(metadata.get("light.name", "")))
	var shape = values.get("shape", []) if typeof(values) == TYPE_DICTIONARY else []
	var offsets = values.get("data_offsets", []) if typeof(values) == TYPE_DICTIONARY else []
	if not _is_shape(shape, 3) or not _is_shape(offsets, 2) or str(values.get("dtype", "")) != "F32":
		return {"error": "basis.value is not F32 [lights, receivers, values]"}
	if typeof(names) != TYPE_ARRAY or names.size() != int(shape[0]):
		return {"error": "light.name does not name each light"}
	var count = float(shape[0]) * float(shape[1]) * float(shape[2])
	if int(offsets[1]) - int(offsets[0]) != 4 * count or start + int(offsets[1]) > bytes.size() or count == 0:
		return {"error": "basis.value does not fit into the file, which may be truncated"}
	var basis = {"error": "", "names": names, "receivers": str(metadata.get("receivers", "")),
		"receiver_count": int(shape[1]), "value_count": int(shape[2]), "bytes": bytes, "data": start + int(offsets[0])}
	_find_turns(basis, metadata)
	return basis


static func _is_shape(value, count):
	if typeof(value) != TYPE_ARRAY or value.size() != count:
		return false
	for number in value:
		# in Godot 3 and 4, types 2 and 3 are whole and real numbers
		if not (typeof(number) in [2, 3]) or not (float(number) >= 0 and float(number) < 1e15):
			return false
	return true


static func _find_turns(basis, metadata):
	var turns = int(str(metadata.get("surroundings.turns", "0")))
	basis.turns = turns if turns > 0 and turns <= basis.names.size() else 0
	basis.first_turn = basis.names.size() - basis.turns
	basis.rotation = float(str(metadata.get("surroundings.rotation", "0")))


## The bytes of one light's values.
static func layer(basis, light):
	var size = 4 * basis.receiver_count * basis.value_count
	return Platform.bytes_between(basis.bytes, basis.data + light * size, basis.data + (light + 1) * size)


## The factors of all lights as baked: 1, but only the first angle of a sky that turns counts.
static func baked_scales(basis):
	var scales = []
	for light in range(basis.names.size()):
		scales.append(0.0 if basis.turns > 0 and light > basis.first_turn else 1.0)
	return scales


## Shares of the angles of a sky turned to `degrees`: the two nearest angles share the light in proportion.
static func turn_shares(turns, rotation, degrees):
	var shares = []
	for _k in range(turns):
		shares.append(0.0)
	if turns > 0:
		var at = fposmod((degrees - rotation) / 360.0, 1.0) * turns
		var before = int(at)
		shares[before % turns] += 1 - (at - before)
		shares[(before + 1) % turns] += at - before
	return shares
