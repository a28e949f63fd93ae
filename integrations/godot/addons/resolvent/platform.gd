## What Godot 4 names differently from Godot 3, for the scripts that run in both.


## All bytes of a file, or null.
static func read_file(path):
	return FileAccess.get_file_as_bytes(path) if FileAccess.file_exists(path) else null


## The value of a JSON text, or null.
static func parse_json(text):
	var json = JSON.new()
	return json.data if json.parse(text) == OK else null


static func bytes_between(bytes, from, end):
	return bytes.slice(from, end)


## `count` little-endian 32-bit floats from byte `from` on.
static func floats(bytes, from, count):
	return bytes.slice(from, from + 4 * count).to_float32_array()


## Little-endian 32-bit floats as base64.
static func base64_floats(values):
	return Marshalls.raw_to_base64(PackedFloat32Array(values).to_byte_array())


## The path of a file in the same folder as another.
static func beside(path, name):
	return path.get_base_dir().path_join(name)
