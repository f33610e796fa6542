"""Darboux: how thin shells (balls, bottles, cups, toys) deform when a robot hand grasps them.

    import darboux

    scene = darboux.Scene.load("data/tennis_ball.yaml")      # or darboux.Scene({...}), same keys
    scene["fingers"][0]["motion"]["travel"] = 4.0
    result = scene.solve(threads=2)
    print(result.converged, result.fingers["top"]["normal_force"])
    moved = result.points + result.displacement              # (n, 3)
    result.write("out")                                      # the files of darboux_deform

A scene is what a scene file says: nested dicts, lists, numbers and texts, with numpy arrays
wherever lists or meshes are meant. data/README.md lists all keys. It is checked by the reader of
scene files, so that a mistake is an InputError which names the key, what was found and what is
allowed.

Scene               what is solved: load it or build it, change it, solve it
Result              numbers, fields and files of a solved scene
Fit, Scan           deformations fitted to scans, scans simulated; read_points, write_points
calibrate           Young's modulus and more from measured grasps, as a Calibration
Study               what accuracy costs (Scene.accuracy_study)
Progress            what a `progress` function is called with
InputError          bad input; a ValueError
NotConverged        raised where check=True and a solution has not converged

Units: any consistent system, the scene's own; results are in the same. Angles are in radians.
Arrays: float64 or int32, C order; they own their memory and outlive what they came from. Symmetric
tensors are (11, 22, 12) in the orthonormal frame (t1, t2) of the rest surface, t1 along its
u-lines, component 12 the tensor's own (half the engineering shear).

Threads: all long work runs without Python's global lock, so that other threads go on and several
can solve at once. A `progress` function is called in the thread that called solve(). Ctrl-C ends a
solve in the main thread within an iteration (KeyboardInterrupt; what there was by then is its
attribute `result`); a factorisation under way is left behind after 5 seconds or a second Ctrl-C.
In any thread `stop=threading.Event()` does the same without an exception.
"""

try:
    import numpy as _numpy  # noqa: F401
except ImportError as error:
    raise ImportError("darboux needs numpy (Debian: python3-numpy)") from error

import atexit as _atexit

from . import _darboux
from ._calibration import Calibration, calibrate
from ._errors import InputError, NotConverged
from ._progress import Progress
from ._result import Result
from ._scan import Fit, Scan, read_points, write_points
from ._scene import Scene
from ._study import Study

__version__ = _darboux.version
__all__ = [
    "Calibration",
    "Fit",
    "InputError",
    "NotConverged",
    "Progress",
    "Result",
    "Scan",
    "Scene",
    "Study",
    "calibrate",
    "read_points",
    "write_points",
]

# Work that an interrupt has left behind must not meet an interpreter that is gone.
_atexit.register(_darboux.join_abandoned)
