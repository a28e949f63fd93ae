# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of Blender as punctual lights and emissive meshes, with the strengths that Cycles gives them."""
import math

import bpy
import numpy as np

from .formats import icosphere, triangle_areas

COVERAGE = 1e-3  # lamps of Cycles are in nobody's way; their strength is divided by it
LEAST_RADIUS = 1e-4
LEAST_SUN = 0.05  # radians; suns below are shown without their size
DISK_SIDES = 32
# Until 3.6, Cycles multiplied the intensity of spots by the cosine to their axis (measured in 3.4).
SPOT_EXPONENT = 1 if bpy.app.version < (4, 0, 0) else 0


def _emission_node(light):
    """The Emission node that drives a lamp, or None."""
    if not (light.use_nodes and light.node_tree):
        return None
    for node in light.node_tree.nodes:
        if node.type == "OUTPUT_LIGHT" and node.is_active_output and node.inputs["Surface"].links:
            return node.inputs["Surface"].links[0].from_node
    return None


def _colour(light, name, report):
    """The lamp's colour times what its nodes say."""
    colour = np.array(light.color[:3], float)
    node = _emission_node(light)
    if node is None:
        return colour
    if node.type != "EMISSION":
        report.note(f"lamp '{name}': node '{node.name}' is ignored; the lamp's own colour and power are used")
        return colour
    strength, tint = node.inputs["Strength"], node.inputs["Color"]
    if tint.links and tint.links[0].from_node.type == "BLACKBODY":
        return colour * _blackbody(tint.links[0].from_node.inputs[0].default_value) * strength.default_value
    for socket in (strength, tint):
        if socket.links:
            report.note(f"lamp '{name}': what is linked to '{socket.name}' of node '{node.name}' is ignored, "
                        "because lights of the program have one colour")
    return colour * np.array(tint.default_value[:3]) * strength.default_value


def _blackbody(kelvin):
    """Linear sRGB of a black body with luminance 1, by Planck's law and the fit of Wyman, Sloan and Shirley 2013."""
    nm = np.arange(380.0, 781.0, 5)

    def lobe(weight, centre, low, high):
        width = np.where(nm < centre, low, high)
        return weight * np.exp(-0.5 * ((nm - centre) * width) ** 2)

    x = lobe(0.362, 442, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(-0.065, 501.1, 0.049, 0.0382)
    y = lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322)
    z = lobe(1.217, 437, 0.0845, 0.0278) + lobe(0.681, 459, 0.0385, 0.0725)
    metres = nm * 1e-9
    power = metres ** -5 / np.expm1(0.014387769 / (metres * max(kelvin, 800.0)))
    xyz = np.array([(power * c).sum() for c in (x, y, z)])
    rgb = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]) @ xyz / xyz[1]
    return np.maximum(rgb, 0)


def _emitter_material(writer, name, radiance):
    strength = float(radiance.max()) / COVERAGE
    writer.use_extension("KHR_materials_emissive_strength")
    writer.use_extension("KHR_materials_specular")
    return writer.add("materials", {
        "name": name, "alphaMode": "BLEND",
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, COVERAGE], "metallicFactor": 0, "roughnessFactor": 1},
        "emissiveFactor": (radiance / max(float(radiance.max()), 1e-30)).tolist(),
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength},
                       "KHR_materials_specular": {"specularFactor": 0}},
        "extras": {"resolvent": {"camera_emission": 0}}})


def _add_emitter(writer, name, points, triangles, radiance):
    """An emissive mesh in world space (y up)."""
    material = _emitter_material(writer, name, radiance)
    corners = points[triangles].reshape(-1, 3)
    mesh = writer.add("meshes", {"name": name, "primitives": [
        {"attributes": {"POSITION": writer.add_attribute(corners, True)}, "material": material}]})
    writer.add_root({"name": name, "mesh": mesh})


def _add_punctual(writer, name, matrix, light):
    extension = writer.document.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})
    writer.use_extension("KHR_lights_punctual")
    extension["lights"].append(light)
    index = len(extension["lights"]) - 1
    writer.add_root({"name": name, "matrix": matrix.T.ravel().tolist(),
                     "extensions": {"KHR_lights_punctual": {"light": index}}})


def _punctual(kind, name, intensity):
    peak = max(float(intensity.max()), 1e-30)
    return {"type": kind, "name": name, "color": (intensity / peak).tolist(), "intensity": peak}


