## Probes of `resolvent bake --to probes`: the light on objects that move. Runs in Godot 3 and 4.

const Platform = preload("platform.gd")
const COEFFICIENTS = 27


## Reads NAME.json and the file beside it that holds the numbers.
##
## @return a dictionary. `error` is one line, or "". Otherwise `size`, `origin` and `spacing` (metres), arrays of three;
## `light`, [probes, 9, 3] radiance in spherical harmonics, W/(sr m2); `valid`, one byte of each probe.
static func read(path):
	var bytes = Platform.read_file(path)
	var json = Platform.parse_json(bytes.get_string_from_utf8()) if bytes != null else null
	if typeof(json) != TYPE_DICTIONARY or str(json.get("format", "")) != "resolvent-probes":
		return {"error": path + ": this is not a file of `resolvent bake --to probes`"}
	var grid = {"error": "", "size": json.get("size"), "origin": json.get("origin"), "spacing": json.get("spacing")}
	var count = _probe_count(grid)
	if count <= 0:
		return {"error": path + ": size, origin and spacing do not describe a grid"}
	var data = Platform.beside(path, str(json.get("data", "")))
	var numbers = Platform.read_file(data)
	if numbers == null or numbers.size() != count * (4 * COEFFICIENTS + 1):
		return {"error": data + ": it does not hold the coefficients of " + str(count) + " probes"}
	grid.light = Platform.floats(numbers, 0, count * COEFFICIENTS)
	grid.valid = Platform.bytes_between(numbers, count * 4 * COEFFICIENTS, numbers.size())
	return grid


static func _probe_count(grid):
	var count = 1
	for axis in range(3):
		for value in [grid.size, grid.origin, grid.spacing]:
			if typeof(value) != TYPE_ARRAY or value.size() != 3 or not (typeof(value[axis]) in [2, 3]):
				return 0
		if not (grid.size[axis] >= 1 and grid.size[axis] < 65536 and grid.spacing[axis] > 0):
			return 0
		count *= int(grid.size[axis])
	return count


## The coefficients at a place: the valid probes around it, weighted trilinearly; outside the grid, those of its border.
##
## @return 27 numbers, [9, 3]; empty where no probe is valid: keep the light that the object had
static func at(grid, position):
	var low = [0, 0, 0]
	var share = [0.0, 0.0, 0.0]
	for axis in range(3):
		var last = int(grid.size[axis]) - 1
		var place = clamp((position[axis] - grid.origin[axis]) / grid.spacing[axis], 0.0, float(last))
		low[axis] = int(min(int(place), max(last - 1, 0)))
		share[axis] = place - low[axis]
	var sum = []
	for _k in range(COEFFICIENTS):
		sum.append(0.0)
	var weights = 0.0
	for corner in range(8):
		var weight = _weight(share, corner)
		if weight > 0:
			var probe = _index(grid, low, corner)
			if grid.valid[probe] != 0:
				weights += weight
				for k in range(COEFFICIENTS):
					sum[k] += weight * grid.light[probe * COEFFICIENTS + k]
	if not weights > 0:
		return []
	for k in range(COEFFICIENTS):
		sum[k] /= weights
	return sum


static func _weight(share, corner):
	var weight = 1.0
	for axis in range(3):
		weight *= share[axis] if corner >> axis & 1 else 1 - share[axis]
	return weight


static func _index(grid, low, corner):
	var index = 0
	for axis in range(2, -1, -1):
		index = index * int(grid.size[axis]) + low[axis] + (corner >> axis & 1)
	return index


## Irradiance, W/m2, on a surface with a unit normal (Ramamoorthi and Hanrahan 2001), as an array of RGB.
static func irradiance(coefficients, normal):
	var n = normal
	var basis = [0.88622693, 1.02332671 * n[1], 1.02332671 * n[2], 1.02332671 * n[0], 0.85808553 * n[0] * n[1],
		0.85808553 * n[1] * n[2], 0.24770796 * (3 * n[2] * n[2] - 1), 0.85808553 * n[0] * n[2],
		0.42904276 * (n[0] * n[0] - n[1] * n[1])]
	var result = [0.0, 0.0, 0.0]
	for c in range(3):
		for k in range(9):
			result[c] += basis[k] * coefficients[3 * k + c]
		result[c] = max(result[c], 0.0)
	return result
