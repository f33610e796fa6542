"""Scenes in Python: loaded, built, changed, copied, and refused."""

import copy
import glob
import os
import pickle
import unittest

import darboux
import numpy as np
from module_util import BALL, DATA, PLATE, Folders, data_file


def icosahedron():
    g = (1 + 5**0.5) / 2
    vertices = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    vertices += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4)]
    faces += [(11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8)]
    faces += [(3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    return np.array(vertices), np.array(faces)


class Loading(Folders):
    def test_every_shipped_scene_is_the_same_as_a_dict_and_as_text(self):
        files = sorted(glob.glob(os.path.join(DATA, "*.yaml")))
        self.assertGreater(len(files), 30)
        for file in files:
            with self.subTest(os.path.basename(file)):
                scene = darboux.Scene.load(file)
                again = darboux.Scene.from_yaml(scene.to_yaml(), folder=scene.folder)
                self.assertEqual(dict(again), dict(scene))
                self.assertEqual(dict(darboux.Scene.from_dict(scene, DATA)), dict(scene))

    def test_a_dict_solves_to_the_bits_of_the_file(self):
        for name in ("cylinder_harmonic", "cantilever_shear", "simply_supported_plate"):
            with self.subTest(name):
                scene = darboux.Scene.load(data_file(name + ".yaml"))
                built = darboux.Scene({key: scene[key] for key in scene})
                a, b = scene.solve(threads=1), built.solve(threads=1)
                self.assertTrue(np.array_equal(a.displacement, b.displacement))

    def test_a_saved_scene_reads_back(self):
        vertices, faces = icosahedron()
        scene = darboux.Scene(BALL)
        scene["surface"] = {"kind": "mesh", "vertices": 20 * vertices, "faces": faces, "refine": 1}
        scene["fingers"][0]["shape"] = {"kind": "mesh", "vertices": vertices, "faces": faces}
        written = scene.save(os.path.join(self.folder, "saved.yaml"))
        self.assertEqual(len(written), 3)
        again = darboux.Scene.load(os.path.join(self.folder, "saved.yaml"))
        a, b = scene.solve(threads=1), again.solve(threads=1)
        self.assertTrue(a.converged, a.message)
        self.assertTrue(np.array_equal(a.points, b.points))
        self.assertTrue(np.array_equal(a.displacement, b.displacement))
        with self.assertRaisesRegex(darboux.InputError, "<surface>.*found arrays"):
            scene.to_yaml()

    def test_missing_files_are_bad_input(self):
        with self.assertRaisesRegex(darboux.InputError, "nowhere.yaml:0: scene: found a file that"):
            darboux.Scene.load("nowhere.yaml")


class Building(unittest.TestCase):
    def test_surfaces_of_every_kind(self):
        vertices, faces = icosahedron()
        patch = {"u": [0, 1], "v": [-0.5, 0.5], "divisions": [4, 4]}
        surfaces = [
            {"kind": "plane", **patch},
            {"kind": "cylinder", "radius": 2, **patch},
            {"kind": "sphere", "radius": 2, **patch},
            {"kind": "ellipsoid", "semi_axes": np.array([3.0, 2.0, 1.0]), **patch},
            {"kind": "torus", "radii": (3, 1), **patch},
            {"kind": "monkey_saddle", "scale": np.float64(0.3), **patch},
            {"kind": "expression", "position": ["u", "v", "u*v"], **patch},
            {
                "kind": "implicit",
                "function": "x^2 + y^2 + z^2 - 1",
                "bounds": np.array([[-2, 2]] * 3),
                "edge_length": 0.5,
            },
            {"kind": "icosphere", "radius": 1, "frequency": np.int64(2)},
            {"kind": "mesh", "vertices": vertices, "faces": faces, "fit": "interpolate"},
            {"kind": "mesh", "vertices": vertices.tolist(), "faces": faces.astype(np.uint8)},
        ]
        for surface in surfaces:
            with self.subTest(surface["kind"]):
                scene = darboux.Scene(name="a", surface=surface, shell=PLATE["shell"])
                closed = surface["kind"] in ("implicit", "icosphere", "mesh")
                if closed:
                    scene.add_load(kind="pressure", value=1.0, follower=False)
                else:
                    scene.add_support(on="rim", clamped=True)
                    scene.add_load(kind="normal_traction", value="1 + u")
                result = scene.solve(theory="linear", threads=1)
                self.assertTrue(result.converged, result.message)
                self.assertGreater(np.abs(result.displacement).max(), 0)

    def test_a_ball_in_code_is_the_ball_of_a_dict(self):
        scene = darboux.Scene(name="ball", surface=BALL["surface"], shell=BALL["shell"])
        for z in (31.25, -31.25):
            scene.add_support(on={"near": [0, 0, z], "radius": 0}, fix=["x", "y"])
        for name, way in (("top", -1), ("bottom", 1)):
            scene.add_finger(
                name, {"kind": "sphere", "radius": 10}, [0, 0, -60 * way], [0, 0, way], travel=4.0
            )
        scene.add_probe("pole", nearest=[0, 0, 31.25])
        self.assertEqual(dict(scene), BALL)
        self.assertEqual(darboux.Scene(BALL), scene)

    def test_changes_of_a_copy_stay_in_the_copy(self):
        scene = darboux.Scene(PLATE)
        for make in (darboux.Scene.copy, copy.copy, copy.deepcopy):
            other = make(scene)
            other["shell"]["thickness"] = 0.02
            other["loads"].append({"kind": "gravity", "acceleration": [0, 0, -1]})
            self.assertEqual(dict(scene), PLATE)
        self.assertEqual(PLATE["shell"]["thickness"], 0.01)

    def test_a_pickled_scene_solves_to_the_same_bits(self):
        scene = darboux.Scene(PLATE)
        before = scene.solve(threads=1)
        after = pickle.loads(pickle.dumps(scene)).solve(threads=1)
        self.assertTrue(np.array_equal(before.displacement, after.displacement))

    def test_changes_count(self):
        scene = darboux.Scene(PLATE)
        before = scene.solve(threads=1).probes["centre"]["displacement"][2]
        scene["loads"][0]["value"] *= 2
        after = scene.solve(threads=1).probes["centre"]["displacement"][2]
        self.assertAlmostEqual(after / before, 2.0, delta=1e-9)

    def test_arrays_that_change_in_place_count(self):
        vertices, faces = icosahedron()
        scene = darboux.Scene(name="a", surface={"kind": "mesh"}, shell=PLATE["shell"])
        scene["surface"].update(vertices=vertices, faces=faces)
        scene.add_load(kind="pressure", value=1.0, follower=False)
        before = scene.solve(theory="linear", threads=1)
        vertices *= 2
        after = scene.solve(theory="linear", threads=1)
        self.assertTrue(np.allclose(after.points, 2 * before.points, rtol=1e-14))

    def test_repair_mends_and_says_what(self):
        surface = {"kind": "mesh", "file": "broken_meshes/seam.obj"}
        scene = darboux.Scene(name="a", surface=surface, shell=PLATE["shell"], folder=DATA)
        with self.assertRaisesRegex(darboux.InputError, "surface.file: .*repair=True mends"):
            scene.check()
        scene.repair = True
        self.assertRegex(" ".join(scene.mended), "mended .*seam.obj")


class BadInput(unittest.TestCase):
    def check(self, scene, *words):
        with self.assertRaises(darboux.InputError) as caught:
            darboux.Scene(scene).check()
        message = str(caught.exception)
        self.assertIsInstance(caught.exception, ValueError)
        self.assertNotIn("\n", message)
        for word in words:
            self.assertIn(word, message)

    def test_messages_name_key_found_and_allowed(self):
        vertices, faces = icosahedron()
        mesh = {"kind": "mesh", "vertices": vertices, "faces": faces}
        bad_vertices, bad_faces, twice = vertices.copy(), faces.copy(), faces.copy()
        bad_vertices[3, 1] = np.nan
        bad_faces[2, 0] = 12
        twice[1] = twice[0]
        cases = [
            (("shell", "poisson_ratio"), 0.7, "shell.poisson_ratio: found 0.7; allowed"),
            (("shell", "poisson_ratio"), "0.3x", "shell.poisson_ratio: found"),
            (("shell", "thicknes"), 1, "shell.thicknes: found an unknown key", "'thickness'?"),
            (("shell", "thickness"), np.inf, "shell.thickness: found .inf"),
            (("shell", "thickness"), float("nan"), "shell.thickness: found .nan"),
            (("shell", "thickness"), True, "shell.thickness: found 'true'"),
            (("shell", "thickness"), None, "shell.thickness: found nothing"),
            (("shell", "thickness"), 1j, "shell.thickness: found an object of type complex"),
            (("shell", 3), 1, "shell: found the key 3"),
            (("surface",), np.eye(2), "surface: found a list of 2"),
            (("surface", "kind"), "plan", "surface.kind: found 'plan'", "'plane'?"),
            (("loads", 0, "value"), [1, 2], "loads[0].value: found a list of 2"),
            (("loads",), {"kind": "pressure"}, "loads: found a map"),
            (("loads",), [1], "loads[0]: found 1"),
            (("steps",), 1.5, "steps: found 1.5"),
            (("surface",), {**mesh, "vertices": bad_vertices}, "surface.file: found <surface>"),
            (("surface",), {**mesh, "faces": bad_faces}, "<surface>.faces: found 12 in row 2"),
            (("surface",), {**mesh, "faces": twice}, "surface.file: found <surface>", "repair=T"),
            (("surface",), {**mesh, "faces": faces * 1.0}, "<surface>.faces: ", "of integers"),
            (("surface",), {**mesh, "faces": faces[:, :2]}, "<surface>.faces: ", "shape (20, 2)"),
            (("surface",), {**mesh, "vertices": "duck"}, "<surface>.vertices: found"),
            (("surface",), {**mesh, "file": "a.obj"}, "surface: found file beside"),
            (("surface",), {"kind": "mesh", "vertices": vertices}, "surface.faces: found no such"),
        ]
        for keys, value, *words in cases:
            with self.subTest(words[0]):
                scene = copy.deepcopy(PLATE)
                part = scene
                for key in keys[:-1]:
                    part = part[key]
                part[keys[-1]] = value
                self.check(scene, *words)
        self.check({}, "name: found no such key")

    def test_lines_are_told_as_long_as_they_are_those_of_a_text(self):
        text = darboux.Scene(PLATE).to_yaml()
        with self.assertRaisesRegex(darboux.InputError, r"^<yaml>:3: shell.thickness: found -1"):
            darboux.Scene.from_yaml(text.replace("thickness: 0.01", "thickness: -1"))
        scene = darboux.Scene.from_yaml(text)
        scene["supports"] = []
        with self.assertRaisesRegex(darboux.InputError, r"^(?!<).*rigid|^(?!<).*motion"):
            scene.solve()

    def test_options_are_checked_like_flags(self):
        scene = darboux.Scene(PLATE)
        cases = [
            ({"threads": -1}, "threads: found -1; allowed an integer in"),
            ({"threads": 1.5}, "threads: found 1.5"),
            ({"threads": True}, "threads: found True"),
            ({"time_limit": -1}, "time_limit: found -1"),
            ({"time_limit": "1"}, "time_limit: found"),
            ({"max_iterations": 0}, "max_iterations: found 0"),
            ({"gradient_tolerance": 1.0}, "gradient_tolerance: found 1.0"),
            ({"sparse_backend": "pardiso"}, "sparse_backend: found"),
            ({"theory": "lineer"}, "theory: found 'lineer'; .*'linear'"),
            ({"strains": 3}, "strains: found 3"),
            ({"minimizer": "newton"}, "minimizer: found 'newton'"),
            ({"quadrature": 4}, "quadrature: found 4"),
            ({"divisions": (0, 4)}, "divisions: found"),
            ({"divisions": (4, 4, 4)}, "divisions: found"),
        ]
        for options, message in cases:
            with self.subTest(message):
                with self.assertRaisesRegex(darboux.InputError, "^" + message):
                    scene.solve(**options)


if __name__ == "__main__":
    unittest.main()
