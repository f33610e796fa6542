"""The package as a guest in somebody's Python: quiet, documented, at peace with numpy."""

import inspect
import os
import subprocess
import sys
import unittest

import darboux
from module_util import Folders, data_file

EXAMPLES = os.environ["DARBOUX_EXAMPLES"]


def run_python(*arguments, **keywords):
    return subprocess.run(
        [sys.executable, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        universal_newlines=True,
        check=False,
        **keywords,
    )


class Guests(unittest.TestCase):
    SOLVE = (
        "scene = darboux.Scene.load({file!r})\n"
        "result = scene.solve(threads=1)\n"
        "a = numpy.random.default_rng(1).random((300, 300))\n"
        "inverse = numpy.linalg.solve(a, numpy.eye(300))\n"
        "assert numpy.allclose(a @ inverse, numpy.eye(300), atol=1e-8)\n"
        "print(result.displacement.tobytes().hex())\n"
    )

    def test_importing_and_solving_prints_nothing_and_does_not_depend_on_numpys_blas(self):
        solve = self.SOLVE.format(file=data_file("cylinder_harmonic.yaml"))
        warm_up = "numpy.linalg.inv(numpy.eye(200) + 1)\n"
        outputs = []
        for first in (
            "import darboux, numpy\n",
            "import numpy\n" + warm_up + "import darboux\n",
        ):
            done = run_python("-c", first + solve)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(done.stderr, "")
            outputs.append(done.stdout)
        self.assertGreater(len(outputs[0]), 1000)
        self.assertEqual(outputs[0], outputs[1])

    def test_a_forked_child_can_solve(self):
        code = (
            "import darboux, multiprocessing\n"
            "def force(travel):\n"
            f"    scene = darboux.Scene.load({data_file('clamped_plate.yaml')!r})\n"
            "    return scene.solve(threads=1).summary['max_displacement']\n"
            "force(1)\n"
            "with multiprocessing.get_context('fork').Pool(2) as pool:\n"
            "    values = pool.map(force, range(4))\n"
            "assert len(set(values)) == 1, values\n"
        )
        done = run_python("-c", code, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_without_numpy_it_says_what_it_needs(self):
        done = run_python("-c", "import sys\nsys.modules['numpy'] = None\nimport darboux")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("darboux needs numpy (Debian: python3-numpy)", done.stderr)


class Documentation(unittest.TestCase):
    def test_everything_public_has_a_docstring(self):
        self.assertIn("Units", darboux.__doc__)
        for name in darboux.__all__:
            thing = getattr(darboux, name)
            with self.subTest(name):
                self.assertEqual(thing.__module__, "darboux")
                self.assertTrue(inspect.getdoc(thing))
                if not inspect.isclass(thing) or issubclass(thing, BaseException):
                    continue
                for attribute, value in vars(thing).items():
                    if not attribute.startswith("_"):
                        self.assertTrue(inspect.getdoc(value), f"{name}.{attribute}")

    def test_signatures_have_types(self):
        self.assertTrue(os.path.exists(os.path.join(os.path.dirname(darboux.__file__), "py.typed")))
        for function in (darboux.Scene.solve, darboux.Result.scan, darboux.calibrate):
            for name, parameter in inspect.signature(function).parameters.items():
                if name != "self":
                    self.assertIsNot(parameter.annotation, inspect.Parameter.empty, name)


class Examples(Folders):
    def test_grasp_sweep(self):
        done = run_python(os.path.join(EXAMPLES, "grasp_sweep.py"), cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [[float(word) for word in line.split()] for line in done.stdout.splitlines()[1:]]
        self.assertEqual(len(rows), 6)
        for radius in (3, 10):
            force = [row[2] for row in rows if row[0] == radius]
            stored = [row[5] for row in rows if row[0] == radius]
            self.assertEqual(force, sorted(force))
            self.assertEqual(stored, sorted(stored))


if __name__ == "__main__":
    unittest.main()
