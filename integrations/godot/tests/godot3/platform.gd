## addons/resolvent/platform.gd for Godot 3: the shared scripts are tested with it.


static func read_file(path):
	var file = File.new()
	if file.open(path, File.READ) != OK:
		return null
	var bytes = file.get_buffer(file.get_len())
	file.close()
	return bytes


static func parse_json(text):
	var parsed = JSON.parse(text)
	return parsed.result if parsed.error == OK else null


static func bytes_between(bytes, from, end):
	return bytes.subarray(from, end - 1) if end > from else PoolByteArray()


static func floats(bytes, from, count):
	var stream = StreamPeerBuffer.new()
	stream.data_array = bytes_between(bytes, from, from + 4 * count)
	var values = PoolRealArray()
	for _k in range(count):
		values.append(stream.get_float())
	return values


static func base64_floats(values):
	var stream = StreamPeerBuffer.new()
	for value in values:
		stream.put_float(value)
	return Marshalls.raw_to_base64(stream.data_array)


static func beside(path, name):
	return path.get_base_dir().plus_file(name)
