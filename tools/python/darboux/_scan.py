"""Scans, simulated and measured, and what is fitted to them."""

from __future__ import annotations

import functools
import os
from typing import Any, Dict, List, Optional, Tuple, Union

import numpy as np

from . import _darboux

Path = Union[str, "os.PathLike[str]"]
Array = np.ndarray


def read_points(file: Path) -> Dict[str, Optional[Array]]:
    """Points of a .csv, .txt, .xyz, .ply, .obj, .stl or .off file: points (n, 3), and normals and
    displacements (n, 3) where the file has them, else None. InputError "FILE:LINE: ..."."""
    return _darboux.read_points(os.fspath(file))


def write_points(file: Path, points: Any, normals: Any = None) -> None:
    """Writes (n, 3) points, and normals, as .csv or .ply, to the last bit."""
    _darboux.write_points(os.fspath(file), points, normals)


def points_of(scan: Any) -> Tuple[Any, str]:
    """Points, and what messages and fit.json call them."""
    if isinstance(scan, Scan):
        return scan.points, "simulated scan"
    if isinstance(scan, (str, os.PathLike)):
        return read_points(scan)["points"], os.fspath(scan)
    return scan, "points"


class Scan:
    """A simulated scan, and the truth about it that whoever fits must not know.

    points       (n, 3) in the scanner's frame
    normals      (n, 3) of the face, in the scanner's frame
    pose         (4, 4) rigid motion from the scanner's frame into the model's
    true_points  (n, 3) points of the face in the model's frame, without errors
    outlier      (n,) int32: 0 none, 1 spike, 2 stray
    view         (n,) int32: the viewpoint it was measured from; -1: none
    noise, bias  (n,) errors that were added, along the ray; along the normal or the ray
    viewpoints   (k, 3) in the model's frame
    num_tried    points of the face that were tried; those not seen are not among `points`
    """

    points: Array
    normals: Array
    pose: Array
    true_points: Array
    outlier: Array
    view: Array
    noise: Array
    bias: Array
    viewpoints: Array
    num_tried: int

    def __init__(self, values: Dict[str, Any]) -> None:
        self.__dict__.update(values)

    def __repr__(self) -> str:
        return f"<darboux.Scan: {len(self.points)} points, {(self.outlier > 0).sum()} outliers>"

    def save(self, file: Path, normals: bool = False) -> None:
        """Writes the points, and normals, as .csv or .ply."""
        write_points(file, self.points, self.normals if normals else None)


class Fit:
    """A scan registered with a shell, and where asked for the shell's deformation fitted to it."""

    def __init__(self, handle: Any) -> None:
        self._fit = handle

    def __repr__(self) -> str:
        return f"<darboux.Fit: {self.verdict}>"

    @property
    def converged(self) -> bool:
        """Whether the scan was matched, and the fit, where asked for, came down to the noise."""
        return self._fit.converged

    @property
    def matched(self) -> bool:
        """Whether there is a pose, with distances and feet."""
        return self._fit.matched

    @property
    def verdict(self) -> str:
        """How good it is, or why there is no match; one line."""
        return self._fit.verdict

    @property
    def report(self) -> str:
        """What darboux_fit prints."""
        return self._fit.report

    @functools.cached_property
    def summary(self) -> Dict[str, Any]:
        """The contents of fit.json."""
        return self._fit.summary()

    @property
    def pose(self) -> Array:
        """(4, 4) rigid motion from the scan's frame into the shell's."""
        return self._fit.pose

    @functools.cached_property
    def distances(self) -> Array:
        """(k,) signed distances of the scan's points from the face, > 0 outside."""
        return self._fit.distances()

    @functools.cached_property
    def inliers(self) -> Array:
        """(k,) bool: points that count."""
        return self._fit.inliers()

    @functools.cached_property
    def feet(self) -> Array:
        """(k, 3) points of the face nearest to the scan's."""
        return self._fit.feet()

    @functools.cached_property
    def _shape(self) -> Dict[str, Array]:
        return self._fit.shape()

    @property
    def points(self) -> Array:
        """(n, 3) rest positions on the middle surface, as of Result."""
        return self._shape["points"]

    @property
    def triangles(self) -> Array:
        """(m, 3) int32 rows of points."""
        return self._shape["triangles"]

    @property
    def displacement(self) -> Array:
        """(n, 3) of the fitted shape; of register(): of the one the scan was held against."""
        return self._shape["displacement"]

    @property
    def normal(self) -> Array:
        """(n, 3) unit normals of the deformed middle surface."""
        return self._shape["normal"]

    @property
    def deformed(self) -> Array:
        """(n, 3) points + displacement."""
        return self.points + self.displacement

    def write(self, folder: Path, report: bool = False) -> List[str]:
        """Writes the files of darboux_fit: fit.json and, where matched, shell.vtu with the map of
        errors, deformed.ply and scan_registered.ply; with report also report.html (see
        Result.write). Returns their names; OSError."""
        return self._fit.write(os.fspath(folder), bool(report))


for _class in (Scan, Fit):
    _class.__module__ = "darboux"
for _function in (read_points, write_points):
    _function.__module__ = "darboux"
