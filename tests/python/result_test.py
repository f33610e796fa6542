"""Results in Python: the tool's numbers to the bit, shapes, ownership, units."""

import gc
import json
import os
import unittest

import darboux
import numpy as np
from module_util import BALL, PLATE, Folders, data_file, read_json, read_vtu, without_times

FIELDS = {
    "displacement": 3,
    "normal": 3,
    "membrane_strain": 3,
    "principal_membrane_strain": 2,
    "bending_strain": 3,
    "membrane_force": 3,
    "moment": 3,
    "von_mises_top": 1,
    "von_mises_bottom": 1,
    "energy_density": 1,
    "membrane_energy_density": 1,
    "bending_energy_density": 1,
}
REST = {"points": 3, "uv": 2, "principal_curvatures": 2, "principal_direction_1": 3}


class TheTool(Folders):
    def check_same_as_tool(self, scene, file, *flags, status=0, **options):
        out = self.run_tool("darboux_deform", file, "--threads=1", *flags, status=status)
        result = scene.solve(threads=1, **options)
        mine = os.path.join(self.folder, "mine")
        names = result.write(mine)
        self.assertEqual(sorted(names), sorted(os.listdir(out)))
        self.assert_same_files(out, mine, but=["summary.json"])
        summary = read_json(out, "summary.json")
        self.assertEqual(without_times(read_json(mine, "summary.json")), without_times(summary))
        self.assertEqual(without_times(result.summary), without_times(summary))
        self.assertEqual(list(result.summary), list(summary))
        # Arrays are those of the file for ParaView.
        for step in range(result.num_steps):
            vtu = read_vtu(os.path.join(out, f"shell_{step + 1:04d}.vtu"))
            fields = result.fields(step)
            for name in FIELDS:
                self.assertTrue(np.array_equal(fields[name], vtu[name]), name)
        for name in REST:
            name_there = "Points" if name == "points" else name
            self.assertTrue(np.array_equal(getattr(result, name), vtu[name_there]), name)
        self.assertTrue(np.array_equal(result.triangles.ravel(), vtu["connectivity"]))
        return result

    def test_linear(self):
        file = data_file("pinched_cylinder.yaml")
        result = self.check_same_as_tool(darboux.Scene.load(file), file)
        self.assertTrue(result.expectations_hold)

    def test_load_steps_along_a_path_with_another_lattice(self):
        file = data_file("cantilever_shear.yaml")
        scene = darboux.Scene.load(file)
        flags = ["--divisions=12,2", "--quadrature=6"]
        # The scene's expectations are for its own lattice.
        result = self.check_same_as_tool(
            scene, file, *flags, status=1, divisions=(12, 2), quadrature=6
        )
        self.assertTrue(result.converged)
        self.assertFalse(result.expectations_hold)

    def test_fingers_and_steps_from_a_dict(self):
        scene = darboux.Scene(BALL, steps=2)
        scene.save(os.path.join(self.folder, "ball.yaml"))
        result = self.check_same_as_tool(scene, os.path.join(self.folder, "ball.yaml"))
        self.assertEqual(result.num_steps, 2)
        history = result.history
        self.assertEqual(history["fingers.top.normal_force"].shape, (2,))
        last = result.step(-1)
        self.assertEqual(last["factor"], history["factor"][1])
        for step in range(2):
            force = result.step(step)["fingers"]["top"]["normal_force"]
            self.assertEqual(force, history["fingers.top.normal_force"][step])
            moved = result.step(step)["probes"]["pole"]["displacement"]
            self.assertEqual(moved[2], history["probes.pole.displacement.z"][step])
        top = result.fingers["top"]
        self.assertEqual(last["fingers"]["top"]["normal_force"], top["normal_force"])
        contact = result.contact()
        top = contact["finger"] == 0
        force = (contact["pressure"] * contact["area"])[top].sum()
        self.assertAlmostEqual(force / result.fingers["top"]["normal_force"], 1.0, delta=1e-6)
        self.assertEqual(result.grasp["stiffness"].shape, (2, 2))
        self.assertEqual(result.grasp["center"].shape, (3,))

    def test_accuracy(self):
        file = os.path.join(self.folder, "plate.yaml")
        scene = darboux.Scene(PLATE, model={"accuracy": 0.001})
        scene.save(file)
        levels = []
        result = self.check_same_as_tool(
            scene, file, progress=lambda p: levels.append(p) if p.kind == "level" else None
        )
        self.assertTrue(result.summary["accuracy"]["reached"])
        reported = result.summary["accuracy"]["levels"]
        self.assertEqual([level.dof for level in levels], [level["dof"] for level in reported])


