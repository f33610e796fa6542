"""What the tests of the Python module have in common. ctest sets the environment."""

import base64
import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

DATA = os.environ["DARBOUX_DATA"]
TOOLS = os.environ.get("DARBOUX_TOOLS", "")  # folder of the tools; empty where they are not built

PLATE = {
    "name": "plate",
    "surface": {"kind": "plane", "u": [0, 1], "v": [0, 1], "divisions": [8, 8]},
    "shell": {"thickness": 0.01, "young_modulus": 210e9, "poisson_ratio": 0.3},
    "supports": [{"on": "rim", "simply_supported": True}],
    "loads": [{"kind": "pressure", "value": 1000.0}],
    "probes": [{"name": "centre", "at": {"uv": [0.5, 0.5]}}],
}

# A ball between two fingers, small: 486 unknowns, mm, N, MPa.
BALL = {
    "name": "ball",
    "surface": {"kind": "icosphere", "radius": 31.25, "frequency": 4},
    "shell": {"thickness": 2.5, "young_modulus": 1.0, "poisson_ratio": 0.49},
    "supports": [
        {"on": {"near": [0, 0, 31.25], "radius": 0}, "fix": ["x", "y"]},
        {"on": {"near": [0, 0, -31.25], "radius": 0}, "fix": ["x", "y"]},
    ],
    "fingers": [
        {
            "name": name,
            "shape": {"kind": "sphere", "radius": 10},
            "position": [0, 0, -60 * way],
            "direction": [0, 0, way],
            "motion": {"travel": 4.0},
        }
        for name, way in (("top", -1), ("bottom", 1))
    ],
    "probes": [{"name": "pole", "at": {"nearest": [0, 0, 31.25]}}],
}


def data_file(name):
    return os.path.join(DATA, name)


def without_times(value):
    """JSON without its seconds."""
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if k not in ("time_s", "seconds")}
    if isinstance(value, list):
        return [without_times(item) for item in value]
    return value


def read_json(*parts):
    with open(os.path.join(*parts), encoding="utf-8") as stream:
        return json.load(stream)


def read_vtu(file):
    """The arrays of a .vtu file by name, and its points."""
    with open(file, encoding="utf-8") as stream:
        text = stream.read()
    types = {"Float64": "<f8", "Int32": "<i4", "UInt8": "u1"}
    arrays = {}
    for kind, attributes, content in re.findall(
        r'<DataArray type="(\w+)" ([^>]*)format="binary">([^<]*)</DataArray>', text
    ):
        name = re.search(r'Name="(\w+)"', attributes).group(1)
        columns = re.search(r'NumberOfComponents="(\d+)"', attributes)
        values = np.frombuffer(base64.b64decode(content)[8:], dtype=types[kind])
        if columns is not None and int(columns.group(1)) > 1:
            values = values.reshape(-1, int(columns.group(1)))
        arrays[name] = values
    return arrays


def one_thread():
    return dict(os.environ, OPENBLAS_NUM_THREADS="1")


class Folders(unittest.TestCase):
    """Tests with a folder of their own, `self.folder`."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="darboux_")
        self.addCleanup(shutil.rmtree, self.folder)

    def run_tool(self, tool, *arguments, status=0):
        """Runs a tool of the build; its files are in the folder returned."""
        if not TOOLS:
            self.skipTest("the tools are not built")
        out = os.path.join(self.folder, tool)
        done = subprocess.run(
            [os.path.join(TOOLS, tool), *arguments, f"--out={out}", "--quiet"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            universal_newlines=True,
            check=False,
        )
        self.assertEqual(done.returncode, status, done.stderr)
        return out

    def assert_same_files(self, one, other, but=()):
        names = sorted(os.listdir(one))
        self.assertEqual(names, sorted(os.listdir(other)))
        for name in names:
            if name in but:
                continue
            contents = []
            for folder in (one, other):
                with open(os.path.join(folder, name), "rb") as stream:
                    contents.append(stream.read())
            self.assertTrue(contents[0] == contents[1], f"{name} differs")
