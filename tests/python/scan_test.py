"""Scans, fits, calibrations and studies in Python: those of the tools."""

import os
import unittest

import darboux
import numpy as np
from module_util import BALL, PLATE, Folders, data_file, read_json, without_times


class Scans(Folders):
    @classmethod
    def setUpClass(cls):
        cls.scene = darboux.Scene(BALL)
        cls.result = cls.scene.solve(threads=1)

    def test_a_scan_is_that_of_darboux_scan(self):
        file = os.path.join(self.folder, "ball.yaml")
        self.scene.save(file)
        flags = ["--points=500", "--noise=0.1", "--outliers=0.02", "--seed=7", "--views=6"]
        out = self.run_tool("darboux_scan", file, "--threads=1", *flags)
        scan = self.result.scan(500, noise=0.1, outliers=0.02, seed=7, views=6)
        there = darboux.read_points(os.path.join(out, "scan.csv"))
        self.assertTrue(np.array_equal(scan.points, there["points"]))
        truth = read_json(out, "truth.json")["model_from_scan"]
        self.assertTrue(np.array_equal(scan.pose[:3, :3], np.array(truth["rotation"])))
        self.assertTrue(np.array_equal(scan.pose[:3, 3], np.array(truth["translation"])))
        self.assertEqual((scan.outlier > 0).sum(), 10)
        # Without errors the points are those of the face, in another frame.
        good = scan.outlier == 0
        moved = scan.points @ scan.pose[:3, :3].T + scan.pose[:3, 3]
        off = np.linalg.norm(moved - scan.true_points, axis=1)
        self.assertTrue(np.allclose(off[good], np.abs(scan.noise[good]), atol=1e-9))

    def test_a_scan_reads_back_to_the_bit(self):
        scan = self.result.scan(200, noise=0.1)
        for name in ("scan.csv", "scan.ply"):
            file = os.path.join(self.folder, name)
            scan.save(file, normals=True)
            back = darboux.read_points(file)
            self.assertTrue(np.array_equal(back["points"], scan.points))
            self.assertTrue(np.allclose(back["normals"], scan.normals, atol=1e-14))
            self.assertIsNone(back["displacements"])

    def test_registering_a_scan_finds_its_pose(self):
        scene = darboux.Scene.load(data_file("ellipsoid_poke.yaml"))
        scene["fingers"] = []
        scene["loads"] = [{"kind": "pressure", "value": 0.01, "follower": False}]
        del scene["expect"]
        result = scene.solve(theory="linear", threads=1)
        scan = result.scan(1500, noise=0.05, seed=3)
        fit = scene.register(scan, theory="linear", threads=1)
        self.assertTrue(fit.converged, fit.verdict)
        # An ellipsoid may be upside down: where it is, is what counts.
        moved = scan.points @ fit.pose[:3, :3].T + fit.pose[:3, 3]
        self.assertLess(np.abs(np.linalg.norm(moved - fit.feet, axis=1)).max(), 0.3)
        self.assertAlmostEqual(fit.distances.std() / 0.05, 1.0, delta=0.25)
        self.assertTrue(np.allclose(fit.feet.mean(axis=0), moved.mean(axis=0), atol=0.01))
        self.assertEqual(fit.inliers.dtype, np.bool_)
        self.assertTrue(np.allclose(fit.displacement, result.displacement))

    def test_a_fit_is_that_of_darboux_fit(self):
        # The fingers are not known to it; their dents are.
        file, points = (os.path.join(self.folder, name) for name in ("ball.yaml", "scan.csv"))
        self.scene.save(file)
        scan = self.result.scan(500, noise=0.05, seed=5)
        scan.save(points)
        flags = [f"--scan={points}", "--fingers=none", "--noise=0.05", "--threads=1"]
        out = self.run_tool("darboux_fit", file, *flags)
        mine = os.path.join(self.folder, "mine")
        reports = []
        fits = [
            self.scene.fit(
                what, fingers="none", noise=0.05, threads=1, progress=reports.append
            )
            for what in (scan.points, points)
        ]
        ends = [p.weight for p in reports if p.kind == "weight"]
        self.assertEqual(ends, 2 * [trial["weight"] for trial in fits[1].summary["weights"]])
        fits[1].write(mine)
        self.assert_same_files(out, mine, but=["fit.json"])
        self.assertEqual(
            without_times(fits[1].summary), without_times(read_json(out, "fit.json"))
        )
        for fit in fits:
            self.assertTrue(fit.converged, fit.verdict)
            self.assertTrue(np.array_equal(fit.displacement, fits[1].displacement))
            self.assertTrue(np.array_equal(fit.distances, fits[1].distances))
        # 0.05 of noise, and the dents of 4 mm are there as far as the fingers let them be seen.
        self.assertLess(fits[0].summary["inliers"]["rms"], 0.06)
        dent = np.abs(self.result.displacement).max()
        self.assertGreater(np.abs(fits[0].displacement).max(), 0.5 * dent)

    def test_what_does_not_match_says_so(self):
        nowhere = np.random.default_rng(1).uniform(-100, 100, (300, 3))
        fit = self.scene.register(nowhere, against="rest", threads=1)
        self.assertFalse(fit.converged)
        self.assertIn("converged", fit.summary)
        self.assertNotEqual(fit.verdict, "")
        with self.assertRaises(darboux.NotConverged):
            self.scene.register(nowhere, against="rest", threads=1, check=True)

    def test_bad_input(self):
        points = np.zeros((10, 3))
        cases = [
            (lambda: self.scene.fit(points[:, :2]), r"scan: found an array of shape \(10, 2\)"),
            (lambda: self.scene.fit(points / 0.0), "scan: found nan in row 0"),
            (lambda: self.scene.fit("nowhere.csv"), "nowhere.csv:0: found"),
            (lambda: self.scene.fit(points, face="upper"), "face: found 'upper'; allowed outer"),
            (lambda: self.scene.fit(points, noise=-1.0), "noise: found -1"),
            (lambda: self.scene.register(points, method="icp"), "method: found 'icp'"),
            (lambda: self.result.scan(0), "num_points: found 0"),
            (lambda: self.result.scan(10, sampling="some"), "sampling: found 'some'"),
            (lambda: self.result.scan(10, views=-1), "views: found -1"),
        ]
        for call, message in cases:
            with self.subTest(message):
                with np.errstate(invalid="ignore"), self.assertRaisesRegex(
                    darboux.InputError, message
                ):
                    call()


