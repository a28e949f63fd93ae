"""Solved light against exact answers, against itself, and wrong requests."""
import copy
import gc
import os
import pickle
import tempfile
import unittest
import warnings
import weakref

import numpy as np

import resolvent
from fixtures import SMALL, UP, floor_points, furnace, lamps, solved_lamps
from resolvent import Camera, Light, Scene


class Readings(unittest.TestCase):
    def test_a_furnace_glows_by_one_over_one_minus_albedo(self):
        light = furnace(0.5).solve("draft", **SMALL)
        for mode in ("lookup", "operator"):
            reading = light.irradiance(floor_points(20), UP, mode, samples=64)
            np.testing.assert_allclose(reading, 2, rtol=4e-3)
        picture = light.render(Camera((0.5, 0.5, 0.5), (0, 0.4, 0)), width=8, samples=1)
        np.testing.assert_allclose(picture, 2 / np.pi, rtol=4e-3)
        self.assertEqual(light.report.stop_reason, "converged")

    def test_modes_agree_with_the_path_tracer(self):
        light, points = solved_lamps(), floor_points(8)
        truth, noise = light.irradiance(points, UP, "reference", samples=4096, return_error=True)
        again = light.scene.reference_irradiance(points, UP, samples=4096)
        np.testing.assert_array_equal(truth, again)
        reading, error = light.irradiance(points, UP, "operator", samples=1024, return_error=True)
        self.assertLess(np.median(abs(reading - truth) / np.hypot(noise, error)), 3)
        np.testing.assert_allclose(reading, truth, rtol=0.1)

    def test_shapes_broadcast(self):
        light = solved_lamps()
        points = floor_points(12)
        flat = light.irradiance(points, UP)
        self.assertEqual(flat.dtype, np.float32)
        np.testing.assert_array_equal(light.irradiance(points.reshape(3, 4, 3), UP), flat.reshape(3, 4, 3))
        np.testing.assert_array_equal(light.irradiance(points[0], UP), flat[0])
        np.testing.assert_array_equal(light.irradiance(points, np.tile(UP, (12, 1))), flat)
        np.testing.assert_array_equal(light.irradiance(np.asfortranarray(points), UP), flat)
        np.testing.assert_array_equal(light.irradiance(points[::-1], UP)[::-1], flat)
        np.testing.assert_array_equal(light.irradiance(points.astype(np.float32)[::2], UP).shape, (6, 3))
        np.testing.assert_array_equal(light.irradiance(points[0], [UP, (0, 3, 0)]), flat[[0, 0]])
        self.assertEqual(light.irradiance(np.zeros((0, 3)), UP).shape, (0, 3))

    def test_far_from_the_origin_coordinates_are_those_of_the_file(self):
        transform = np.eye(4)
        transform[:3, 3] = (2.0**20, 0, 2.0**20)
        scene = lamps()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "near.glb")
            scene.save(path)
            far = self.shifted(path, os.path.join(folder, "far.gltf"), transform[:3, 3])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", resolvent.ResolventWarning)
                light = Scene.load(far).solve("draft", **SMALL)
        self.assertTrue(light.scene.origin.any())
        np.testing.assert_allclose(light.scene.bounds, np.array([[0, 0, 0], [1, 1, 1]]) + transform[:3, 3], atol=1e-4)
        points = floor_points(5)
        here = light.irradiance(points + transform[:3, 3], UP)
        np.testing.assert_allclose(here, solved_lamps().irradiance(points, UP), rtol=0.1)

    @staticmethod
    def shifted(path, output, offset):
        """A glTF file with a node above all that are there."""
        import base64
        import json
        with open(path, "rb") as file:
            raw = file.read()
        length = int.from_bytes(raw[12:16], "little")
        document = json.loads(raw[20:20 + length])
        binary = raw[28 + length:]
        scene = document["scenes"][0]
        document["nodes"].append({"translation": list(map(float, offset)), "children": scene["nodes"]})
        scene["nodes"] = [len(document["nodes"]) - 1]
        uri = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
        document["buffers"][0] = {"byteLength": len(binary), "uri": uri}
        with open(output, "w") as file:
            json.dump(document, file)
        return output


