"""The operator as matrices: the same as the library applies; adjoints, and derivatives against differences."""
import unittest
import warnings

import numpy as np
from scipy import sparse

import resolvent
from fixtures import CUBE, INWARDS, SMALL, UP, floor_points, furnace, solved_lamps
from resolvent import Mesh, PunctualLight, Scene


def random_field(operator, seed=0):
    return np.random.RandomState(seed).uniform(0, 1, (operator.element_count, 3))


class Matrices(unittest.TestCase):
    def check(self, operator):
        field = random_field(operator)
        image = operator.apply(field)
        both = operator.linear_operator()
        np.testing.assert_allclose(both.matvec(field.ravel()).reshape(-1, 3), image, atol=1e-5)
        for c in range(3):
            matrix = operator.matrix(c)
            self.assertTrue(sparse.isspmatrix_csr(matrix))
            np.testing.assert_allclose(matrix @ field[:, c], image[:, c], atol=1e-5)
            one = operator.linear_operator(c)
            other = random_field(operator, 1)[:, c]
            forth, back = other @ one.matvec(field[:, c]), one.rmatvec(other) @ field[:, c]
            self.assertAlmostEqual(forth / back, 1, places=10)
        transposed = operator.apply_transpose(field)
        np.testing.assert_allclose(both.rmatvec(field.ravel()).reshape(-1, 3), transposed, atol=1e-4)

    def test_matrices_are_the_operator(self):
        self.check(solved_lamps().operator)
        operator = solved_lamps().operator
        row_sums = max(operator.matrix(c).sum(axis=1).max() for c in range(3))
        self.assertAlmostEqual(operator.norm(), row_sums, places=4)

    @staticmethod
    def quiet(name):
        """A coarse body's normals are not all what they should be, and the library says so."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", resolvent.ResolventWarning)
            return Scene.builtin(name, body_triangles=2000)

    def test_matrices_are_the_operator_with_glass_and_marble(self):
        for name in ("cornell-glass", "cornell-marble"):
            self.check(self.quiet(name).solve("draft", **SMALL).operator)

    def test_elements(self):
        light = solved_lamps()
        operator = light.operator
        n = operator.element_count
        self.assertEqual(n, light.report.elements)
        self.assertEqual(operator.positions.shape, (n, 3))
        self.assertAlmostEqual(float(operator.areas.sum()), 6, places=4)  # of a cube
        red = operator.materials == 1
        np.testing.assert_allclose(operator.albedo[red], np.tile([0.5, 0.2, 0.1], (red.sum(), 1)), rtol=1e-6)
        self.assertTrue((operator.positions[red, 0] == 0).all())
        points = floor_points(50)
        weights = operator.interpolation(points, UP)
        self.assertEqual(weights.shape, (50, n))
        np.testing.assert_allclose(weights @ operator.positions, points, atol=1e-5)
        self.assertFalse(operator.back_sides.any())


class Solutions(unittest.TestCase):
    def test_the_solution_is_that_of_the_matrices(self):
        light = solved_lamps()
        solution = light.operator.solve(light.source_field)
        np.testing.assert_allclose(solution, light.irradiance_field, atol=1e-3 * solution.max())

    def test_adjoint_solutions_say_the_same(self):
        light = solved_lamps()
        importance = random_field(light.operator)
        forth = (importance * light.operator.solve(light.source_field)).sum()
        back = (light.operator.solve_adjoint(importance) * light.source_field).sum()
        self.assertAlmostEqual(forth / back, 1, places=6)

    def test_gradients_are_differences(self):
        light, points = solved_lamps(), floor_points(7)
        gradient = light.gradient(points, UP)
        mean = light.operator.interpolation(points, UP)

        def reading(changed):
            return (mean @ changed.irradiance_field.astype(float)).mean(axis=0)

        np.testing.assert_allclose(gradient.reading, reading(light), rtol=1e-5)
        total = sum(gradient.lights.values())
        np.testing.assert_allclose(total, gradient.reading, rtol=1e-3)
        for name in ("white", "blue"):  # linear: any step will do
            slope = reading(light.relight({name: 2})) - reading(light)
            np.testing.assert_allclose(gradient.lights[name], slope, rtol=2e-3)
        for name, albedo in (("grey", np.full(3, 0.6)), ("red", np.array([0.5, 0.2, 0.1]))):
            step = 0.02
            more, less = (reading(light.relight(albedo={name: albedo + s})) for s in (step, -step))
            np.testing.assert_allclose(gradient.albedo[name], (more - less) / (2 * step), rtol=3e-3)
        self.assertEqual(gradient.element_albedo.shape, gradient.adjoint.shape)
        weighted = light.gradient(points, UP, np.arange(7))
        self.assertGreater(weighted.reading[0], gradient.reading[0])

    def test_gradients_are_differences_beside_marble(self):
        light = Matrices.quiet("cornell-marble").solve("draft", **SMALL)
        low, high = light.scene.bounds
        points = low + floor_points(3) * (high - low)
        gradient = light.gradient(points, UP)
        mean = light.operator.interpolation(points, UP)
        white = np.array(next(m for m in light.scene.materials if m.name == "white").base_color)
        more, less = ((mean @ light.relight(albedo={"white": white + s}).irradiance_field.astype(float)).mean(axis=0)
                      for s in (0.02, -0.02))
        np.testing.assert_allclose(gradient.albedo["white"], (more - less) / 0.04, rtol=3e-3)

    def test_gradients_of_a_furnace_are_known(self):
        gradient = furnace(0.5).solve("draft", **SMALL).gradient(floor_points(4), UP)
        for values, exact in ((gradient.reading, 2), (gradient.lights["wall"], 2), (gradient.albedo["wall"], 4)):
            np.testing.assert_allclose(values, exact, rtol=1e-4)  # 1 / (1 - albedo), and its derivative

    def test_scenes_without_elements_have_an_empty_operator(self):
        mirror = resolvent.Material(metallic=1, roughness=0)
        lamp = PunctualLight(position=(0.5, 0.5, 0.5))
        light = Scene.from_meshes(Mesh(CUBE, INWARDS, material=mirror), lights=[lamp]).solve("draft", **SMALL)
        self.assertEqual(light.operator.matrix(0).shape, (0, 0))
        self.assertEqual(light.operator.interpolation(floor_points(3), UP).nnz, 0)
        np.testing.assert_array_equal(light.gradient(floor_points(3), UP).reading, 0)
        np.testing.assert_array_equal(light.irradiance(floor_points(3), UP), 0)

    def test_wrong_requests_are_refused(self):
        operator = solved_lamps().operator
        for pattern, call in (("channel: 3", lambda: operator.matrix(3)),
                              ("no factor", lambda: operator.factor("K")),
                              ("field: shape", lambda: operator.apply(np.ones(3))),
                              ("source: shape", lambda: operator.solve(np.ones((3, 3)))),
                              ("weights", lambda: solved_lamps().gradient(floor_points(3), UP, [1, np.nan, 1])),
                              ("", lambda: solved_lamps().gradient(floor_points(3), UP, [1, 1]))):
            with self.assertRaisesRegex(ValueError, pattern):
                call()


if __name__ == "__main__":
    unittest.main()
