## Materials of surfaces with baked light, and of lamps that dim with their light.
##
## A surface shows base colour * (1 - metallic) * irradiance / pi + emission, unshaded: the light is in the file.
## Irradiance is the sum over the layers of a texture array, each times the factor of its light.
@tool
extends RefCounted

const START := """shader_type spatial;
render_mode %s;
uniform vec4 tint = vec4(1.0); // base colour, linear
uniform sampler2D base_map : source_color, hint_default_white;
uniform vec2 base_scale = vec2(1.0);
uniform vec2 base_offset = vec2(0.0);
uniform float metallic = 0.0;
uniform sampler2D metallic_map : hint_default_white;
uniform vec4 metallic_channel = vec4(0.0, 0.0, 1.0, 0.0);
uniform vec3 emission = vec3(0.0); // radiance, linear
uniform sampler2D emission_map : source_color, hint_default_white;
uniform float alpha_cutoff = 0.5;
uniform sampler2DArray light : filter_linear, repeat_disable; // irradiance of each light / light_unit
uniform sampler2D light_scale : filter_nearest, repeat_disable; // a column for each light: its factor as RGB
uniform int light_count = 0;
uniform float light_unit = 1.0; // W/m2
uniform int lamp = -1; // the light that this surface emits, if it is one
varying vec3 vertex_light;
varying vec2 light_place;

vec3 to_linear(vec3 c) {
	return mix(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, lessThan(c, vec3(0.04045)));
}

vec3 to_srgb(vec3 c) { // inverts the polynomial with which Compatibility decodes sRGB, by three Newton steps
	vec3 s = pow(c, vec3(1.0 / 2.4));
	for (int i = 0; i < 3; i++) {
		vec3 slope = s * (s * 0.915918033 + 1.364342222) + 0.012522878;
		s -= (s * (s * (s * 0.305306011 + 0.682171111) + 0.012522878) - c) / slope;
	}
	return s;
}

vec3 factor(int k) {
	return texelFetch(light_scale, ivec2(k, 0), 0).rgb;
}
"""

const VERTEX_RECEIVERS := """
void vertex() {
	ivec2 place = ivec2(%s + 0.5);
	vertex_light = vec3(0.0);
	for (int k = 0; k < light_count; k++)
		vertex_light += factor(k) * texelFetch(light, ivec3(place, k), 0).rgb;
}

vec3 irradiance() {
	return light_unit * vertex_light;
}
"""

const TEXEL_RECEIVERS := """
void vertex() {
	light_place = %s;
}

vec3 irradiance() {
	vec3 sum = vec3(0.0);
	for (int k = 0; k < light_count; k++)
		sum += factor(k) * texture(light, vec3(light_place, float(k))).rgb;
	return light_unit * sum;
}
"""

const PROBE_RECEIVERS := """
uniform vec3 probe[9]; // radiance in spherical harmonics of order 2, W/(sr m2)
uniform mat3 to_probes = mat3(1.0); // from world space
varying vec3 direction;

void vertex() {
	direction = to_probes * (MODEL_NORMAL_MATRIX * NORMAL);
}

vec3 irradiance() { // Ramamoorthi and Hanrahan 2001
	vec3 n = normalize(direction);
	vec3 sum = 0.88622693 * probe[0] + 1.02332671 * (n.y * probe[1] + n.z * probe[2] + n.x * probe[3]);
	sum += 0.85808553 * (n.x * n.y * probe[4] + n.y * n.z * probe[5] + n.x * n.z * probe[7]);
	sum += 0.24770796 * (3.0 * n.z * n.z - 1.0) * probe[6] + 0.42904276 * (n.x * n.x - n.y * n.y) * probe[8];
	return max(sum, vec3(0.0));
}
"""

const NO_RECEIVERS := """
vec3 irradiance() {
	return vec3(0.0);
}
"""