class Pictures(unittest.TestCase):
    def test_layers_add_up(self):
        picture, layers = solved_lamps().render("corner", width=16, height=12, samples=4, layers=True)
        self.assertEqual(picture.shape, (12, 16, 3))
        self.assertEqual(picture.dtype, np.float32)
        self.assertEqual(list(layers)[:3], ["emission", "direct", "bounce1"])
        np.testing.assert_allclose(sum(layers.values()), picture, atol=1e-5 * picture.max())

    def test_pictures_are_as_good_as_was_asked_for(self):
        light = solved_lamps()
        judges = [light.scene.reference(width=24, samples=512, seed=seed) for seed in (1, 2)]

        def error(picture):  # the judges' noise cancels
            truth = np.mean(judges, 0)
            return np.mean((picture - judges[0]) * (picture - judges[1]) / (truth**2 + 0.01 * truth.mean()**2))**0.5

        whole = light.scene.render(width=24, error=0.05)
        self.assertLess(error(whole), 0.0625)
        errors = [error(light.render(width=24, error=wanted)) for wanted in (0.4, 0.05)]
        self.assertLess(errors[1], errors[0])
        np.testing.assert_array_equal(light.render(width=24), light.render(width=24, error=0.07))
        self.assertEqual(light.scene.render(width=8, max_time=0.5, layers=True)[0].shape, (8, 8, 3))
        self.assertLess(error(light.render(width=24, mode="operator", gloss="reused")), 0.4)

    def test_pictures_that_contradict_themselves_are_refused(self):
        light = solved_lamps()
        for options in ({"samples": 4}, {"noise": 0.1}, {"gather_rays": 1}, {"mode": "operator"}):
            with self.assertRaisesRegex(ValueError, "leave out"):
                light.render(width=8, error=0.1, **options)
        for options in ({"error": 0}, {"error": -1}, {"max_time": 0}, {"error": 1e-4}, {"error": np.nan}):
            with self.assertRaises(ValueError):
                light.render(width=8, **options)

    def test_a_camera_of_ones_own_is_that_of_the_scene(self):
        light = solved_lamps()
        expected = light.render(0, width=16, samples=1)
        np.testing.assert_allclose(light.render(light.scene.cameras[0], width=16, samples=1), expected, rtol=1e-4)

    def test_reference_pictures_need_no_solution(self):
        light = solved_lamps()
        options = {"width": 8, "samples": 4, "seed": 3}
        np.testing.assert_array_equal(light.render(mode="reference", **options), light.scene.reference(**options))
        picture, layers = light.scene.reference(width=8, samples=1, layers=True)
        self.assertIn("bounce1", layers)

    def test_results_do_not_depend_on_threads(self):
        pictures = []
        for threads in (1, 3):
            context = resolvent.Context(threads)
            light = Scene.builtin("cornell-blocks", context=context).solve("draft", **SMALL)
            pictures.append(light.render(width=8, samples=1))
        np.testing.assert_array_equal(*pictures)


