# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of Blender as glTF materials, by their shader nodes."""
import math

import bpy
import numpy as np

from .textures import Graph, Images, Value, resized, transform_extension

# Before 4.0, the Principled BSDF lost no diffuse light to what its coat reflects; here, coats transmit what they do
# not reflect. Base colours are raised by the ratio of both albedos, averaged over all directions:
# that of Disney's diffuse lobe (Burley 2012; linear in the roughness within 0.3 %), and 1 - the coat's reflectance,
# which agrees with that of Cycles within 0.003.
KEEPS_ENERGY = bpy.app.version >= (4, 0, 0)
DISNEY_SMOOTH, DISNEY_ROUGH = 0.9530, 1.0654
# Disney's lobe gives more than a Lambert surface towards grazing angles and 2.4 % less within 60 degrees of the normal,
# where surfaces are mostly seen: the mean is met halfway.
SEEN = 0.988
ROUGHNESSES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
# by reflectance at normal incidence: mean over all directions at these roughnesses, from white furnaces
REFLECTANCES = {0: (0,) * 6, 0.02: (0.0658, 0.0625, 0.0470, 0.0310, 0.0195, 0.0120),
                0.04: (0.0918, 0.0890, 0.0710, 0.0505, 0.0335, 0.0215),
                0.08: (0.1325, 0.1300, 0.1105, 0.0840, 0.0588, 0.0382)}


class Surface:
    """What a tree of shaders comes down to."""

    def __init__(self):
        self.base = Value((0, 0, 0))
        self.metallic, self.roughness = Value((0, 0, 0)), Value((1, 1, 1))
        self.emission, self.opacity = Value((0, 0, 0)), Value((1, 1, 1))
        self.specular, self.ior, self.transmission = 0.0, 1.5, Value((0, 0, 0))
        self.clearcoat = self.clearcoat_roughness = self.sheen = 0.0
        self.sheen_colour, self.sheen_roughness = (1, 1, 1), 0.5
        self.translucent, self.scatter = 0.0, None
        self.normal, self.normal_scale = None, 1.0
        self.gain = 1.0  # of the base colour


def coat_reflectance(f0, roughness):
    """Mean over all directions."""
    by_f0 = [float(np.interp(roughness, ROUGHNESSES, row)) for row in REFLECTANCES.values()]
    return float(np.interp(f0, list(REFLECTANCES), by_f0))


def ior_of_reflectance(f0):
    root = math.sqrt(min(max(f0, 0), 0.99))
    return (1 + root) / (1 - root)


