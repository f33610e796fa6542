"""Material parameters from measured grasps."""

from __future__ import annotations

import functools
import os
from typing import Any, Dict, List, Mapping, Optional, Tuple, Union

from . import _darboux, _text
from ._errors import InputError
from ._progress import ProgressFunction, as_keywords, checked, given, run
from ._result import Result
from ._scan import points_of
from ._scene import Scene

Path = Union[str, "os.PathLike[str]"]


class Calibration:
    """Parameters of a shell, with intervals, and verdicts where measurements do not tell them."""

    def __init__(self, handle: Any) -> None:
        self._calibration = handle

    def __repr__(self) -> str:
        values = ", ".join(f"{name} {entry['value']}" for name, entry in self.parameters.items())
        return f"<darboux.Calibration: {values}>"

    @property
    def converged(self) -> bool:
        """Whether it ended at a minimum; says nothing about identifiability."""
        return self._calibration.converged

    @property
    def message(self) -> str:
        """How it ended, in words."""
        return self._calibration.message

    @property
    def report(self) -> str:
        """What darboux_calibrate prints."""
        return self._calibration.report

    @functools.cached_property
    def summary(self) -> Dict[str, Any]:
        """The contents of calibration.json."""
        return self._calibration.summary()

    @property
    def parameters(self) -> Dict[str, Dict[str, Any]]:
        """By name (young_modulus, thickness, poisson_ratio, gas_pressure), of those asked for:
        value, identifiable, verdict, interval_95, deviation (of the logarithm where it says so)."""
        return self.summary["parameters"]

    @property
    def identifiable(self) -> bool:
        """Whether the measurements tell every parameter that was asked for."""
        return all(entry["identifiable"] for entry in self.parameters.values())

    @functools.cached_property
    def states(self) -> List[Result]:
        """The scene of each grasp in the calibrated state."""
        count = self._calibration.num_states
        return [Result(self._calibration.state(grasp)) for grasp in range(count)]

    def write(self, folder: Path, report: bool = False) -> None:
        """Writes the files of darboux_calibrate: calibration.json, and a folder grasp_K with the
        results of each scene in the calibrated state; with report also report.html (see
        Result.write); OSError."""
        self._calibration.write(os.fspath(folder), bool(report))


def _take_data(what: Mapping[str, Any]) -> Tuple[Any, Dict[str, Dict[str, Any]]]:
    """The text's part of a calibration, and scenes and points by the names that stand for them."""
    data: Dict[str, Dict[str, Any]] = {"scenes": {}, "clouds": {}}

    def cloud(points: Any, displacements: Any, name: str) -> str:
        name = f"<{name}>"
        data["clouds"][name] = (points, displacements)
        return name

    def scan(entry: Any, name: str) -> Any:
        if isinstance(entry, (str, os.PathLike)):
            return entry
        if hasattr(entry, "keys"):
            entry = dict(entry)
            if "file" in entry:
                entry["file"] = scan(entry["file"], name)
            return entry
        return cloud(points_of(entry)[0], None, name)

    def field(entry: Any, name: str) -> Any:
        if not hasattr(entry, "keys") or "points" not in entry:
            return entry
        entry = dict(entry)
        if "displacements" not in entry:
            raise InputError(f"{name}.displacements: found no such key; allowed an (n, 3) array")
        if "file" in entry:
            raise InputError(f"{name}: found file beside points; allowed one or the other")
        entry["file"] = cloud(entry.pop("points"), entry.pop("displacements"), name)
        return entry

    what = dict(what)
    grasps = what.get("grasps")
    if isinstance(grasps, (list, tuple)):
        taken = []
        for g, grasp in enumerate(grasps):
            if hasattr(grasp, "keys"):
                grasp = dict(grasp)
                where = f"grasps[{g}]"
                scene = grasp.get("scene")
                if hasattr(scene, "keys"):
                    if not isinstance(scene, Scene):
                        scene = Scene(scene)
                    data["scenes"][f"<{where}.scene>"] = scene._handle()
                    grasp["scene"] = f"<{where}.scene>"
                for key, take in (("scans", scan), ("fields", field)):
                    if isinstance(grasp.get(key), (list, tuple)):
                        grasp[key] = [
                            take(entry, f"{where}.{key}[{i}]") for i, entry in enumerate(grasp[key])
                        ]
            taken.append(grasp)
        what["grasps"] = taken
    return _text.plain(what, ""), data


def calibrate(
    what: Union[Path, Mapping[str, Any]],
    *,
    folder: Optional[Path] = None,
    bootstrap: Optional[int] = None,
    theory: Optional[str] = None,
    strains: Optional[str] = None,
    quadrature: Optional[int] = None,
    divisions: Optional[Any] = None,
    minimizer: Optional[str] = None,
    threads: int = 0,
    time_limit: float = 0.0,
    max_iterations: int = 200,
    gradient_tolerance: float = 1e-7,
    sparse_backend: str = "auto",
    progress: ProgressFunction = None,
    stop: Any = None,
    check: bool = False,
) -> Calibration:
    """Young's modulus and, where asked, gas pressure, thickness and Poisson's ratio of a shell from
    scans, force readings and fields of displacements of its measured states; as darboux_calibrate.

    what:    a calibration file, or a dict with its keys (data/README.md), in which a scene may be a
             Scene or a dict, a scan (n, 3) points or a Scan, {"file": points, "registered": True}
             one whose pose is known, and a field {"points": (n, 3), "displacements": (n, 3), ...}:

        reading = {"finger": "top", "value": 14.6, "error": 0.1}
        grasp = {"scene": scene, "travel": 4, "scans": [points], "forces": [reading]}
        darboux.calibrate({"name": "ball", "parameters": {"young_modulus": {}}, "noise": 0.127,
                           "grasps": [grasp]})

    folder:  of files that a dict names; None: the current one
    bootstrap: resamples for bootstrap intervals, instead of what the file says
    theory ... stop: as of Scene.solve; the first five replace what all scenes say
    check:   raise NotConverged where it has not converged or a parameter is not identifiable
    """
    file, text = None, ""
    data: Dict[str, Dict[str, Any]] = {}
    if isinstance(what, (str, os.PathLike)):
        file = os.fspath(what)
    else:
        plain, data = _take_data(what)
        text = _text.flow(plain)
    options = given(bootstrap=bootstrap, theory=theory, strains=strains, quadrature=quadrature,
                    divisions=tuple(divisions) if divisions is not None else None,
                    minimizer=minimizer, threads=threads, time_limit=time_limit,
                    max_iterations=max_iterations, gradient_tolerance=gradient_tolerance,
                    sparse_backend=sparse_backend)  # fmt: skip
    where = os.fspath(folder) if folder is not None else ""
    result = run(
        lambda: _darboux.calibrate(file, text, where, data, options, as_keywords(progress), stop),
        Calibration,
    )
    unknown = [name for name, entry in result.parameters.items() if not entry["identifiable"]]
    message = result.message if not result.converged else f"not identifiable: {', '.join(unknown)}"
    return checked(result, result.converged and not unknown, message, check)


Calibration.__module__ = "darboux"
calibrate.__module__ = "darboux"