class OtherLights(unittest.TestCase):
    def test_light_is_linear_in_strengths(self):
        light, points = solved_lamps(), floor_points(6)
        basis = light.basis(points, UP)
        self.assertEqual(set(basis.names), {"white", "blue"})
        np.testing.assert_allclose(basis.irradiance.sum(axis=0), light.irradiance(points, UP), rtol=2e-3)
        factors = {"white": 0.25, "blue": 3.0}
        relit = light.relight(lights=factors).irradiance(points, UP)
        expected = sum(factors[name] * column for name, column in zip(basis.names, basis.irradiance))
        np.testing.assert_allclose(relit, expected, rtol=2e-3)

    def test_relighting_is_solving_anew(self):
        light, points = solved_lamps(), floor_points(6)
        relit = light.relight(lights={"white": (1, 0.5, 0.25)}, albedo={"grey": 0.3}, move={"blue": (0.1, 0, 0.1)})
        truth = relit.scene.reference_irradiance(points, UP, samples=4096)
        np.testing.assert_allclose(relit.irradiance(points, UP, "operator", samples=1024), truth, rtol=0.1)
        self.assertEqual(relit.scene.materials[0].base_color, tuple(np.float32([0.3] * 3)))
        np.testing.assert_allclose(light.scene.materials[0].base_color, 0.6, rtol=1e-6)  # as it was
        again = light.copy()
        np.testing.assert_array_equal(again.irradiance_field, light.irradiance_field)

    def test_surroundings_turn(self):
        sky = np.zeros((16, 32, 3))
        sky[4:8, 8:16] = 1
        scene = Scene.from_meshes(floor_and_wall(), environment=sky)
        light = scene.solve("draft", **SMALL)
        turned = light.relight(env_rotation=180)
        self.assertGreater(abs(turned.irradiance_field - light.irradiance_field).max(), 0.01)
        brighter = light.relight({"environment": 2})
        np.testing.assert_allclose(brighter.irradiance_field, 2 * light.irradiance_field, rtol=2e-3, atol=1e-5)

    def test_sources(self):
        sources = {source.name: source for source in solved_lamps().sources}
        np.testing.assert_allclose(sources["blue"].strength, (0.1, 0.2, 1), rtol=1e-6)
        np.testing.assert_allclose(sources["blue"].position, (0.2, 0.4, 0.3), rtol=1e-6)
        self.assertTrue(sources["white"].movable)


def floor_and_wall():
    corners = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0], [0, 1, 0], [0, 1, 1]], float)
    triangles = [[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 1]]
    return resolvent.Mesh(corners, triangles, material=resolvent.Material.lambert(0.5))


class Files(unittest.TestCase):
    def test_what_was_saved_comes_back(self):
        light, points = solved_lamps(), floor_points(5)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "lamps.safetensors")
            light.save(path, "lamps")
            again = Light.load(path)
            with self.assertRaises(resolvent.FileError):
                light.save(os.path.join(folder, "nowhere", "a.safetensors"))
            bake = again.bake(os.path.join(folder, "lamps.glb"), tolerance=0.2)
            self.assertGreaterEqual(bake.triangles, 12)
            self.assertEqual(len(Scene.load(os.path.join(folder, "lamps.glb")).cameras), 1)
        np.testing.assert_array_equal(again.irradiance(points, UP), light.irradiance(points, UP))
        np.testing.assert_array_equal(again.irradiance_field, light.irradiance_field)

    def test_parts_outlive_what_they_were_made_of(self):
        def scene_of_light():
            return lamps().solve("draft", **SMALL).scene

        scene = scene_of_light()
        gc.collect()
        self.assertEqual(len(scene.triangles), 12)
        operator = lamps().solve("draft", **SMALL).operator
        gc.collect()
        self.assertGreater(operator.norm(), 0.3)
        shallow = copy.copy(operator)
        del operator
        gc.collect()
        self.assertGreater(shallow.norm(), 0.3)
        context = resolvent.Context()
        gone = weakref.ref(context)
        del context
        self.assertIsNone(gone())
        cycle = [lamps()]
        cycle.append(cycle)
        del cycle
        gc.collect()


class Certificates(unittest.TestCase):
    def test_the_error_is_small_and_known(self):
        light = solved_lamps()
        certificate = light.certify(samples=256, gather_rays=64, light_samples=16)
        self.assertLess(certificate.relative_error, 0.3)
        low, high = certificate.error_estimate_ci95
        self.assertTrue(0 <= low <= certificate.error_estimate_rms <= high)
        goal = light.certify_goal((floor_points(4), UP), samples=256, gather_rays=64)
        self.assertLess(abs(goal.error), goal.reading)
        self.assertGreater(light.certify_goal("corner", samples=256, gather_rays=64).reading, 0)

    def test_solves_refine_to_an_error(self):
        light = furnace(0.5).solve("draft", error=0.05, max_rounds=2, **SMALL)
        self.assertEqual(light.error_stop, "target reached")
        self.assertLess(light.certificate.relative_error, 0.05)

    def test_goals(self):
        light = lamps().solve("draft", goal=(floor_points(3), UP), **SMALL)
        self.assertGreater(light.report.elements, 10)
        self.assertGreater(lamps().solve("draft", goal="corner", **SMALL).report.elements, 10)