class MaterialMaker:
    """Turns materials into glTF, each once."""

    def __init__(self, writer, report):
        self.writer, self.report = writer, report
        self.images = Images(writer, report)
        self.indices, self.uv_names, self.colour_names = {}, {}, {}
        self.names_taken = {}

    def index(self, material):
        """The glTF index of a material; None stands for Blender's default one."""
        key = material.name_full if material else None
        if key not in self.indices:
            self.indices[key] = self._make(material)
        return self.indices[key]

    def _make(self, material):
        if material is None or not (material.use_nodes and material.node_tree):
            surface = Surface()
            colour = material.diffuse_color[:3] if material else (0.8, 0.8, 0.8)
            surface.base = Value(colour)
            return self._write(surface, material.name if material else "default")
        surface = ShaderReader(material, self.report).read()
        self.uv_names[material.name_full] = surface.graph.uv_names(surface)
        texture = surface.base.texture
        if texture is not None and texture.channel == "vertex":
            self.colour_names[material.name_full] = texture.uv_name
        return self._write(surface, material.name)

    # ---- into glTF ----------------------------------------------------------------------------------

    def _texture_info(self, image_index, texture):
        if image_index is None:
            return None
        index = self.writer.add("textures", {"source": image_index, "sampler": self.images.sampler(texture)})
        info = {"index": index}
        if texture.uv_name:
            info["texCoord"] = 1
        if texture.transform is not None:
            extension = transform_extension(texture.transform)
            if extension is None:
                self.report.note(f"image '{texture.image.name}': its mapping shears, and is left out")
            else:
                self.writer.use_extension("KHR_texture_transform")
                info["extensions"] = {"KHR_texture_transform": extension}
        return info

    def _colour(self, value, most):
        """(factor, texture info) of a colour; where the factor exceeds `most`, it goes into the texels."""
        texture = value.texture
        if texture is None or texture.channel == "vertex":
            if value.factor.max() > most:
                self.report.note("a colour above what a surface can reflect is clamped")
            return np.clip(value.factor, 0, most), None
        gain = np.ones(3)
        factor = np.maximum(value.factor, 0)
        if factor.max() > most:
            gain, factor = factor, np.ones(3)
        info = self._texture_info(self.images.colour_image(texture, gain), texture)
        if info is None:
            return np.array([1.0, 0, 1]), None
        return factor, info

    def _number_texture(self, *parts):
        """One image whose channels are those of several textures: (channel index, Value)... Factors go into the texels."""
        textured = [(k, v) for k, v in parts if v.texture is not None and v.texture.image is not None]
        if not textured:
            return None
        first = textured[0][1].texture
        key = ("number",) + tuple((k, v.texture.image.name_full, v.texture.channel, round(v.number, 6))
                                  for k, v in textured)

        def make():
            arrays = {k: self.images.channel(v.texture) * v.number for k, v in textured}
            shape = max((a.shape for a in arrays.values()), key=lambda s: s[0] * s[1])
            codes = np.ones(shape + (4,), np.float32)
            for k, array in arrays.items():
                codes[..., k] = resized(array, shape)
            return codes
        return self._texture_info(self.images.data_image(key, first.image.name, make), first)

    def _write(self, s, name):
        pbr, extensions, extras = {}, {}, {}
        base = Value(s.base.factor * s.gain, s.base.texture)
        factor, info = self._colour(base, 1.0)
        json = {"name": self._unique(name), "pbrMetallicRoughness": pbr, "doubleSided": True}
        if info:
            pbr["baseColorTexture"] = info
        self._write_opacity(s, json, pbr, factor)
        self._write_metal(s, pbr)
        self._write_emission(s, json, extensions)
        if s.normal is not None:
            image = self.images.data_image(("normal", s.normal.image.name_full), s.normal.image.name,
                                           lambda: self._normals(s.normal.image))
            json["normalTexture"] = dict(self._texture_info(image, s.normal), scale=s.normal_scale)
        self._write_layers(s, json, extensions)
        if s.scatter is not None:
            extras["scatter_distance"] = [float(x) for x in s.scatter]
        if extensions:
            json["extensions"] = extensions
            for extension in extensions:
                self.writer.use_extension(extension)
        if extras:
            json["extras"] = {"resolvent": extras}
        return self.writer.add("materials", json)

    def _unique(self, name):
        count = self.names_taken.get(name, 0)
        self.names_taken[name] = count + 1
        return f"{name}.{count}" if count else name

    def _normals(self, image):
        pixels = self.images.linear(image)
        return np.full((1, 1, 3), (0.5, 0.5, 1)) if pixels is None else pixels[..., :3]

    def _write_opacity(self, s, json, pbr, factor):
        alpha = s.opacity
        if alpha.texture is None:
            opacity = min(max(alpha.number, 0), 1)
            pbr["baseColorFactor"] = factor.tolist() + [opacity]
            if opacity < 1:
                json["alphaMode"] = "BLEND"
            elif "baseColorTexture" in pbr:
                json["alphaMode"] = "OPAQUE"
            return
        pbr["baseColorFactor"] = factor.tolist() + [1]
        json["alphaMode"] = "BLEND"
        base, t = s.base.texture, alpha.texture
        own = base is not None and base.channel is None and base.image == t.image and t.channel == "a"
        if own and abs(alpha.number - 1) < 1e-6:
            return
        if "baseColorTexture" in pbr:
            colour = self.images.linear(base.image)
        else:
            colour = np.ones((1, 1, 4), np.float32)
        key = "covered", base.image.name_full if base else "", t.image.name_full, t.channel, round(alpha.number, 6)

        def make():
            from .formats import to_srgb
            mask = self.images.channel(t) * alpha.number
            shape = max(colour.shape[:2], mask.shape, key=lambda x: x[0] * x[1])
            return np.dstack([to_srgb(resized(colour, shape)[..., :3]), resized(mask, shape)])
        image = self.images.data_image(key, t.image.name, make)
        pbr["baseColorTexture"] = self._texture_info(image, base if base and base.channel is None else t)

    def _write_metal(self, s, pbr):
        info = self._number_texture((1, s.roughness), (2, s.metallic))
        for key, value in (("metallicFactor", s.metallic), ("roughnessFactor", s.roughness)):
            pbr[key] = 1.0 if value.texture else min(max(value.number, 0), 1)
        if info:
            pbr["metallicRoughnessTexture"] = info

    def _write_emission(self, s, json, extensions):
        peak = float(s.emission.factor.max())
        if peak <= 0:
            return
        json["emissiveFactor"] = (np.maximum(s.emission.factor, 0) / peak).tolist()
        extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": peak}
        texture = s.emission.texture
        if texture is None:
            return
        pixels = self.images.linear(texture.image)
        brightest = float(pixels[..., :3].max()) if pixels is not None and texture.image.is_float else 1.0
        gain = 1 / max(brightest, 1)
        extensions["KHR_materials_emissive_strength"]["emissiveStrength"] = peak / gain
        info = self._texture_info(self.images.colour_image(texture, np.full(3, gain)), texture)
        if info:
            json["emissiveTexture"] = info

    def _write_layers(self, s, json, extensions):
        extensions["KHR_materials_ior"] = {"ior": max(s.ior, 1.0)}
        if s.specular < 1:
            extensions["KHR_materials_specular"] = {"specularFactor": s.specular}
        if s.transmission.texture is not None or s.transmission.number > 0:
            textured = s.transmission.texture is not None
            extensions["KHR_materials_transmission"] = {"transmissionFactor": 1 if textured else s.transmission.number}
            if textured:
                extensions["KHR_materials_transmission"]["transmissionTexture"] = \
                    self._number_texture((0, s.transmission))
            extensions["KHR_materials_volume"] = {"thicknessFactor": 1.0}
            json["doubleSided"] = False  # a body has an inside
        if s.clearcoat > 0:
            extensions["KHR_materials_clearcoat"] = {"clearcoatFactor": min(s.clearcoat, 1),
                                                     "clearcoatRoughnessFactor": s.clearcoat_roughness}
        if s.sheen > 0:
            extensions["KHR_materials_sheen"] = {
                "sheenColorFactor": [min(float(c) * s.sheen, 1) for c in s.sheen_colour],
                "sheenRoughnessFactor": s.sheen_roughness}
        if s.translucent > 0:
            extensions["KHR_materials_diffuse_transmission"] = {
                "diffuseTransmissionFactor": s.translucent, "diffuseTransmissionColorFactor": [1, 1, 1]}


