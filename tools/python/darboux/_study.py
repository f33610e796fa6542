"""What accuracy costs."""

from __future__ import annotations

import functools
import os
from typing import Any, Dict, List, Union


class Study:
    """One scene solved with many settings, its errors against the time taken."""

    def __init__(self, handle: Any) -> None:
        self._study = handle

    def __repr__(self) -> str:
        return f"<darboux.Study: {len(self.runs)} runs>"

    @property
    def established(self) -> bool:
        """Whether there is a reference, and a run with an error."""
        return self._study.established

    @property
    def report(self) -> str:
        """What darboux_accuracy prints: a table and the cheapest settings."""
        return self._study.report

    @functools.cached_property
    def summary(self) -> Dict[str, Any]:
        """The contents of accuracy.json."""
        return self._study.summary()

    @property
    def runs(self) -> List[Dict[str, Any]]:
        """Of each run: label, status, settings, dof, error (None where unknown), values, time_s."""
        return self.summary["runs"]

    def write(self, folder: Union[str, "os.PathLike[str]"]) -> None:
        """Writes accuracy.csv, accuracy.json and accuracy.svg; OSError."""
        self._study.write(os.fspath(folder))


Study.__module__ = "darboux"