class Mistakes(unittest.TestCase):
    def refuses(self, kind, pattern, call, *arguments, **options):
        with self.assertRaisesRegex(kind, pattern):
            call(*arguments, **options)

    def test_points(self):
        read = solved_lamps().irradiance
        nan = floor_points(4)
        nan[2, 0] = np.nan
        self.refuses(ValueError, r"points\[2, 0\] is nan", read, nan, UP)
        self.refuses(ValueError, r"normals\[0, 1\] is inf", read, floor_points(4), (0, np.inf, 0))
        self.refuses(ValueError, "normals: number 1 is zero", read, floor_points(2), [UP, (0, 0, 0)])
        self.refuses(ValueError, r"points: shape \(4, 2\); expected \(..., 3\)", read, np.ones((4, 2)), UP)
        self.refuses(ValueError, "go together", read, np.ones((4, 3)), np.ones((3, 3)))
        self.refuses(ValueError, r"\(0, 3\) where there are none", read, [], UP)
        self.refuses(TypeError, "points: dtype complex128", read, np.ones((4, 3), complex), UP)
        self.refuses(TypeError, "points: dtype object", read, np.array([[None] * 3]), UP)
        self.refuses(TypeError, "normals: None", read, np.ones(3), None)
        self.refuses(ValueError, r"points\[0, 0\] is inf", read, [[1e300, 0, 0]], UP)
        self.refuses(ValueError, "mode: there is no 'look'; there are lookup", read, np.ones(3), UP, "look")
        self.refuses(ValueError, "samples: 0", read, np.ones(3), UP, samples=0)
        self.refuses(TypeError, "samples", read, np.ones(3), UP, samples=1.5)
        self.refuses(TypeError, "seed", read, np.ones(3), UP, seed=True)

    def test_pictures(self):
        render = solved_lamps().render
        self.refuses(ValueError, "camera: there is no 'nobody'; there are corner", render, "nobody")
        self.refuses(ValueError, "camera: 1", render, 1)
        self.refuses(TypeError, "camera", render, 0.5)
        self.refuses(ValueError, "width: 0", render, width=0)
        self.refuses(ValueError, "height: 40000", render, height=40000)
        self.refuses(ValueError, "mode", render, mode="fast")
        self.refuses(ValueError, "samples", render, samples=0)

    def test_changes(self):
        relight = solved_lamps().relight
        self.refuses(resolvent.ArgumentError, "white", relight, {"wihte": 2})
        self.refuses(ValueError, r"lights\['white'\]", relight, {"white": (1, 2)})
        self.refuses(ValueError, r"lights\['white'\]", relight, {"white": np.nan})
        self.refuses(TypeError, "lights", relight, ["white"])
        self.refuses(TypeError, "lights", relight, {3: 1})
        self.refuses(resolvent.ArgumentError, "", relight, {"white": -1})
        self.refuses(resolvent.ArgumentError, "", relight, env_rotation=90)
        self.refuses(ValueError, "move", relight, move={"white": (1, 2)})
        self.refuses(TypeError, "made by Scene.solve", Light)
        self.refuses(TypeError, "made by Scene.load", Scene)
        self.refuses(TypeError, "pickled", pickle.dumps, solved_lamps())
        self.refuses(TypeError, "no option 'size'", solved_lamps().bake, "a.glb", size=3)
        self.refuses(ValueError, "there are .*vertex", solved_lamps().bake, "a.glb", "vertices")


if __name__ == "__main__":
    unittest.main()
