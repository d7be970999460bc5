"""An approximation on disk: its history as a table, how it came about as JSON, the mesh and its levels as arrays."""

import csv
import dataclasses
import io
import json
import math
import os
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from testbed.approximation.history import Approximation, Step
from testbed.geometry.mesh_arrays import mesh_arrays
from testbed.harness.journal import write_whole


def write_approximation(directory: Path, found: Approximation, origin: Mapping[str, Any]) -> tuple[Path, ...]:
    """Write ``history.csv``, ``approximation.json`` and ``mesh.npz``, each whole or not at all; return their paths.

    Parameters
    ----------
    directory
        Where; made if it does not exist.
    found
        The approximation.
    origin
        What it came from: dataset, scheme, bounds, versions and the like.
    """
    directory.mkdir(parents=True, exist_ok=True)
    paths = tuple(directory / name for name in ("history.csv", "approximation.json", "mesh.npz"))
    write_whole(paths[0], history_table(found))
    write_whole(paths[1], json.dumps({**origin, **outcome(found)}, indent=1) + "\n")
    _write_bytes(paths[2], arrays(found))
    return paths


def history_table(found: Approximation) -> str:
    """Return the history as CSV, a row a mesh."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [field.name for field in dataclasses.fields(Step)]
    writer.writerow(names)
    for step in found.history:
        values = [getattr(step, name) for name in names]
        # an empty field for a number that is not there, as in results.csv
        writer.writerow(
            ["" if value is None or (isinstance(value, float) and math.isnan(value)) else value for value in values]
        )
    return text.getvalue()


def outcome(found: Approximation) -> dict[str, Any]:
    """Return how it ended and the history, as JSON has it."""
    history = [{name: plain(value) for name, value in dataclasses.asdict(step).items()} for step in found.history]
    levels = np.bincount(found.levels.faces).tolist()
    return {
        "reached": found.reached,
        "stop": found.stop,
        "reason": found.reason,
        "faces_by_level": levels,
        "notes": dict(found.surface.notes) if found.surface else {},
        "history": history,
    }


def plain(value: Any) -> Any:
    """Return a value as JSON has it, without NaN and infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def arrays(found: Approximation) -> dict[str, Any]:
    """Return the mesh with its data, its levels and what was measured on it, and the control points of the patches.

    ``testbed.load_mesh`` reads the mesh.

    ``control_points_0``, ``patch_faces_0`` and so on for each part of the surface that has control points.
    """
    mesh, surface = found.mesh, found.surface
    result: dict[str, Any] = {
        **mesh_arrays(mesh),
        "edges": mesh.edges,
        "face_levels": found.levels.faces,
        "edge_levels": found.levels.edges,
        "edge_jumps_deg": found.edge_jumps_deg,
        "face_distances": found.face_distances,
    }
    for number, part in enumerate(surface.parts if surface else ()):
        for name in ("control_points", "weights"):
            values = getattr(part.batch, name, None)
            if isinstance(values, np.ndarray):
                result[f"{name}_{number}"] = values
                result[f"patch_faces_{number}"] = part.faces
    return result


def _write_bytes(path: Path, values: Mapping[str, Any]) -> None:
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{secrets.token_hex(4)}")
    try:
        with temporary.open("wb") as file:
            np.savez_compressed(file, **values)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
