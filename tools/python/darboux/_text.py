"""Python's objects as the YAML that the readers of scenes and calibrations read."""

from __future__ import annotations

import json
import os
import re
from typing import Any, Dict, List, Tuple

import numpy as np

from ._errors import InputError

# (vertices, faces) by the name that stands in place of a file's.
Meshes = Dict[str, Tuple[Any, Any]]


def plain(value: Any, path: str) -> Any:
    """Dicts with text keys, lists, texts, numbers, booleans and None; InputError for all else."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    elif isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "keys"):
        result = {}
        for key in value.keys():
            if not isinstance(key, str):
                raise InputError(f"{path or 'scene'}: found the key {key!r}; allowed texts as keys")
            result[key] = plain(value[key], f"{path}.{key}" if path else key)
        return result
    if isinstance(value, (list, tuple, range)):
        return [plain(item, f"{path}[{i}]") for i, item in enumerate(value)]
    raise InputError(
        f"{path or 'scene'}: found an object of type {type(value).__name__}; "
        "allowed dicts, lists, numbers, texts, booleans and numpy arrays of these"
    )


def _take_mesh(part: Any, path: str, meshes: Meshes) -> Any:
    """A map of kind mesh with arrays instead of a file as one with the name of a file."""
    if not hasattr(part, "keys") or not ("vertices" in part or "faces" in part):
        return part
    if "file" in part:
        raise InputError(f"{path}: found file beside vertices and faces; allowed one or the other")
    for key, columns in (("vertices", "x, y, z"), ("faces", "rows of vertices, from 0")):
        if key not in part:
            raise InputError(f"{path}.{key}: found no such key; allowed an (n, 3) array, {columns}")
    name = f"<{path}>"
    meshes[name] = (part["vertices"], part["faces"])
    rest = {key: part[key] for key in part.keys() if key not in ("vertices", "faces")}
    rest["file"] = name
    return rest


def plain_scene(data: Any, meshes: Meshes) -> Any:
    """A scene whose meshes are named; the meshes go into `meshes`."""
    data = dict(data)
    if "surface" in data:
        data["surface"] = _take_mesh(data["surface"], "surface", meshes)
    fingers = data.get("fingers")
    if isinstance(fingers, (list, tuple)):
        taken: List[Any] = []
        for i, finger in enumerate(fingers):
            if hasattr(finger, "keys") and "shape" in finger:
                finger = dict(finger)
                finger["shape"] = _take_mesh(finger["shape"], f"fingers[{i}].shape", meshes)
            taken.append(finger)
        data["fingers"] = taken
    return plain(data, "")


def number(value: float) -> str:
    if value != value:
        return ".nan"
    if value in (float("inf"), float("-inf")):
        return ".inf" if value > 0 else "-.inf"
    return repr(value)


def flow(value: Any) -> str:
    """What `plain` gives, in one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{quoted(k)}: {flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(flow(item) for item in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return number(value)
    if isinstance(value, int):
        return str(value)
    return "null" if value is None else quoted(value)


def quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


_BARE = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*( [A-Za-z0-9_./-]+)*")
_MEANS_SOMETHING = {"true", "false", "null"}
_WIDTH = 96


def _scalar(value: Any) -> str:
    if isinstance(value, str) and _BARE.fullmatch(value) and value.lower() not in _MEANS_SOMETHING:
        return value
    return flow(value)


def _short(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_scalar(k)}: {_short(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_short(item) for item in value) + "]"
    return _scalar(value)


def block(value: Dict[str, Any]) -> str:
    """What `plain` gives, a map, in lines that people read: short parts in one line each."""
    return "".join(_entry(key, item, 0) for key, item in value.items())


def _entry(key: str, value: Any, indent: int) -> str:
    head = " " * indent + _scalar(key) + ":"
    line = f"{head} {_short(value)}"
    is_list_of_maps = isinstance(value, list) and any(isinstance(item, dict) for item in value)
    if not isinstance(value, (dict, list)) or not value:
        return line + "\n"
    if len(line) <= _WIDTH and not is_list_of_maps:
        return line + "\n"
    if isinstance(value, dict):
        parts = [_entry(name, item, indent + 2) for name, item in value.items()]
    else:
        parts = [_item(item, indent + 2) for item in value]
    return head + "\n" + "".join(parts)


def _item(value: Any, indent: int) -> str:
    line = " " * indent + "- " + _short(value)
    if len(line) <= _WIDTH or not isinstance(value, dict) or not value:
        return line + "\n"
    entries = "".join(_entry(name, item, indent + 2) for name, item in value.items())
    return " " * indent + "- " + entries[indent + 2 :]
