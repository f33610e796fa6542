"""Results of a solved scene."""

from __future__ import annotations

import functools
import os
from typing import Any, Dict, List, Optional, Union

import numpy as np

from . import _darboux
from ._progress import given
from ._scan import Scan

Array = np.ndarray


def with_arrays(value: Any) -> Any:
    """Maps of x, y, z, and lists of numbers, as arrays."""
    if isinstance(value, dict):
        if list(value) == ["x", "y", "z"]:
            parts = [np.nan if part is None else part for part in value.values()]
            return np.array(parts, dtype=float)
        return {key: with_arrays(item) for key, item in value.items()}
    if isinstance(value, list) and value:
        if all(isinstance(item, (int, float)) and not isinstance(item, bool) for item in value):
            return np.array(value, dtype=float)
        rows = [with_arrays(item) for item in value]
        if all(isinstance(row, np.ndarray) and row.ndim == 1 for row in rows):
            return np.array(rows)
        return rows
    return value


class _Field:
    """An attribute of Result that is an array."""

    def __init__(self, where: str, doc: str) -> None:
        self._where = where
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, result: Any, owner: Optional[type] = None) -> Array:
        return self if result is None else getattr(result, self._where)[self._name]  # type: ignore

    def __set__(self, result: Any, value: Any) -> None:
        raise AttributeError(f"{self._name} is a result: it cannot be set")