const END := """
void fragment() {
	vec2 uv = UV * base_scale + base_offset;
	vec4 base = texture(base_map, uv);
	vec3 emitted = texture(emission_map, uv).rgb;
	if (OUTPUT_IS_SRGB) {
		base.rgb = to_linear(base.rgb);
		emitted = to_linear(emitted);
	}
	base *= tint%s;
	float diffuse = 1.0 - metallic * dot(texture(metallic_map, uv), metallic_channel);
	vec3 radiance = base.rgb * diffuse * irradiance() / PI;
	radiance += emitted * emission * (lamp < 0 ? vec3(1.0) : factor(lamp));
	ALBEDO = OUTPUT_IS_SRGB ? to_srgb(radiance) : radiance;%s
}
"""

var _shaders := {}


## A material that looks like `source` under baked light.
## @param receivers "vertex", "texel", "probe" for objects that move, or "" for lamps without baked light
## @param uv_set of texture coordinates with the places of light
## @param colored how vertex colours multiply the base colour, in the shading language; "" if they do not
func convert(source: BaseMaterial3D, receivers: String, uv_set: int, colored: String) -> ShaderMaterial:
	var material := ShaderMaterial.new()
	material.resource_name = source.resource_name
	material.shader = _shader(_code(source, receivers, uv_set, colored))
	var tint := source.albedo_color.srgb_to_linear()
	material.set_shader_parameter("tint", Vector4(tint.r, tint.g, tint.b, source.albedo_color.a))
	material.set_shader_parameter("base_map", source.albedo_texture)
	material.set_shader_parameter("base_scale", Vector2(source.uv1_scale.x, source.uv1_scale.y))
	material.set_shader_parameter("base_offset", Vector2(source.uv1_offset.x, source.uv1_offset.y))
	material.set_shader_parameter("alpha_cutoff", source.alpha_scissor_threshold)
	if source.shading_mode != BaseMaterial3D.SHADING_MODE_UNSHADED:
		_copy_metal(source, material)
	if source.emission_enabled:
		var emission := source.emission.srgb_to_linear() * source.emission_energy_multiplier
		material.set_shader_parameter("emission", Vector3(emission.r, emission.g, emission.b))
		material.set_shader_parameter("emission_map", source.emission_texture)
	return material


func _copy_metal(source: BaseMaterial3D, material: ShaderMaterial) -> void:
	material.set_shader_parameter("metallic", source.metallic)
	material.set_shader_parameter("metallic_map", source.metallic_texture)
	var channel := Vector4(0, 0, 0, 0)
	channel[mini(source.metallic_texture_channel, 3)] = 1
	material.set_shader_parameter("metallic_channel", channel)


func _code(source: BaseMaterial3D, receivers: String, uv_set: int, colored: String) -> String:
	var modes := "unshaded"
	if source.cull_mode == BaseMaterial3D.CULL_DISABLED:
		modes += ", cull_disabled"
	var alpha := ""
	if source.transparency == BaseMaterial3D.TRANSPARENCY_ALPHA_SCISSOR:
		alpha = "\n\tif (base.a < alpha_cutoff)\n\t\tdiscard;"
	elif source.transparency != BaseMaterial3D.TRANSPARENCY_DISABLED:
		alpha = "\n\tALPHA = base.a;"
	var code := START % modes
	if receivers == "vertex":
		code += VERTEX_RECEIVERS % coordinates(uv_set)
	elif receivers == "texel":
		code += TEXEL_RECEIVERS % coordinates(uv_set)
	else:
		code += PROBE_RECEIVERS if receivers == "probe" else NO_RECEIVERS
	return code + END % [colored, alpha]


## Where Godot imports a set of texture coordinates.
static func coordinates(uv_set: int) -> String:
	if uv_set < 2:
		return ["UV", "UV2"][uv_set]
	return "CUSTOM%d.%s" % [(uv_set - 2) / 2, "xy" if uv_set % 2 == 0 else "zw"]


func _shader(code: String) -> Shader:
	if not _shaders.has(code):
		_shaders[code] = Shader.new()
		_shaders[code].code = code
	return _shaders[code]