class Arrays(Folders):
    @classmethod
    def setUpClass(cls):
        cls.result = darboux.Scene(PLATE).solve(threads=1)

    def test_shapes_and_types(self):
        n = len(self.result.points)
        for name, columns in {**FIELDS, **REST}.items():
            with self.subTest(name):
                array = getattr(self.result, name)
                self.assertEqual(array.dtype, np.float64)
                self.assertEqual(array.shape, (n,) if columns == 1 else (n, columns))
                self.assertTrue(array.flags.c_contiguous)
                self.assertFalse(array.flags.writeable)
                self.assertTrue(np.isfinite(array).all())
        self.assertEqual(self.result.triangles.dtype, np.int32)
        self.assertEqual(self.result.triangles.shape[1], 3)
        self.assertEqual(self.result.triangles.max(), n - 1)
        self.assertEqual(self.result.control_displacements().shape[1], 3)
        self.assertEqual(set(self.result.fields()), set(FIELDS))
        iterations = self.result.iterations
        self.assertEqual(iterations["energy"].shape, (len(iterations["method"]),))
        self.assertEqual(len(iterations["method"]), self.result.summary["iterations"])
        self.assertEqual(iterations["step"].dtype, np.int32)

    def test_arrays_outlive_the_result(self):
        result = darboux.Scene(PLATE).solve(threads=1)
        fields, points = result.fields(), result.points
        kept = {name: values.copy() for name, values in fields.items()}
        rest = points.copy()
        for values in fields.values():
            self.assertTrue(values.flags.owndata and values.flags.writeable)
        del result
        gc.collect()
        np.random.default_rng(1).random(1000000)  # Somebody else's memory.
        for name, values in fields.items():
            self.assertTrue(np.array_equal(values, kept[name]), name)
        self.assertTrue(np.array_equal(points, rest))
        fields["displacement"][:] = 0

    def test_changing_what_was_given_out_changes_nothing(self):
        self.result.fields()["displacement"][:] = 7
        self.assertLess(np.abs(self.result.fields()["displacement"]).max(), 1)

    def test_fields_anywhere(self):
        at = self.result.at(uv=[[0.5, 0.5], [0.25, 0.7]])
        probe = self.result.probes["centre"]
        self.assertTrue(np.array_equal(at["displacement"][0], probe["displacement"]))
        self.assertTrue(np.array_equal(at["position"][0], probe["position"]))
        self.assertEqual(at["moment"].shape, (2, 3))
        self.assertTrue(np.allclose(at["uv"], [[0.5, 0.5], [0.25, 0.7]], atol=1e-14))
        nearest = self.result.at(nearest=[0.25, 0.7, 3.0])
        self.assertTrue(np.allclose(nearest["position"], [0.25, 0.7, 0], atol=1e-12))
        self.assertTrue(np.allclose(nearest["displacement"], at["displacement"][1], rtol=1e-9))
        # At the points where they are sampled they are what was sampled.
        every = self.result.at(uv=self.result.uv)
        for name in ("displacement", "membrane_force", "moment"):
            scale = np.abs(getattr(self.result, name)).max()
            self.assertTrue(
                np.allclose(every[name], getattr(self.result, name), atol=1e-9 * scale), name
            )

    def test_bad_points_and_steps(self):
        cases = [
            ({"uv": [[2.0, 0.5]]}, darboux.InputError, "u: found 2"),
            ({"uv": [[0.5, np.nan]]}, darboux.InputError, "uv: found nan in row 0"),
            ({"uv": [[0.5]]}, darboux.InputError, r"uv: found .*shape \(1, 1\)"),
            ({}, darboux.InputError, "neither uv nor nearest"),
            ({"uv": [0, 0], "nearest": [0, 0, 0]}, darboux.InputError, "uv and nearest"),
            ({"uv": [0, 0], "step": 1}, IndexError, "step: found 1; allowed -1 to 0"),
        ]
        for arguments, kind, message in cases:
            with self.subTest(message):
                with self.assertRaisesRegex(kind, message):
                    self.result.at(**arguments)
        with self.assertRaises(IndexError):
            self.result.fields(-2)

    def test_a_report_is_that_of_the_tool_or_says_what_is_missing(self):
        folder = os.path.join(self.folder, "out")
        try:
            names = self.result.write(folder, report=True)
        except darboux.InputError as error:
            self.assertIn("report: found a build without", str(error))
            self.assertFalse(os.path.exists(folder))
            return
        self.assertIn("report.html", names)
        with open(os.path.join(folder, "report.html"), encoding="utf-8") as stream:
            self.assertIn("<title>", stream.read())

    def test_files_that_cannot_be_written(self):
        file = os.path.join(self.folder, "file")
        with open(file, "w", encoding="utf-8"):
            pass
        with self.assertRaises(OSError):
            self.result.write(file)
        self.assertIn("plate", json.dumps(self.result.summary))


