"""What a scheme's surfaces are made of and what they cost: patches, degree, stored numbers, time of an evaluation."""

import dataclasses
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from testbed.conformance.meshes import cases, torus
from testbed.errors import Refused
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.domain import lattice
from testbed.geometry.patches import PatchBatch
from testbed.geometry.surface import Surface
from testbed.plugins.scheme import Scheme

#: Patches in a timed evaluation.
PATCHES: Final = 256
#: Rounds of the timing, of which the quickest counts.
ROUNDS: Final = 7


@dataclass(frozen=True)
class PatchKind:
    """Patches of one kind in a scheme's surface.

    Parameters
    ----------
    kind
        What they are, in words.
    degree
        Polynomial degree, or None.
    control_points
        Control points of one patch, or None where it has none.
    per_face
        Patches over a face, on average.
    """

    kind: str
    degree: int | None
    control_points: int | None
    per_face: float


@dataclass(frozen=True)
class Profile:
    """What a scheme's surfaces are made of.

    Parameters
    ----------
    mesh
        The mesh it was looked at on.
    kinds
        The kinds of patches.
    control_points
        Control points over a face, or None where some patches have none.
    numbers
        Floating-point numbers stored over a face.
    cost
        Time of a second-order jet at one point, over that of a cubic Bezier triangle, measured here and now to two
        digits; both on many patches at the same points.
    """

    mesh: str
    kinds: tuple[PatchKind, ...]
    control_points: float | None
    numbers: float
    cost: float


def profile(scheme: Scheme) -> Profile | None:
    """Return the profile of a scheme on a coarse torus, or on the first mesh of the suite that it takes, or None.

    A scheme that raises anything but Refused has no profile; what it raised is a failure of its checks.
    """
    sides = scheme.domain[0]
    for name, mesh in (("torus", torus(16, 10, sides)), *((case.name, case.mesh) for case in cases(sides))):
        try:
            surface = scheme.fit(mesh)
        except Refused:
            continue
        except Exception:  # noqa: BLE001 - the checks meet it too, and tell
            return None
        kinds = _kinds(surface)
        points = [None if one.control_points is None else one.control_points * one.per_face for one in kinds]
        numbers = sum(_numbers(batch) for batch in surface.batches) / len(mesh.faces)
        stored = None if None in points else float(sum(one for one in points if one is not None))
        return Profile(name, kinds, stored, numbers, relative_cost(surface))
    return None


def _kinds(surface: Surface) -> tuple[PatchKind, ...]:
    counts: Counter[tuple[str, int | None, int | None]] = Counter()
    for batch in surface.batches:
        net = getattr(batch, "control_points", None)
        points = None if net is None else int(np.prod(np.shape(net)[1:-1]))
        counts[batch.kind, getattr(batch, "degree", None), points] += len(batch)
    faces = len(surface.mesh.faces)
    return tuple(PatchKind(*key, count / faces) for key, count in sorted(counts.items(), key=str))


def _numbers(batch: PatchBatch) -> int:
    """Numbers in the arrays of a batch that have an entry a patch."""
    names = [one.name for one in dataclasses.fields(batch)] if dataclasses.is_dataclass(batch) else list(vars(batch))
    values: list[Any] = [getattr(batch, name) for name in names]
    arrays = [one for value in values for one in (value.values() if isinstance(value, Mapping) else [value])]
    return sum(one.size for one in arrays if isinstance(one, np.ndarray) and one.ndim and len(one) == len(batch))


def relative_cost(surface: Surface) -> float:
    """Return the time of a jet of the surface's patches over that of a cubic Bezier triangle, to two digits."""
    at = lattice(3, 9)
    reference = BezierTriangles(np.random.default_rng(1).normal(size=(PATCHES, 10, 3)))
    total = sum(len(batch) for batch in surface.batches)
    cubic = _seconds(reference, at)
    weighted = 0.0
    for batch in surface.batches:
        places = at if batch.sides == 3 else lattice(4, 6)
        many = batch.take(np.arange(PATCHES) % len(batch))
        weighted += len(batch) / total * _seconds(many, places) / len(places)
    return float(f"{weighted * len(at) / cubic:.2g}")


def _seconds(batch: PatchBatch, at: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    """Return the time of second-order jets of a batch, the least of several."""
    spent = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        batch.jets(at, 2)
        spent.append(time.perf_counter() - start)
    return min(spent)