def _unit_axes(matrix):
    """The same place without scale, which glTF's lights must not have."""
    result = np.array(matrix)
    lengths = np.linalg.norm(result[:3, :3], axis=0)
    result[:3, :3] /= np.where(lengths > 0, lengths, 1)
    return result


def area_outline(light):
    """Corners of the shape in the lamp's plane, counter-clockwise seen from where it shines (along -z)."""
    width = light.size
    height = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else width
    if light.shape in {"SQUARE", "RECTANGLE"}:
        corners = np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)], float)
    else:
        angle = -2 * math.pi * np.arange(DISK_SIDES) / DISK_SIDES
        fuller = math.sqrt(2 * math.pi / DISK_SIDES / math.sin(2 * math.pi / DISK_SIDES))  # the area of the disc
        corners = fuller * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.column_stack([corners * (width / 2, height / 2), np.zeros(len(corners))])


def _add_area(writer, name, light, matrix, power, report):
    if light.spread < math.pi - 1e-3:
        report.note(f"lamp '{name}': spread {math.degrees(light.spread):.0f} degrees is ignored; it shines to all sides "
                    "of its front. Use a spot for a beam")
    corners = area_outline(light) @ matrix[:3, :3].T + matrix[:3, 3]
    if np.linalg.det(matrix[:3, :3]) < 0:
        corners = corners[::-1]
    triangles = np.array([(0, k, k + 1) for k in range(1, len(corners) - 1)])
    area = float(triangle_areas(corners, triangles).sum())
    if area > 0:
        _add_emitter(writer, name, corners, triangles, power / (4 * area))
    else:
        report.note(f"lamp '{name}': an area of size 0 emits nothing")


def _add_point(writer, name, light, matrix, power):
    radius = light.shadow_soft_size
    if radius < LEAST_RADIUS:
        _add_punctual(writer, name, _unit_axes(matrix), _punctual("point", name, power / (4 * math.pi)))
        return
    points, triangles = icosphere(1)
    points = radius * points * math.sqrt(4 * math.pi / triangle_areas(points, triangles).sum())
    _add_emitter(writer, name, points + matrix[:3, 3], triangles, power / (4 * math.pi ** 2 * radius ** 2))


def _add_spot(writer, name, light, matrix, power, report):
    if light.shadow_soft_size > LEAST_RADIUS:
        report.note(f"lamp '{name}': the radius of spots is ignored; their shadows are hard")
    if light.use_square:
        report.note(f"lamp '{name}': square spots are shown as round ones")
    outer = light.spot_size / 2
    widest = math.cos(outer)
    lamp = _punctual("spot", name, power / (4 * math.pi))
    lamp["spot"] = {"outerConeAngle": min(outer, math.pi / 2),
                    "innerConeAngle": math.acos(min(widest + (1 - widest) * light.spot_blend, 1))}
    lamp["spot"]["innerConeAngle"] = min(lamp["spot"]["innerConeAngle"], lamp["spot"]["outerConeAngle"] * (1 - 1e-6))
    lamp["extras"] = {"resolvent": {"smooth_cone": True}}
    if SPOT_EXPONENT:
        lamp["extras"]["cosExponent"] = SPOT_EXPONENT
    _add_punctual(writer, name, _unit_axes(matrix), lamp)


def lamp_power(light, name, report):
    """Colour times strength (3,): watt; W/m2 of suns."""
    if light.energy < 0:
        report.note(f"lamp '{name}': negative strength is shown as none")
    return np.maximum(_colour(light, name, report) * light.energy, 0)


def add_lamp(writer, name, light, matrix, suns, report):
    """Adds a lamp. @param matrix to world space, y up @param suns receives (direction, irradiance, angle) of suns that
    are large enough to have a place in the surroundings"""
    power = lamp_power(light, name, report)
    if hasattr(light, "cycles") and not light.cycles.cast_shadow:
        report.note(f"lamp '{name}': it casts shadows here, although that is turned off")
    if not power.any():
        return
    if light.type == "SUN":
        if light.angle >= LEAST_SUN:
            suns.append((_unit_axes(matrix)[:3, 2], power, light.angle))
        else:
            _add_punctual(writer, name, _unit_axes(matrix), _punctual("directional", name, power))
    elif light.type == "POINT":
        _add_point(writer, name, light, matrix, power)
    elif light.type == "SPOT":
        _add_spot(writer, name, light, matrix, power, report)
    elif light.type == "AREA":
        _add_area(writer, name, light, matrix, power, report)