class Calibrations(Folders):
    def test_a_file_gives_the_numbers_of_darboux_calibrate(self):
        file = data_file("calibration/strip_hole_calibration.yaml")
        out = self.run_tool("darboux_calibrate", file, "--threads=1")
        reports = []
        calibration = darboux.calibrate(file, threads=1, progress=reports.append, check=True)
        self.assertEqual(
            without_times(calibration.summary), without_times(read_json(out, "calibration.json"))
        )
        mine = os.path.join(self.folder, "mine")
        calibration.write(mine)
        self.assertEqual(sorted(os.listdir(out)), sorted(os.listdir(mine)))
        modulus = calibration.parameters["young_modulus"]
        low, high = modulus["interval_95"]
        self.assertTrue(low < 210000 < high)
        iterations = [p for p in reports if p.kind == "calibration_iteration"]
        self.assertEqual(len(iterations), calibration.summary["iterations"])
        self.assertIn("young_modulus", iterations[-1].parameters)
        self.assertTrue(all(isinstance(p.text, str) for p in reports if p.kind == "line"))
        # The state of each grasp is a result like any other.
        (state,) = calibration.states
        del calibration
        self.assertTrue(np.isfinite(state.displacement).all())

        # The same in code.
        field = darboux.read_points(data_file("calibration/strip_hole_noisy.csv"))
        scene = darboux.Scene.load(data_file("calibration/strip_hole.yaml"))
        moved = field["displacements"]
        in_code = {
            "name": "strip",
            "parameters": {"young_modulus": {"start": 1e5}, "poisson_ratio": {"start": 0.1}},
            "grasps": [
                {
                    "scene": scene,
                    "fields": [
                        {
                            "points": field["points"],
                            "displacements": moved,
                            "components": ["x", "y"] if np.all(moved[:, 2] == 0) else list("xyz"),
                        }
                    ],
                }
            ],
        }
        again = darboux.calibrate(in_code, threads=1)
        self.assertEqual(again.parameters["young_modulus"]["value"], modulus["value"])

    def test_youngs_modulus_from_a_scan_and_a_force_in_code(self):
        truth = darboux.Scene(BALL).solve(threads=1)
        scan = truth.scan(600, noise=0.05, seed=2)
        force = truth.fingers["top"]["normal_force"]
        guess = darboux.Scene(BALL)
        guess["shell"]["young_modulus"] = 3.0
        calibration = darboux.calibrate(
            {
                "name": "ball",
                "parameters": {"young_modulus": {}},
                "noise": 0.05,
                "compare_linear": False,
                "grasps": [
                    {
                        "scene": guess,
                        "scans": [scan],
                        "forces": [{"finger": "top", "value": force, "error": 0.01 * force}],
                    }
                ],
            },
            threads=1,
        )
        self.assertTrue(calibration.converged and calibration.identifiable, calibration.message)
        self.assertAlmostEqual(calibration.parameters["young_modulus"]["value"], 1.0, delta=0.01)

    def test_bad_input(self):
        scene = darboux.Scene(BALL)
        points = np.ones((20, 3))
        base = {"name": "a", "parameters": {"young_modulus": {}}}
        cases = [
            ({**base, "grasps": []}, "grasps: found an empty list"),
            ({**base, "grasps": [{"scene": scene}]}, r"grasps\[0\]: found nothing measured"),
            ({**base, "grasps": [{"scene": "nowhere.yaml"}]}, r"grasps\[0\].scene: found"),
            (
                {**base, "grasps": [{"scene": scene, "scans": [points[:, :2]]}]},
                r"<grasps\[0\].scans\[0\]>: found an array of shape \(20, 2\)",
            ),
            (
                {**base, "grasps": [{"scene": scene, "fields": [{"points": points}]}]},
                r"grasps\[0\].fields\[0\].displacements: found no such key",
            ),
            (
                {**base, "grasps": [{"scene": dict(BALL, shell={}), "scans": [points]}]},
                "shell.thickness: found no such key",
            ),
        ]
        for what, message in cases:
            with self.subTest(message):
                with self.assertRaisesRegex(darboux.InputError, "^" + message):
                    darboux.calibrate(what)


