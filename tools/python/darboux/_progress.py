"""Progress, and what all long calls have in common."""

from __future__ import annotations

import types
from typing import Any, Callable, Dict, Optional, TypeVar

from ._errors import NotConverged

T = TypeVar("T")


class Progress(types.SimpleNamespace):
    """What a `progress` function is called with, soon after it happened. `kind` says what it is:

    "iteration"  in every iteration: method ("linear", "mixed", "ceres", "cg", "path"), step (from
                 1) of steps, load_factor under way to, iteration (from 0 in every solution), total,
                 energy and relative_gradient of the state it starts from, seconds since the
                 beginning
    "step"       after each load step: step of steps, load_factor, iterations, energy,
                 relative_gradient, max_displacement, seconds, converged
    "level"      after each lattice on the way to model.accuracy: divisions ((0, 0) on meshes), dof,
                 theory, estimate (of the relative error, or None), seconds
    "fit_iteration", "weight"  of Scene.fit, in every iteration at a weight, and at its end: trial
                 (of weights, from 1), weight, iteration, misfit, seconds
    "run"        of Scene.accuracy_study: text, done, planned, seconds_left (a guess)
    "line"       of calibrate, what begins now: text
    "calibration_iteration"  of calibrate: iteration, cost, parameters (dict), seconds, seconds_left
                 (a guess, or None), text

    A progress function that returns False (not None) stops the work, as stop=... does; one that
    raises stops it, and the exception goes on to the caller.
    """


Progress.__module__ = "darboux"

ProgressFunction = Optional[Callable[[Progress], Any]]


def as_keywords(progress: ProgressFunction) -> Optional[Callable[..., Any]]:
    if progress is None:
        return None
    call = progress
    return lambda **values: call(Progress(**values))


def given(**options: Any) -> Dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def run(call: Callable[[], Any], wrap: Callable[[Any], T]) -> T:
    """wrap(call()); what an interrupt leaves of it becomes the exception's attribute `result`."""
    try:
        return wrap(call())
    except BaseException as error:
        rest = getattr(error, "__dict__", {}).pop("solution", None)
        if rest is not None:
            error.result = wrap(rest)  # type: ignore[attr-defined]
        raise


def checked(result: T, converged: bool, message: str, check: bool) -> T:
    if check and not converged:
        raise NotConverged(message, result)
    return result
