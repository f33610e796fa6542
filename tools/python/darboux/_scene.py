"""Scenes: what is solved."""

from __future__ import annotations

import copy as copying
import hashlib
import os
from collections.abc import MutableMapping
from typing import Any, Dict, Iterator, List, Mapping, Optional, Tuple, Union

import numpy as np

from . import _darboux, _text
from ._errors import InputError
from ._progress import ProgressFunction, as_keywords, checked, given, run
from ._result import Result
from ._scan import Fit, points_of
from ._study import Study

Path = Union[str, "os.PathLike[str]"]


class Scene(MutableMapping):
    """A shell, what holds, loads and touches it, and what to report: a dict with the keys of a
    scene file (data/README.md lists them), whose values are dicts, lists, numbers and texts.

        scene = Scene.load("data/duck.yaml")
        scene = Scene(name="plate",
                      surface={"kind": "plane", "u": [0, 1], "v": [0, 1], "divisions": [16, 16]},
                      shell={"thickness": 0.01, "young_modulus": 210e9, "poisson_ratio": 0.3},
                      supports=[{"on": "rim", "clamped": True}],
                      loads=[{"kind": "pressure", "value": 1000.0}],
                      probes=[{"name": "centre", "at": {"uv": [0.5, 0.5]}}])
        scene["shell"]["thickness"] = 0.02

    numpy arrays and numbers count as lists and numbers. A surface of kind mesh, and a finger's
    shape of kind mesh, may have arrays instead of a file:

        {"kind": "mesh", "vertices": (n, 3) floats, "faces": (m, 3) integers, rows of vertices}

    faces counterclockwise seen from outside. Nothing is checked before check(), solve() and their
    like, which raise InputError.

    data:    a mapping; keyword arguments are further sections, name= among them
    folder:  where files that the scene names are looked for; None: the current folder
    repair:  mends a mesh before use (seams, winding, degenerate triangles); `mended` says what
    """

    def __init__(
        self,
        data: Optional[Mapping[str, Any]] = None,
        *,
        folder: Optional[Path] = None,
        repair: bool = False,
        **sections: Any,
    ) -> None:
        self._data: Dict[str, Any] = copying.deepcopy(dict(data)) if data is not None else {}
        self._data.update(copying.deepcopy(sections))
        self._folder = os.fspath(folder) if folder is not None else ""
        self._repair = bool(repair)
        # The text that the scene was read from, and what of it came out: as long as nothing is
        # changed, messages tell its lines.
        self._source: Optional[Tuple[str, str, str]] = None
        self._read: Optional[Tuple[Any, Any]] = None

    # ---- Making one -------------------------------------------------------------------------

    @classmethod
    def load(cls, file: Path, repair: bool = False) -> "Scene":
        """Reads and checks a scene file. InputError "FILE:LINE: KEY: found ...; allowed ..."."""
        name = os.fspath(file)
        handle = _darboux.read_scene(name, bool(repair))
        with open(name, encoding="utf-8") as stream:
            text = stream.read()
        return cls._from_text(text, name, os.path.dirname(name), repair, handle)

    @classmethod
    def from_yaml(cls, text: str, folder: Optional[Path] = None, repair: bool = False) -> "Scene":
        """Reads and checks the text of a scene file. Lines in messages are those of the text."""
        where = os.fspath(folder) if folder is not None else ""
        handle = _darboux.parse_scene(text, "<yaml>", where, bool(repair), {})
        return cls._from_text(text, "<yaml>", where, repair, handle)

    @classmethod
    def from_dict(
        cls, data: Mapping[str, Any], folder: Optional[Path] = None, repair: bool = False
    ) -> "Scene":
        """A checked copy of a dict with the keys of a scene file."""
        scene = cls(data, folder=folder, repair=repair)
        scene.check()
        return scene

    @classmethod
    def _from_text(cls, text: str, label: str, folder: str, repair: bool, handle: Any) -> "Scene":
        scene = cls(_darboux.yaml_to_python(text), folder=folder, repair=repair)
        flow, data = scene._serialise()
        scene._source = (flow, text, label)
        scene._read = (scene._key(flow, data), handle)
        return scene

    def copy(self) -> "Scene":
        """A copy that shares nothing with this one that can be changed."""
        other = Scene(self._data, folder=self._folder, repair=self._repair)
        other._source, other._read = self._source, self._read
        return other

    __copy__ = copy

    def __deepcopy__(self, memo: Any) -> "Scene":
        return self.copy()

    def __getstate__(self) -> Dict[str, Any]:
        return {**self.__dict__, "_read": None}  # What was read stays in this process.

    # ---- A dict -----------------------------------------------------------------------------

    def __getitem__(self, key: str) -> Any:
        return self._data[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self._data[key] = value

    def __delitem__(self, key: str) -> None:
        del self._data[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def __len__(self) -> int:
        return len(self._data)

    def __repr__(self) -> str:
        surface: Any = self._data.get("surface")
        kind = surface.get("kind") if hasattr(surface, "get") else None
        counts = [
            f"{len(self._data[key])} {key}"
            for key in ("supports", "loads", "fingers", "probes")
            if self._data.get(key)
        ]
        parts = [f"surface {kind}"] + counts
        return f"<darboux.Scene {self._data.get('name')!r}: {', '.join(parts)}>"

    @property
    def folder(self) -> str:
        """Where files that the scene names are looked for; empty: the current folder."""
        return self._folder

    @property
    def repair(self) -> bool:
        """Whether a mesh is mended before use."""
        return self._repair

    @repair.setter
    def repair(self, repair: bool) -> None:
        self._repair = bool(repair)

    def _append(self, section: str, entry: Dict[str, Any]) -> Dict[str, Any]:
        self._data.setdefault(section, []).append(entry)
        return entry

    def add_support(self, **keys: Any) -> Dict[str, Any]:
        """Appends to `supports`, e.g. on="rim", clamped=True; returns the new entry."""
        return self._append("supports", keys)

    def add_load(self, **keys: Any) -> Dict[str, Any]:
        """Appends to `loads`, e.g. kind="pressure", value=1000; returns the new entry."""
        return self._append("loads", keys)

    def add_finger(
        self,
        name: str,
        shape: Mapping[str, Any],
        position: Any,
        direction: Any,
        travel: Optional[float] = None,
        force: Optional[float] = None,
        friction: float = 0.0,
    ) -> Dict[str, Any]:
        """Appends to `fingers` a rigid finger that closes along `direction`, driven by a travel
        (length, from first touch) or a force; returns the new entry.

        shape: {"kind": "sphere", "radius": r}, also pin, capsule, box, plane, mesh
        position: of the shape's centre, (3,)
        """
        motion = given(travel=travel, force=force)
        entry: Dict[str, Any] = {
            "name": name,
            "shape": dict(shape),
            "position": position,
            "direction": direction,
            "motion": motion,
        }
        if friction != 0.0:
            entry["friction"] = friction
        return self._append("fingers", entry)

    def add_probe(self, name: str, uv: Any = None, nearest: Any = None) -> Dict[str, Any]:
        """Appends to `probes` the surface point at uv=(u, v), or nearest=(x, y, z); returns the new
        entry."""
        return self._append("probes", {"name": name, "at": given(uv=uv, nearest=nearest)})

    # ---- As text, and checked ---------------------------------------------------------------

    def _serialise(self) -> Tuple[str, _text.Meshes]:
        meshes: _text.Meshes = {}
        return _text.flow(_text.plain_scene(self._data, meshes)), meshes

    def _key(self, flow: str, meshes: _text.Meshes) -> Tuple[Any, ...]:
        digest = hashlib.sha256()
        for name, arrays in sorted(meshes.items()):
            for array in arrays:
                values = np.ascontiguousarray(array)
                digest.update(f"{name} {values.dtype.str} {values.shape} ".encode())
                digest.update(values.tobytes())
        return (flow, self._folder, self._repair, digest.hexdigest())

    def _handle(self) -> Any:
        """The scene as the solver has it. Read anew where something has changed."""
        flow, meshes = self._serialise()
        key = self._key(flow, meshes)
        if self._read is not None and self._read[0] == key:
            return self._read[1]
        if self._source is not None and self._source[0] == flow:
            _, text, label = self._source
        else:
            text, label = flow, _darboux.scene_label
        handle = _darboux.parse_scene(text, label, self._folder, self._repair, {"meshes": meshes})
        self._read = (key, handle)
        return handle

    def check(self) -> None:
        """InputError where the scene is none that can be read: keys, types, values, mesh files.
        What only solving can tell (a rigid motion that nothing holds) is told there."""
        self._handle()

    @property
    def mended(self) -> List[str]:
        """What `repair` has done to the mesh, a line each. Checks the scene."""
        return list(self._handle().mended)

    def to_yaml(self) -> str:
        """The text of a scene file with these keys. InputError where meshes are arrays: save()
        writes files of them."""
        meshes: _text.Meshes = {}
        plain = _text.plain_scene(self._data, meshes)
        if meshes:
            raise InputError(
                f"{', '.join(meshes)}: found arrays; allowed files of meshes, which save() writes"
            )
        return _text.block(plain)

    def save(self, file: Path) -> List[str]:
        """Writes a scene file that reads back as this scene, and beside it an OBJ file for every
        mesh that is an array. File names that the scene has are kept: write it into the folder that
        they belong to. Returns the names of the files written."""
        name = os.fspath(file)
        meshes: _text.Meshes = {}
        plain = _text.plain_scene(self._data, meshes)
        stem = os.path.splitext(os.path.basename(name))[0]
        written = []
        texts = {}
        if "<surface>" in meshes:
            texts[f"{stem}_surface.obj"] = _obj(*meshes["<surface>"])
            plain["surface"]["file"] = f"{stem}_surface.obj"
        for i, finger in enumerate(plain.get("fingers") or []):
            key = f"<fingers[{i}].shape>"
            if key in meshes:
                texts[f"{stem}_finger_{i}.obj"] = _obj(*meshes[key])
                finger["shape"]["file"] = f"{stem}_finger_{i}.obj"
        texts[os.path.basename(name)] = _text.block(plain)
        for part, text in texts.items():
            path = os.path.join(os.path.dirname(name), part)
            with open(path, "w", encoding="utf-8") as stream:
                stream.write(text)
            written.append(path)
        return written

    # ---- Work -------------------------------------------------------------------------------

    def solve(
        self,
        *,
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
        start: Optional[Result] = None,
        progress: ProgressFunction = None,
        stop: Any = None,
        check: bool = False,
    ) -> Result:
        """Deforms the shell under its loads and fingers, as darboux_deform does, and to the same
        bits. With model.accuracy the solver chooses theory, lattice and quadrature itself.

        theory, strains, quadrature, divisions, minimizer: instead of what the scene says ("auto",
                     "linear", "nonlinear"; "koiter", "seed"; 1, 3, 6, 12; (M, N); "auto", "mip",
                     "ceres", "cg"); expectations of the scene stay what they are
        threads:     0 for as many as the machine runs at once
        time_limit:  seconds; 0 for none
        max_iterations: of a load step
        gradient_tolerance: a step has converged when |gradient| <= this * (|loads| + |reactions|)
        sparse_backend: "auto", "suite_sparse", "eigen" (slower, runs no GPL code)
        start:       a result on the same mesh, from whose final state the nonlinear theory starts:
                     saves iterations in sweeps. A state that depends on the way (friction,
                     buckling) may then be another one, and with friction squeeze_work counts the
                     way from there alone
        progress:    called with a Progress (see there) after each load step and iteration
        stop:        an object with is_set(), as threading.Event; set, it stops the solve
        check:       raise NotConverged (its `result` is the state) where it has not converged

        Without check a solve that has not converged, was stopped or ran out of time is no
        exception: `converged` of the result is False and `message` says why; its fields are those of
        the last state. InputError: bad input. KeyboardInterrupt (Ctrl-C): has the last state as its
        attribute `result`, unless a factorisation kept the solver from answering for 5 seconds.
        """
        handle = self._handle()
        options = given(
            theory=theory,
            strains=strains,
            quadrature=quadrature,
            divisions=tuple(divisions) if divisions is not None else None,
            minimizer=minimizer,
            threads=threads,
            time_limit=time_limit,
            max_iterations=max_iterations,
            gradient_tolerance=gradient_tolerance,
            sparse_backend=sparse_backend,
        )
        from_state = start._solution if start is not None else None
        result = run(
            lambda: _darboux.solve(handle, options, as_keywords(progress), stop, from_state), Result
        )
        return checked(result, result.converged, result.message, check)

    def fit(
        self,
        scan: Any,
        *,
        fingers: Optional[str] = None,
        face: str = "outer",
        noise: float = 0.0,
        weight: float = 0.0,
        seed: int = 1,
        theory: Optional[str] = None,
        divisions: Optional[Any] = None,
        threads: int = 0,
        time_limit: float = 0.0,
        sparse_backend: str = "auto",
        progress: ProgressFunction = None,
        stop: Any = None,
        check: bool = False,
    ) -> Fit:
        """Fits the deformation of the shell to a scan of it, registration included, as darboux_fit.

        scan:     (n, 3) points in the scene's unit of length and a frame of their own, a Scan, or
                  the name of a file (.csv, .ply, .obj, .stl, .off)
        fingers:  "scene": the start, and what fills holes, is the scene's own equilibrium; "none":
                  the shell at rest. None: "scene" where it has fingers or loads
        face:     the scanned one: "outer" (along normals), "inner" or "middle"
        noise:    standard deviation of the scan along normals; 0: estimated
        weight:   of the energy, without unit; 0: by the discrepancy principle
        """
        options = given(mode="fit", fingers=fingers, face=face, noise=noise, weight=weight,
                        seed=seed, theory=theory, threads=threads, time_limit=time_limit,
                        divisions=tuple(divisions) if divisions is not None else None,
                        sparse_backend=sparse_backend)  # fmt: skip
        return self._fit(scan, options, progress, stop, check)

    def register(
        self,
        scan: Any,
        *,
        against: str = "deformed",
        method: str = "robust",
        undeformed_part: float = 0.05,
        face: str = "outer",
        seed: int = 1,
        theory: Optional[str] = None,
        divisions: Optional[Any] = None,
        threads: int = 0,
        time_limit: float = 0.0,
        sparse_backend: str = "auto",
        progress: ProgressFunction = None,
        stop: Any = None,
        check: bool = False,
    ) -> Fit:
        """Finds the rigid motion that brings a scan onto the shell, and the distances between them,
        as darboux_fit --mode=register.

        scan, face: as of fit()
        against:  "deformed", the scene's equilibrium, or "rest"
        method:   "robust", or "undeformed_first": the pose from where the shell hardly moved (by
                  less than undeformed_part of its largest displacement)
        """
        options = given(mode="register", against=against, method=method,
                        undeformed_part=undeformed_part, face=face, seed=seed, theory=theory,
                        divisions=tuple(divisions) if divisions is not None else None,
                        threads=threads, time_limit=time_limit,
                        sparse_backend=sparse_backend)  # fmt: skip
        return self._fit(scan, options, progress, stop, check)

    def _fit(
        self,
        scan: Any,
        options: Dict[str, Any],
        progress: ProgressFunction,
        stop: Any,
        check: bool,
    ) -> Fit:
        points, name = points_of(scan)
        handle = self._handle()
        fit = run(
            lambda: _darboux.fit(handle, points, name, options, as_keywords(progress), stop), Fit
        )
        return checked(fit, fit.converged, fit.verdict, check)

    def accuracy_study(
        self,
        *,
        sweep: Any = None,
        product: bool = False,
        levels: int = 0,
        max_dof: float = 30000,
        repeats: int = 1,
        clock: str = "wall",
        target: Optional[float] = None,
        reference: str = "auto",
        threads: int = 0,
        time_limit: float = 0.0,
        sparse_backend: str = "auto",
        progress: ProgressFunction = None,
        stop: Any = None,
    ) -> Study:
        """What accuracy costs in time: the scene solved with many settings, as darboux_accuracy
        does, but in this process; so no memory is told, and a crash would be Python's.

        sweep:      some of "resolution", "grading", "quadrature", "boundary_rule", "strains",
                    "theory", "solver"; None: all
        product:    all combinations, not each by itself
        levels:     resolutions, 1 to 12; 0: five, meshes three
        max_dof:    runs with more degrees of freedom are left out
        repeats:    of each run; the least time counts
        clock:      "wall" or "cpu": the seconds that count
        target:     a relative error of your own besides 0.1, 0.01, 0.001
        reference:  "auto": the scene's expectations, or where there are none "richardson"
        time_limit: seconds of the whole study; 0 for none
        """
        if sweep is not None and not isinstance(sweep, str):
            sweep = ",".join(sweep)
        options = given(sweep=sweep, product=product, levels=levels, max_dof=float(max_dof),
                        repeats=repeats, clock=clock, target=target, reference=reference,
                        threads=threads, time_limit=time_limit,
                        sparse_backend=sparse_backend)  # fmt: skip
        handle = self._handle()
        return run(
            lambda: _darboux.accuracy_study(handle, options, as_keywords(progress), stop), Study
        )


def _obj(vertices: Any, faces: Any) -> str:
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices, float).tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in np.asarray(faces).tolist()]
    return "\n".join(lines) + "\n"


Scene.__module__ = "darboux"