class Studies(Folders):
    def test_a_study_has_the_errors_of_darboux_accuracy(self):
        file = data_file("clamped_plate.yaml")
        flags = ["--sweep=resolution,quadrature", "--levels=2", "--threads=1"]
        out = self.run_tool("darboux_accuracy", file, *flags)
        done = []
        study = darboux.Scene.load(file).accuracy_study(
            sweep=["resolution", "quadrature"],
            levels=2,
            threads=1,
            progress=lambda p: done.append(p.done),
        )
        self.assertTrue(study.established)

        def errors(runs):
            return [(run["label"], run["error"]) for run in runs]

        theirs = read_json(out, "accuracy.json")["runs"]
        self.assertEqual(errors(study.runs), errors(theirs))
        self.assertEqual(done, list(range(1, len(theirs) + 1)))
        mine = os.path.join(self.folder, "mine")
        study.write(mine)
        self.assertEqual(sorted(os.listdir(out)), sorted(os.listdir(mine)))

    def test_bad_input(self):
        for options, message in [
            ({"sweep": "height"}, "sweep: found"),
            ({"levels": 13}, "levels: found 13"),
            ({"repeats": 0}, "repeats: found 0"),
            ({"clock": "sun"}, "clock: found 'sun'"),
            ({"target": 2.0}, "target: found 2"),
        ]:
            with self.subTest(message), self.assertRaisesRegex(darboux.InputError, message):
                darboux.Scene(PLATE).accuracy_study(**options)


if __name__ == "__main__":
    unittest.main()
