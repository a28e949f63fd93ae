"""Scenes of arrays, by name and from files; wrong arrays."""
import os
import tempfile
import unittest

import numpy as np

import resolvent
from fixtures import CUBE, INWARDS, SMALL, UP, furnace, lamps
from resolvent import Camera, Environment, Fog, Material, Mesh, PunctualLight, Scene, Texture


class Arrays(unittest.TestCase):
    def test_arrays_come_back(self):
        scene = lamps()
        self.assertEqual(scene.vertices[scene.triangles].shape, (12, 3, 3))
        self.assertAlmostEqual(float(np.ptp(scene.vertices)), 1)
        np.testing.assert_allclose(scene.bounds, [[0, 0, 0], [1, 1, 1]])
        names = [scene.materials[k].name for k in scene.triangle_materials]
        self.assertEqual(sorted(names), ["grey"] * 10 + ["red"] * 2)
        red = scene.vertices[scene.triangles[np.array(names) == "red"]]
        self.assertTrue((red[..., 0] == 0).all())
        self.assertEqual([light.name for light in scene.lights], ["white", "blue"])
        np.testing.assert_allclose(scene.lights[1].position, (0.2, 0.4, 0.3), rtol=1e-6)
        camera = scene.cameras[0]
        self.assertEqual(camera.name, "corner")
        np.testing.assert_allclose(camera.position, (0.9, 0.5, 0.9), rtol=1e-6)
        self.assertEqual(Material.lambert(0.25).base_color, 0.25)

    def test_any_layout_of_arrays_is_the_same_scene(self):
        material = Material.lambert(0.5)
        expected = Scene.from_meshes(Mesh(CUBE, INWARDS, material=material)).fingerprint()
        backwards = np.ascontiguousarray(CUBE[::-1])
        for vertices in (np.asfortranarray(CUBE), CUBE.astype(np.float64), backwards[::-1], CUBE.tolist(),
                         np.repeat(CUBE, 2, axis=0)[::2], CUBE.astype(">f4"), CUBE.astype(np.int8)):
            for triangles in (INWARDS, np.asfortranarray(INWARDS), INWARDS.astype(np.uint8), INWARDS.tolist()):
                scene = Scene.from_meshes(Mesh(vertices, triangles, material=material))
                self.assertEqual(scene.fingerprint(), expected)

    def test_vertices_without_indices_are_triangles(self):
        scene = Scene.from_meshes(Mesh(CUBE[INWARDS].reshape(-1, 3)))
        self.assertEqual(len(scene.triangles), 12)

    def test_colors_of_triangles_are_albedo(self):
        colors = np.full((12, 3), 0.25)
        colors[:, 0] = 0.5
        wall = Material.lambert(1, "wall", emission=1 / np.pi)
        light = Scene.from_meshes(Mesh(CUBE, INWARDS, material=wall, triangle_colors=colors)).solve("draft", **SMALL)
        reading = light.irradiance([0.3, 0, 0.4], UP)
        np.testing.assert_allclose(reading, [2, 4 / 3, 4 / 3], rtol=0.01)

    def test_textures_are_albedo(self):
        wall = Material.lambert(1, "wall", emission=1 / np.pi)
        wall.textures["base_color"] = Texture(np.full((2, 2, 3), 0.5))
        uvs = CUBE[:, :2]
        light = Scene.from_meshes(Mesh(CUBE, INWARDS, material=wall, uvs=uvs)).solve("draft", **SMALL)
        np.testing.assert_allclose(light.irradiance([0.3, 0, 0.4], UP), [2, 2, 2], rtol=0.01)

    def test_instances_are_placed(self):
        transforms = np.stack([np.eye(4)] * 2)
        transforms[1, :3, 3] = (2, 0, 0)
        scene = Scene.from_meshes(Mesh(CUBE, INWARDS, transforms=transforms))
        np.testing.assert_allclose(scene.bounds, [[0, 0, 0], [3, 1, 1]])
        self.assertEqual(len(scene.object_names), 2)

    def test_surroundings(self):
        corners = [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]]
        floor = Mesh(corners, [[0, 1, 2], [0, 2, 3]], material=Material.lambert(0.5))
        for environment in (np.ones((4, 8, 3)), "white", Environment(np.full((4, 8, 3), 0.5), intensity=2)):
            scene = Scene.from_meshes(floor, environment=environment)
            reading = scene.reference_irradiance([0.5, 0.001, 0.5], UP, samples=256)
            np.testing.assert_allclose(reading, [np.pi] * 3, rtol=0.01)
            self.assertEqual(scene.environment.source.shape[2], 3)

    def test_fog_takes_what_it_absorbs(self):
        corners = [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]]
        floor = Mesh(corners, [[0, 1, 2], [0, 2, 3]], material=Material.lambert(0.5))
        sun = PunctualLight("directional", np.pi)
        fog = Fog((0.5, 1, 2), albedo=0, bounds=[[-9, 0.5, -9], [9, 2.5, 9]])
        scene = Scene.from_meshes(floor, lights=[sun], fog=fog)
        reading = scene.reference_irradiance([0.5, 0, 0.5], UP, samples=4096)
        np.testing.assert_allclose(reading, np.pi * np.exp(-2 * np.array([0.5, 1, 2])), rtol=0.02)  # Beer and Lambert
        light = scene.solve("draft")
        np.testing.assert_allclose(light.irradiance([0.5, 0, 0.5], UP), reading, rtol=0.02)

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "room.glb")
            lamps().save(path)
            scene = Scene.load(path)
            self.assertEqual(len(scene.triangles), 12)
            self.assertEqual({light.name for light in scene.lights}, {"white", "blue"})
            picture = scene.reference(width=8, height=6, samples=1)
            file = os.path.join(folder, "a.exr")
            resolvent.write_image(file, picture, {"twice": 2 * picture})
            np.testing.assert_array_equal(resolvent.read_image(file), picture)
        self.assertIn("gallery", Scene.builtin_names())
        self.assertIn("12 triangles", repr(Scene.builtin("furnace")))