class Result:
    """A solved scene, which nothing changes any more: its numbers, its fields and its files.

    Fields are given at n points, the corners of all elements and the middles of their edges, joined
    by m triangles: those of shell.vtu. Those of the final state are attributes, read-only arrays:

    points                     (n, 3) rest positions
    triangles                  (m, 3) int32 rows of points, counterclockwise seen from the side
                               that the normal points to
    uv                         (n, 2) parameters; 0 on meshes
    principal_curvatures       (n, 2) of the rest surface, kappa_1 >= kappa_2, 1/length
    principal_direction_1      (n, 3) unit tangent of its first line of curvature
    displacement               (n, 3) length
    deformed                   (n, 3) points + displacement
    normal                     (n, 3) unit normal of the deformed middle surface
    membrane_strain            (n, 3) Green's, components 11, 22, 12
    principal_membrane_strain  (n, 2) e_1 >= e_2
    bending_strain             (n, 3) change of curvature, 11, 22, 12, 1/length; > 0 where the
                               curvature towards the normal grows
    membrane_force             (n, 3) stress resultants 11, 22, 12, force/length
    moment                     (n, 3) 11, 22, 12, force; > 0 compresses the face that the normal
                               points out of
    von_mises_top, _bottom     (n,) force/length^2, at the faces half the thickness along +n and -n
    energy_density             (n,) energy/length^2, the sum of
    membrane_energy_density, bending_energy_density

    fields(step) gives the same of any load step. A value is nan where the deformed surface has no
    normal.
    """

    def __init__(self, solution: Any) -> None:
        self._solution = solution

    def __repr__(self) -> str:
        state = "converged" if self.converged else f"not converged ({self.message})"
        return f"<darboux.Result {self.summary['name']!r}: {state}, {self.num_steps} load steps>"

    # ---- Numbers ----------------------------------------------------------------------------

    @property
    def converged(self) -> bool:
        """Whether every load step has converged and all numbers are finite."""
        return bool(self.summary["converged"])

    @property
    def termination(self) -> str:
        """"converged", "not_converged", "time_limit", "stopped", "failed" or "not_run"."""
        return self._solution.termination

    @property
    def message(self) -> str:
        """How the solve ended, in words."""
        return self.summary["message"]

    @property
    def report(self) -> str:
        """What darboux_deform prints: effects, energies, probes, decisions."""
        return self._solution.report

    @functools.cached_property
    def summary(self) -> Dict[str, Any]:
        """The contents of summary.json (but for the seconds that writing files takes)."""
        return self._solution.summary()

    @property
    def expectations_hold(self) -> bool:
        """Whether every `expect` of the scene holds; summary["expect"] has the details."""
        return all(entry["holds"] for entry in self.summary["expect"])

    @property
    def num_steps(self) -> int:
        """Load steps that were reached."""
        return self._solution.num_steps

    def step(self, step: int = -1) -> Dict[str, Any]:
        """The numbers of a load step (0 .. num_steps - 1, or from the end): factor, iterations,
        converged, energy, energies of each effect, relative_gradient, max_displacement, stability,
        probes, fingers, grasp, gas and supports, named as in summary.json; vectors are (3,)
        arrays."""
        return with_arrays(self._solution.step_summary(step))

    @functools.cached_property
    def _last(self) -> Dict[str, Any]:
        return with_arrays({key: self.summary[key] for key in ("probes", "fingers", "grasp")})

    @property
    def probes(self) -> Dict[str, Any]:
        """By name: position (3,) at rest and displacement (3,) of the final state."""
        return self._last["probes"]

    @property
    def fingers(self) -> Dict[str, Any]:
        """By name, in the final state: force (3,) on the finger, normal_force, travel,
        contact_area, largest_pressure, penetration, indentation, normal (3,), center (3,), stiffness (change of
        its force along its direction by its travel), friction_cone, ...; data/README.md has all."""
        return self._last["fingers"]

    @property
    def grasp(self) -> Dict[str, Any]:
        """What a planner asks of the grasp in the final state (empty without fingers): stiffness
        (k, k), column j the change of every finger's force by the travel of finger j; squeeze_work,
        stored_energy; force_closure_before and _after with closed, margin (Ferrari and Canny),
        least_friction and what is lacking; center_before, center (3,)."""
        return self._last["grasp"]

    @functools.cached_property
    def history(self) -> Dict[str, Array]:
        """history.csv: a (num_steps,) array for each column, e.g. "factor",
        "fingers.top.normal_force", "probes.pole.displacement.z"; nan where there is no value."""
        lines = self._solution.history_csv().splitlines()
        rows = [[float(text or "nan") for text in line.split(",")] for line in lines[1:]]
        names = lines[0].split(",")
        table = np.array(rows, dtype=float).reshape(len(rows), len(names))
        return {name: table[:, i].copy() for i, name in enumerate(names)}

    @property
    def iterations(self) -> Dict[str, Any]:
        """How it converged, an entry for every iteration: method (list of texts); step, iteration,
        total (int32), load_factor, energy, relative_gradient and seconds (float64)."""
        return self._solution.iterations()

    # ---- Fields -----------------------------------------------------------------------------

    @functools.cached_property
    def _rest(self) -> Dict[str, Array]:
        return _frozen(self._solution.rest_fields())

    @functools.cached_property
    def _final(self) -> Dict[str, Array]:
        return _frozen(self._solution.fields(-1))

    # Of the rest surface, and of the final state; see the class.

    points = _Field("_rest", "(n, 3) rest positions.")
    triangles = _Field("_rest", "(m, 3) int32 rows of points.")
    uv = _Field("_rest", "(n, 2) parameters; 0 on meshes.")
    principal_curvatures = _Field("_rest", "(n, 2) of the rest surface, 1/length.")
    principal_direction_1 = _Field("_rest", "(n, 3) unit tangent of a line of curvature, at rest.")
    displacement = _Field("_final", "(n, 3) length, final state.")
    normal = _Field("_final", "(n, 3) unit normal of the deformed middle surface, final state.")
    membrane_strain = _Field("_final", "(n, 3) components 11, 22, 12, final state.")
    principal_membrane_strain = _Field("_final", "(n, 2) e_1 >= e_2, final state.")
    bending_strain = _Field("_final", "(n, 3) components 11, 22, 12, 1/length, final state.")
    membrane_force = _Field("_final", "(n, 3) components 11, 22, 12, force/length, final state.")
    moment = _Field("_final", "(n, 3) components 11, 22, 12, force, final state.")
    von_mises_top = _Field("_final", "(n,) at the face along +n, force/length^2, final state.")
    von_mises_bottom = _Field("_final", "(n,) at the face along -n, force/length^2, final state.")
    energy_density = _Field("_final", "(n,) strain energy per rest area, final state.")
    membrane_energy_density = _Field("_final", "(n,) of stretching alone, final state.")
    bending_energy_density = _Field("_final", "(n,) of bending alone, final state.")

    def fields(self, step: int = -1) -> Dict[str, Array]:
        """The fields of a load step by name (see the class), as new arrays; at an unstable state
        also lowest_mode (n, 3), its softest direction of any length."""
        fields = self._solution.fields(step)
        mode = self._solution.mode(step)
        if mode is not None:
            fields["lowest_mode"] = mode
        return fields

    @property
    def deformed(self) -> Array:
        """(n, 3) points + displacement."""
        return self.points + self.displacement

    def control_displacements(self, step: int = -1) -> Array:
        """(k, 3) displacements of the control vertices, the solver's unknowns. They are no
        displacements of surface points."""
        return self._solution.control_displacements(step)

    def at(self, uv: Any = None, nearest: Any = None, step: int = -1) -> Dict[str, Array]:
        """All fields at surface points of your own: uv (k, 2), within the ranges, or the points of
        the rest surface nearest to `nearest` (k, 3). One point, (2,) or (3,), gives arrays without
        their first axis. Also position (k, 3) at rest, uv and principal_curvatures."""
        given_points = uv if uv is not None else nearest
        single = given_points is not None and np.ndim(given_points) == 1
        if single:
            uv, nearest = (None if p is None else np.asarray(p)[None] for p in (uv, nearest))
        fields = self._solution.at(uv, nearest, step)
        return {name: values[0] for name, values in fields.items()} if single else fields

    def contact(self, step: int = -1) -> Dict[str, Array]:
        """The points where fingers press, c of them: finger (c,) int32, its number in the scene;
        element (c,) int32; position (c, 3) deformed, on the middle surface; normal (c, 3) of the
        finger towards the shell; gap, pressure, area (c,), per area and of the rest surface;
        friction (c, 3) force on the finger; sticks (c,) bool."""
        return self._solution.contact(step)

    # ---- Files and scans --------------------------------------------------------------------

    def write(self, folder: Union[str, "os.PathLike[str]"], report: bool = False) -> List[str]:
        """Writes the files of darboux_deform into a folder, created when missing: summary.json,
        shell.pvd and shell.vtu for ParaView (one per load step), deformed.ply, history.csv,
        contact.csv; with report also report.html, shape, numbers and plots for any browser
        (InputError where Darboux was built without it). All of them or none (OSError). Returns their
        names."""
        return self._solution.write(os.fspath(folder), bool(report))

    def scan(
        self,
        points: int = 20000,
        *,
        noise: float = 0.0,
        step: int = -1,
        seed: int = 1,
        bias: float = 0.0,
        bias_length: float = 0.0,
        bias_along: str = "normal",
        outliers: float = 0.0,
        spike_share: float = 0.5,
        spike_size: float = 0.05,
        outlier_box: float = 1.5,
        motion: str = "random",
        max_angle: float = 180.0,
        max_translation: float = 1.0,
        views: Any = 8,
        view_distance: float = 5.0,
        grazing: float = 75.0,
        sampling: str = "area",
    ) -> Scan:
        """Simulates a scan of the outer face, fingers in the way included, as darboux_scan does:
        visible points with noise, bias and outliers, in a frame of their own. The same seed gives
        the same scan.

        points:   how many, outliers included
        noise:    standard deviation along the view ray, a length
        bias:     root mean square of a smooth error, a length; bias_length: its correlation length
                  (0: a quarter of the extent); bias_along: "normal" or "ray"
        outliers: part of the points that is wrong, spike_share of them shifted along their rays by
                  up to spike_size extents, the others anywhere in the bounding box times outlier_box
        motion:   "random": the scanner's frame is turned by up to max_angle degrees and shifted by
                  up to max_translation extents; "none"
        views:    number of viewpoints around the shell (0: everything is seen), view_distance half
                  diagonals of the bounding box away; or (k, 3) viewpoints
        grazing:  largest angle between normal and ray at which a point is seen, degrees
        sampling: "area", or "vertices": those of `points`
        """
        options = given(points=points, noise=float(noise), seed=seed, bias=float(bias),
                        bias_length=float(bias_length), bias_along=bias_along,
                        outliers=float(outliers), spike_share=float(spike_share),
                        spike_size=float(spike_size), outlier_box=float(outlier_box),
                        motion=motion, max_angle=float(max_angle),
                        max_translation=float(max_translation), views=views,
                        view_distance=float(view_distance), grazing=float(grazing),
                        sampling=sampling)  # fmt: skip
        return Scan(_darboux.simulate_scan(self._solution, step, options))


def _frozen(fields: Dict[str, Array]) -> Dict[str, Array]:
    for values in fields.values():
        values.flags.writeable = False
    return fields


Result.__module__ = "darboux"