class ShaderReader:
    """Follows the shaders of one material."""

    def __init__(self, material, report):
        self.material, self.report = material, report
        self.graph = UvGraph(f"material '{material.name}'", report)

    def read(self):
        tree = self.material.node_tree
        output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
        surface = None
        if output is not None:
            for name in ("Volume", "Displacement"):
                if output.inputs[name].is_linked:
                    self.graph.note(output, f"has something at '{name}', which is left out")
            source = self.graph.source(output.inputs["Surface"])
            surface = self.shader(source, 0) if source else None
        surface = surface or Surface()
        surface.graph = self.graph
        return surface

    def shader(self, socket, depth):
        node = socket.node
        if depth > 32:
            return None
        read = {"BSDF_PRINCIPLED": self.principled, "BSDF_DIFFUSE": self.diffuse, "BSDF_GLOSSY": self.glossy,
                "BSDF_GLASS": self.glass, "BSDF_REFRACTION": self.glass, "BSDF_TRANSPARENT": self.transparent,
                "BSDF_TRANSLUCENT": self.translucent, "EMISSION": self.emission,
                "SUBSURFACE_SCATTERING": self.subsurface, "BACKGROUND": self.emission}.get(node.type)
        if read:
            return read(node)
        if node.type == "MIX_SHADER":
            return self.mix(node, depth)
        if node.type == "ADD_SHADER":
            return self.add(node, depth)
        if node.type == "GROUP" and node.node_tree:
            return self.group(socket, depth)
        self.graph.note(node, "has no counterpart and is shown black")
        return Surface()

    def group(self, socket, depth):
        tree = socket.node.node_tree
        end = next((n for n in tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
        inner = end.inputs.get(socket.name) if end else None
        source = self.graph.source(inner) if inner else None
        if source is None or source.node.type == "GROUP_INPUT":
            return Surface()
        outer, self.graph.group = getattr(self.graph, "group", None), socket.node
        try:
            return self.shader(source, depth + 1)
        finally:
            self.graph.group = outer

    def constant(self, node, *names, default=0.0):
        """A number without texture: the first of these sockets that there is."""
        socket = next((node.inputs[n] for n in names if n in node.inputs), None)
        if socket is None:
            return default
        value = self.graph.value(socket)
        if value.texture is not None:
            self.graph.note(node, f"has a texture at '{socket.name}', of which the socket's own value is used")
            return float(self.graph.default(socket).mean())
        return value.number

    def textured(self, node, *names):
        socket = next((node.inputs[n] for n in names if n in node.inputs), None)
        return self.graph.value(socket) if socket else Value((0, 0, 0))

    # ---- single shaders -----------------------------------------------------------------------------

    def diffuse(self, node):
        s = Surface()
        s.base = self.textured(node, "Color")
        if self.constant(node, "Roughness") > 0:
            self.graph.note(node, "is shown without its roughness, as a Lambert surface")
        self.normal(node, s)
        return s

    def glossy(self, node):
        s = Surface()
        s.base, s.metallic = self.textured(node, "Color"), Value((1, 1, 1))
        s.roughness = self.roughness(node)
        self.normal(node, s)
        return s

    def roughness(self, node):
        if getattr(node, "distribution", "") == "SHARP":
            return Value((0, 0, 0))
        return self.textured(node, "Roughness")

    def glass(self, node):
        s = Surface()
        if node.type == "BSDF_REFRACTION":
            self.graph.note(node, "also reflects, as glass does")
        s.base, s.roughness = self.textured(node, "Color"), self.roughness(node)
        s.specular, s.ior, s.transmission = 1.0, self.constant(node, "IOR", default=1.45), Value((1, 1, 1))
        self.normal(node, s)
        return s

    def transparent(self, node):
        s = Surface()
        colour = self.textured(node, "Color")
        if colour.texture is not None or np.ptp(colour.factor) > 1e-3:
            self.graph.note(node, "passes light without its colour, by its mean alone")
        s.opacity = Value((1 - min(colour.number, 1),) * 3)
        return s

    def translucent(self, node):
        s = Surface()
        s.base, s.translucent = self.textured(node, "Color"), 1.0
        return s

    def emission(self, node):
        s = Surface()
        colour, strength = self.textured(node, "Color"), self.constant(node, "Strength", default=1.0)
        s.emission = Value(np.maximum(colour.factor * strength, 0), colour.texture)
        return s

    def subsurface(self, node):
        s = Surface()
        s.base = self.textured(node, "Color")
        radius = self.graph.default(node.inputs["Radius"]) * self.constant(node, "Scale")
        s.scatter = np.maximum(radius, 0)
        return s

    def principled(self, node):
        s = Surface()
        s.base = self.textured(node, "Base Color")
        s.metallic, s.roughness = self.textured(node, "Metallic"), self.textured(node, "Roughness")
        s.transmission = self.textured(node, "Transmission", "Transmission Weight")
        s.opacity = self.textured(node, "Alpha")
        self.principled_emission(node, s)
        self.principled_reflectance(node, s)
        s.clearcoat = self.constant(node, "Clearcoat", "Coat Weight")
        s.clearcoat_roughness = self.constant(node, "Clearcoat Roughness", "Coat Roughness")
        self.principled_sheen(node, s)
        self.principled_subsurface(node, s)
        for name, what in (("Anisotropic", "anisotropy"), ("Thin Film Thickness", "thin film")):
            if name in node.inputs and self.constant(node, name) > 0:
                self.graph.note(node, f"is shown without {what}")
        self.normal(node, s)
        return s

    def principled_emission(self, node, s):
        colour = self.textured(node, "Emission", "Emission Color")
        strength = self.constant(node, "Emission Strength", default=1.0)
        s.emission = Value(np.maximum(colour.factor * strength, 0), colour.texture)

    def principled_reflectance(self, node, s):
        """The index of refraction and the share of the reflectance, and what the base colour gains."""
        transmits = s.transmission.texture is not None or s.transmission.number > 0
        level = self.constant(node, "Specular", "Specular IOR Level", default=0.5)
        s.specular = 1.0
        if transmits:
            s.ior = self.constant(node, "IOR", default=1.45)
        elif KEEPS_ENERGY:
            ior = self.constant(node, "IOR", default=1.45)
            s.ior = ior_of_reflectance(((ior - 1) / (ior + 1)) ** 2 * 2 * level)
        else:
            s.ior = ior_of_reflectance(0.08 * level)
        if s.ior <= 1:
            s.ior, s.specular = 1.5, 0.0
        tint = self.textured(node, "Specular Tint")
        if not KEEPS_ENERGY and (tint.texture is not None or tint.number > 0):
            self.graph.note(node, "is shown without its specular tint")
        rough = 0.5 if s.roughness.texture else s.roughness.number
        if not KEEPS_ENERGY and s.metallic.texture is None and s.metallic.number < 1 and not transmits:
            f0 = ((s.ior - 1) / (s.ior + 1)) ** 2 if s.specular else 0
            diffuse = DISNEY_SMOOTH + (DISNEY_ROUGH - DISNEY_SMOOTH) * rough
            gain = SEEN * diffuse / (1 - coat_reflectance(f0, rough))
            s.gain = gain + (1 - gain) * s.metallic.number

    def principled_sheen(self, node, s):
        s.sheen = self.constant(node, "Sheen", "Sheen Weight")
        s.sheen_roughness = self.constant(node, "Sheen Roughness", default=0.5)
        if s.sheen > 0 and not KEEPS_ENERGY:
            self.graph.note(node, "has a sheen of another shape than here")

    def principled_subsurface(self, node, s):
        share = self.constant(node, "Subsurface", "Subsurface Weight")
        if share <= 0:
            return
        scale = self.constant(node, "Subsurface Scale") if "Subsurface Scale" in node.inputs else share
        s.scatter = np.maximum(self.graph.default(node.inputs["Subsurface Radius"]) * scale, 0)
        if "Subsurface Color" in node.inputs and share >= 0.5:
            s.base = self.textured(node, "Subsurface Color")

    def normal(self, node, s):
        socket = node.inputs.get("Normal")
        source = self.graph.source(socket) if socket else None
        if source is None:
            return
        if source.node.type != "NORMAL_MAP" or source.node.space != "TANGENT":
            self.graph.note(source.node, "has no counterpart; normals are those of the mesh")
            return
        colour = self.graph.value(source.node.inputs["Color"])
        if colour.texture is None or colour.texture.image is None:
            return
        s.normal, s.normal_scale = colour.texture, self.constant(source.node, "Strength", default=1.0)
        if source.node.uv_map and s.normal.uv_name is None:
            s.normal.uv_name = source.node.uv_map

    # ---- several ------------------------------------------------------------------------------------

    def add(self, node, depth):
        parts = [self.graph.source(i) for i in node.inputs]
        parts = [self.shader(p, depth + 1) for p in parts if p]
        return self.combined(node, [(p, 1.0) for p in parts if p])

    def mix(self, node, depth):
        share = self.graph.value(node.inputs[0])
        ends = [self.graph.source(i) for i in node.inputs[1:3]]
        a, b = (self.shader(e, depth + 1) if e else Surface() for e in ends)
        a, b = a or Surface(), b or Surface()
        fresnel = self.graph.source(node.inputs[0])
        if fresnel is not None and fresnel.node.type in {"FRESNEL", "LAYER_WEIGHT"}:
            return self.coated(node, a, b, fresnel.node)
        if share.texture is not None:
            return self.cut_out(node, share, a, b)
        f = min(max(share.number, 0), 1)
        if f in (0, 1):
            return b if f else a
        return self.combined(node, [(a, 1 - f), (b, f)])

    def coated(self, node, a, b, fresnel):
        """A rough layer over a base by Fresnel's formulas: what a dielectric is."""
        if b.metallic.number == 1 and a.transmission.number == 0:
            a.ior = self.constant(fresnel, "IOR", default=1.45) if fresnel.type == "FRESNEL" else 1.5
            a.specular, a.roughness = 1.0, b.roughness
            return a
        self.graph.note(node, "mixes by the angle, which is left out: its first shader is shown")
        return a

    def cut_out(self, node, share, a, b):
        clear_a, clear_b = (x.opacity.texture is None and x.opacity.number == 0 for x in (a, b))
        if clear_a and not clear_b:
            b.opacity = share
            return b
        if clear_b and not clear_a:
            self.graph.note(node, "has a mask that would have to be inverted; the first shader is shown everywhere")
            return a
        self.graph.note(node, "mixes two shaders by a texture, which is left out: half of each is shown")
        return self.combined(node, [(a, 0.5), (b, 0.5)])

    def combined(self, node, parts):
        """A sum of shaders as one: exact where they are opaque kinds of different lobes, or clear."""
        parts = [(p, w) for p, w in parts if w > 0]
        if not parts:
            return Surface()
        if len(parts) == 1 and parts[0][1] == 1:
            return parts[0][0]
        clear = [(p, w) for p, w in parts if p.opacity.texture is None and p.opacity.number == 0]
        solid = [(p, w) for p, w in parts if (p, w) not in clear]
        covered = sum(w for _, w in solid)
        total = covered + sum(w for _, w in clear)
        result = self.blended(node, solid, covered) if solid else Surface()
        if clear and total > covered:
            result.opacity = Value(result.opacity.factor * covered / total, result.opacity.texture)
        return result

    def blended(self, node, parts, total):
        glowing = [(p, w) for p, w in parts if p.emission.texture or p.emission.factor.any()]
        lit = [(p, w) for p, w in parts if not is_black(p)]
        result = max(lit, key=lambda x: x[1])[0] if lit else Surface()
        if len(lit) == 1 and len(parts) > 1 and total <= 1:
            result.base = Value(result.base.factor * lit[0][1] / total, result.base.texture)
        elif len(lit) > 1:
            self.mean_surface(node, result, lit)
        emission = sum((p.emission.factor * w for p, w in glowing), np.zeros(3))
        textures = [p.emission.texture for p, _ in glowing if p.emission.texture]
        if len(textures) > 1 or (textures and len(glowing) > 1):
            self.graph.note(node, "adds up several emissions, of which one keeps its texture")
        result.emission = Value(emission / (total if total <= 1 else 1), textures[0] if textures else None)
        return result

    def mean_surface(self, node, result, lit):
        """Diffuse, translucent and metallic parts add up in one material as long as they have one colour."""
        total = sum(w for _, w in lit)
        share = lambda get: sum(w * get(p) for p, w in lit) / total
        kinds = {(p.metallic.number >= 0.5, p.transmission.number >= 0.5, p.translucent >= 0.5) for p, _ in lit}
        textures = [p.base.texture for p, _ in lit if p.base.texture]
        result.metallic = Value((share(lambda p: p.metallic.number),) * 3)
        result.transmission = Value((share(lambda p: p.transmission.number),) * 3)
        result.translucent = share(lambda p: p.translucent)
        base = sum((p.base.factor * w for p, w in lit), np.zeros(3)) / total
        result.base = Value(base, textures[0] if textures else None)
        if len(kinds) > 1 or len(textures) > 1:
            self.graph.note(node, "mixes shaders of different kinds; they are shown as one of their mean colour")


def is_black(s):
    return s.base.texture is None and not s.base.factor.any() and s.specular == 0 and s.transmission.number == 0 \
        and s.clearcoat == 0 and s.sheen == 0


class UvGraph(Graph):
    @staticmethod
    def uv_names(surface):
        """UV maps that the surface's textures ask for by name."""
        values = [surface.base, surface.metallic, surface.roughness, surface.emission, surface.opacity,
                  surface.transmission]
        textures = [v.texture for v in values if v.texture is not None] + ([surface.normal] if surface.normal else [])
        return [t.uv_name for t in textures if t.uv_name and t.channel != "vertex"]