class Mistakes(unittest.TestCase):
    def refuses(self, kind, pattern, make, *arguments, **options):
        with self.assertRaisesRegex(kind, pattern) as caught:
            make(*arguments, **options)
        self.assertNotIn("\n", str(caught.exception))

    def mesh(self, pattern, kind=ValueError, vertices=CUBE, triangles=INWARDS, **fields):
        self.refuses(kind, pattern, Scene.from_meshes, Mesh(vertices, triangles, **fields))

    def test_meshes(self):
        nan = CUBE.copy()
        nan[3, 1] = np.nan
        self.mesh(r"vertices\[3, 1\] is nan", vertices=nan)
        self.mesh(r"vertices\[0, 0\] is inf", vertices=CUBE.astype(float) + 1e300)
        self.mesh(r"shape \(8, 2\); expected \(V, 3\)", vertices=CUBE[:, :2])
        self.mesh("dtype complex", TypeError, vertices=CUBE.astype(complex))
        self.mesh("dtype bool", TypeError, vertices=CUBE.astype(bool))
        self.mesh("dtype <U", TypeError, vertices=[["a", "b", "c"]])
        self.mesh("None", TypeError, vertices=None)
        self.mesh("", (ValueError, TypeError), vertices=[[0, 0, 0], [1, 2]])
        self.mesh("no triangle", triangles=np.zeros((0, 3), int))
        self.mesh("", vertices=np.zeros((0, 3)))
        self.mesh(r"triangles\[0, 2\] is 8; expected 0..7", triangles=[[0, 1, 8]])
        self.mesh(r"triangles\[0, 0\] is -1", triangles=[[-1, 1, 2]])
        self.mesh("expected integers", TypeError, triangles=INWARDS.astype(float))
        self.mesh("8 vertices without triangles", triangles=None)
        self.mesh(r"normals: shape \(7, 3\); expected \(8, 3\)", normals=CUBE[:7])
        self.mesh("uvs", uvs=CUBE)
        self.mesh("triangle_colors", triangle_colors=np.ones((11, 3)))
        self.mesh("both", vertex_colors=np.ones((8, 3)), triangle_colors=np.ones((12, 3)))
        self.mesh("transforms", transforms=np.eye(3))
        self.mesh("2 materials; triangle_materials", material=[Material(), Material()])
        self.mesh(r"triangle_materials\[1\] is 2", material=[Material()] * 2, triangle_materials=[0, 2] * 6)
        self.mesh("not a Material", TypeError, material=["red"])
        self.mesh("no material", material=[])
        self.refuses(TypeError, "not a Mesh", Scene.from_meshes, [CUBE])
        self.refuses(resolvent.ResolventError, "", Scene.from_meshes, [])

    def test_materials_and_lights(self):
        self.mesh("base_color", material=Material(base_color=(1, 2)))
        self.mesh("roughness", TypeError, material=Material(roughness="rough"))
        self.mesh("roughness", material=Material(roughness=np.nan))
        self.mesh("there is no 'colour'", material=Material(textures={"colour": Texture(np.ones((2, 2)))}))
        self.mesh("not a Texture", TypeError, material=Material(textures={"normal": np.ones((2, 2))}))
        self.mesh("pixels", material=Material(textures={"normal": Texture(np.ones((2, 2, 5)))}))
        self.mesh("int64", TypeError, material=Material(textures={"normal": Texture(np.ones((2, 2), np.int64))}))
        self.refuses(ValueError, "there is no 'cheese'; there are .*marble", Material.preset, "cheese")
        room = Mesh(CUBE, INWARDS)
        for pattern, light in (("kind", PunctualLight("laser")), ("position", PunctualLight(position=(0, 0))),
                               ("direction is zero", PunctualLight("spot", direction=(0, 0, 0))),
                               ("outer_cone_angle", PunctualLight("spot", outer_cone_angle=4))):
            self.refuses(ValueError, pattern, Scene.from_meshes, room, lights=[light])
        self.refuses(ValueError, "target", Scene.from_meshes, room, cameras=[Camera((0, 0, 0), (0, 0, 0))])
        self.refuses(ValueError, "fog: bounds", Scene.from_meshes, room, fog=Fog(1, bounds=[[0, 0, 0], [1, 0, 1]]))
        self.refuses(resolvent.ArgumentError, "extinction", Scene.from_meshes, room, fog=Fog(-1))
        self.refuses(TypeError, "not a Fog", Scene.from_meshes, room, fog=1)
        self.refuses(ValueError, "environment", Scene.from_meshes, room, environment=np.ones((4, 8)))

    def test_files(self):
        self.refuses(resolvent.FileError, "nowhere.glb", Scene.load, "/nowhere.glb")
        self.refuses(OSError, "nowhere.glb", Scene.load, "/nowhere.glb")
        self.refuses(TypeError, "path", Scene.load, 3)
        self.refuses(ValueError, "zero", Scene.load, "a\0b")
        self.refuses(resolvent.ArgumentError, "cornell", Scene.builtin, "cornel-blocks")
        with tempfile.NamedTemporaryFile(suffix=".glb") as file:
            file.write(b"glTF nonsense")
            file.flush()
            self.refuses(resolvent.FormatError, "", Scene.load, file.name)
            self.refuses(resolvent.ResolventError, "", resolvent.Light.load, file.name)
        self.refuses(resolvent.ResolventError, "", resolvent.write_image, "/nowhere/a.exr", np.ones((2, 2, 3)))
        self.refuses(ValueError, "picture", resolvent.write_image, "a.exr", np.ones((2, 2)))

    def test_solves(self):
        scene = furnace()
        self.refuses(ValueError, "there is no 'best'; there are draft", scene.solve, "best")
        self.refuses(TypeError, "no option 'elements'; there are .*element_target", scene.solve, elements=3)
        self.refuses(TypeError, "max_seconds requires", scene.solve, max_seconds=3)
        self.refuses(TypeError, "element_target", scene.solve, element_target=3.5)
        self.refuses(ValueError, "element_target: -1", scene.solve, element_target=-1)
        self.refuses(resolvent.ArgumentError, "rays_per_element", scene.solve, rays_per_element=100)
        self.refuses(ValueError, "camera: there is no 'x'; there are framing", scene.solve, goal="x")
        self.refuses(ValueError, "camera: 3", scene.solve, goal=3)
        self.refuses(TypeError, "goal", scene.solve, goal=np.ones(3))
        self.refuses(ValueError, "goal: there are no points", scene.solve, goal=(np.zeros((0, 3)), UP))
        self.refuses(resolvent.SceneError, "", furnace(1.0).solve, "draft", **SMALL)


if __name__ == "__main__":
    unittest.main()