class Solving(unittest.TestCase):
    def test_results_do_not_depend_on_the_unit_of_length(self):
        def ball(unit):  # A millimetre is so many units; forces in N.
            scene = darboux.Scene(BALL, model={"theory": "nonlinear"})
            scene["surface"]["radius"] *= unit
            scene["shell"]["thickness"] *= unit
            scene["shell"]["young_modulus"] /= unit**2
            for support in scene["supports"]:
                support["on"]["near"] = np.array(support["on"]["near"]) * unit
            for finger in scene["fingers"]:
                finger["shape"]["radius"] *= unit
                finger["position"] = np.array(finger["position"]) * unit
                finger["motion"]["travel"] *= unit
            scene["probes"][0]["at"]["nearest"] = np.array([0, 0, 31.25]) * unit
            return scene.solve(threads=1)

        reference = ball(1.0)
        self.assertTrue(reference.converged)
        # Powers of two change no bit. Otherwise the state is as near as the solver goes: a gradient
        # of 1e-7 of the forces, in the softest directions.
        exact = ball(1 / 1024)
        self.assertTrue(np.array_equal(exact.displacement * 1024, reference.displacement))
        largest = np.abs(reference.displacement).max()
        for unit in (1e-3, 25.4):
            other = ball(unit)
            self.assertLess(
                np.abs(other.displacement / unit - reference.displacement).max(), 1e-7 * largest
            )
            self.assertAlmostEqual(
                other.fingers["top"]["normal_force"] / reference.fingers["top"]["normal_force"],
                1.0,
                delta=1e-9,
            )

    def test_a_result_that_has_not_converged_says_so(self):
        scene = darboux.Scene(PLATE, model={"theory": "nonlinear", "minimizer": "mip"})
        scene["loads"][0]["value"] = 1e18  # No plate bears that.
        result = scene.solve(threads=1, max_iterations=5)
        self.assertFalse(result.converged)
        self.assertNotEqual(result.message, "")
        self.assertIn(result.termination, ("not_converged", "failed"))
        with self.assertRaises(darboux.NotConverged) as caught:
            scene.solve(threads=1, max_iterations=5, check=True)
        self.assertFalse(caught.exception.result.converged)
        self.assertEqual(str(caught.exception), caught.exception.result.message)

    def test_a_time_limit_holds(self):
        result = darboux.Scene(BALL).solve(threads=1, time_limit=1e-6)
        self.assertFalse(result.converged)
        self.assertEqual(result.termination, "time_limit")
        self.assertTrue(np.isfinite(result.points).all())

    def test_starting_from_another_result_saves_iterations_and_ends_in_the_same_state(self):
        scene = darboux.Scene(BALL)
        first = scene.solve(threads=1)
        for finger in scene["fingers"]:
            finger["motion"]["travel"] = 4.5
        anew, on = scene.solve(threads=1), scene.solve(threads=1, start=first)
        self.assertTrue(anew.converged and on.converged)
        self.assertLess(on.summary["iterations"], anew.summary["iterations"])
        for quantity in ("normal_force", "indentation", "stiffness"):
            a, b = anew.fingers["top"][quantity], on.fingers["top"][quantity]
            self.assertAlmostEqual(b / a, 1.0, delta=1e-6)
        with self.assertRaisesRegex(darboux.InputError, "start: found a result on another mesh"):
            darboux.Scene(PLATE, model={"theory": "nonlinear"}).solve(start=first)


if __name__ == "__main__":
    unittest.main()
