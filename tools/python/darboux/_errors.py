"""What can go wrong."""

from __future__ import annotations

from typing import Any

from ._darboux import InputError

InputError.__module__ = "darboux"
InputError.__doc__ = """Bad input: a scene, a file, an option. A ValueError.

The message is one line and names the key or argument, what was found and what is allowed, e.g.
"shell.poisson_ratio: found 0.7; allowed a number in (-1, 0.5]"; for scenes that were loaded from a
file and not changed since, file and line as well.
"""


class NotConverged(RuntimeError):
    """Raised by check=True where a solution has not converged. `result` is what there is of it."""

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message)
        self.result = result


NotConverged.__module__ = "darboux"
