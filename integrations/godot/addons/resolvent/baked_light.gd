## The light of a baked scene: relights it by the strengths and colours of its lights.
##
## The importer adds this node to each baked file. From a script: `$room/BakedLight.set_light("lamp", 0.2,
## Color.ORANGE)`. In the inspector, each light has an energy and a colour, which animations may change. Instances of
## one imported scene share their light.
@tool
extends Node

## The light was changed.
signal changed

const LightBasis = preload("light_basis.gd")

## Names of the lights, one for each layer of the texture. Without a light basis, there is one light, "baked".
@export var light_names: PackedStringArray
## Layers of a sky that turns, at the end of the list; 0 if there is none.
@export var sky_turns := 0
## Angle of the sky as baked, degrees.
@export var sky_rotation := 0.0
## One column for each light: its factor. All materials of the scene read it.
@export var light_scale: ImageTexture

var _energy := {}
var _color := {}
var _degrees := 0.0
var _changed := true


func _ready() -> void:
	if _degrees == 0.0:
		_degrees = sky_rotation
	_update()


## Sets a light relative to the bake: 1 and white are as baked, 0 is off. Lights of the same name change together.
func set_light(light: String, energy: float, color := Color.WHITE) -> void:
	if not light in light_names:
		push_error("no light is named '%s': %s" % [light, ", ".join(light_names)])
		return
	_energy[light] = maxf(energy, 0.0) if is_finite(energy) else 0.0
	_color[light] = color
	_request_update()


## Turns a sky that was baked with --env-turns.
func set_sky_rotation(degrees: float) -> void:
	_degrees = degrees
	_request_update()


func _request_update() -> void:
	if _changed:
		return
	_changed = true
	_update.call_deferred()


func _update() -> void:
	_changed = false
	if light_scale == null:
		return
	var image := Image.create_empty(maxi(light_names.size(), 1), 1, false, Image.FORMAT_RGBAF)
	var first := light_names.size() - sky_turns
	for k in light_names.size():
		image.set_pixel(k, 0, factor(light_names[k], k - first if k >= first else -1))
	light_scale.update(image)
	changed.emit()


## What a light is multiplied by, linear. @param turn which angle of a sky that turns; -1 for other lights
func factor(light: String, turn := -1) -> Color:
	var strength: Color = _color.get(light, Color.WHITE).srgb_to_linear() * _energy.get(light, 1.0)
	if turn < 0 or turn >= sky_turns:
		return strength
	return strength * LightBasis.turn_shares(sky_turns, sky_rotation, _degrees)[turn]


func _unique_names() -> Array:
	var names := []
	for light in light_names:
		if not light in names:
			names.append(light)
	return names


func _get_property_list() -> Array[Dictionary]:
	var list: Array[Dictionary] = []
	for light in _unique_names():
		list.append({"name": "lights/%s/energy" % light, "type": TYPE_FLOAT, "hint": PROPERTY_HINT_RANGE,
			"hint_string": "0,4,0.01,or_greater"})
		list.append({"name": "lights/%s/color" % light, "type": TYPE_COLOR, "hint": PROPERTY_HINT_COLOR_NO_ALPHA})
	if sky_turns > 0:
		list.append({"name": "lights/sky_rotation", "type": TYPE_FLOAT, "hint_string": "degrees"})
	return list


func _get(property: StringName) -> Variant:
	var key := str(property)
	if key == "lights/sky_rotation":
		return _degrees
	if key.begins_with("lights/") and key.ends_with("/energy"):
		return _energy.get(_light_of(key), 1.0)
	if key.begins_with("lights/") and key.ends_with("/color"):
		return _color.get(_light_of(key), Color.WHITE)
	return null


func _set(property: StringName, value: Variant) -> bool:
	var key := str(property)
	if key == "lights/sky_rotation":
		_degrees = value
	elif key.begins_with("lights/") and key.ends_with("/energy"):
		_energy[_light_of(key)] = maxf(value, 0.0)
	elif key.begins_with("lights/") and key.ends_with("/color"):
		_color[_light_of(key)] = value
	else:
		return false
	_request_update()
	return true


func _light_of(key: String) -> String:
	return key.substr(7, key.rfind("/") - 7)
