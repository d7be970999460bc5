"""Random pairs of patches along an edge, as Bernstein coefficients, and their normals in extended precision."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from testbed.geometry.bernstein import elevate_curve
from testbed.geometry.normal_fields import NormalFields
from testbed.geometry.normal_pairs import NormalPairs
from testbed.geometry.polynomials import basis
from testbed.geometry.vectors import Float

#: Kinds of pairs, see :func:`pairs`.
FAMILIES = ("wild", "uneven", "bent", "hermite", "nearly smooth", "with a gap", "rounded")
#: Degrees of H', F and G: cubic, quartic, quintic triangles, bicubic patches, a cubic beside a bicubic one, quadratics.
DEGREES = ((2, 2, 2), (3, 3, 3), (4, 4, 4), (2, 3, 3), (2, 2, 3), (1, 1, 1))


@dataclass(frozen=True)
class PatchPairs:
    """Derivatives (k, 3, E) along an edge, H' on both sides, and into the patches F on its left and G on its right."""

    left: Float
    right: Float
    into_left: Float
    into_right: Float

    def normals(self) -> NormalPairs:
        one = NormalFields.of_derivatives(self.left, self.into_left)
        other = NormalFields.of_derivatives(-self.right[::-1], self.into_right[::-1])
        return NormalPairs.of(one, other.reversed())

    def __getitem__(self, chosen: Any) -> "PatchPairs":
        return PatchPairs(*(field[..., chosen] for field in self.fields))

    @property
    def fields(self) -> tuple[Float, Float, Float, Float]:
        return self.left, self.right, self.into_left, self.into_right

    def turned(self) -> "PatchPairs":
        """The same edges run the other way, so that left is right."""
        return PatchPairs(-self.right[::-1], -self.left[::-1], self.into_right[::-1], self.into_left[::-1])

    def sampled(self, steps: int) -> Float:
        """Angles (steps + 1, E) at even parameters, in double precision."""
        t = np.arange(steps + 1) / steps
        values: list[Any] = []
        for field in self.fields:
            table = basis(len(field) - 1, t)
            values.append((table.T @ field.reshape(len(field), -1)).reshape(len(t), 3, -1))
        sampled: Float = angles(*values)
        return sampled

    def extended(self, t: Any) -> Any:
        """Angles (E,) at parameters (E,) in extended precision."""
        t = np.asarray(t, dtype=np.longdouble)
        values = []
        for field in self.fields:
            p = field.astype(np.longdouble)
            while len(p) > 1:
                p = (1 - t) * p[:-1] + t * p[1:]
            values.append(p[0])
        return angles(*values)

    def refined(self, t: Float, reach: float) -> Any:
        """Largest angles (E,) near parameters (E,) in extended precision."""
        at = np.asarray(t, dtype=np.longdouble)
        best = self.extended(at)
        for _ in range(6):
            centre = at
            for offset in (-1.0, -0.5, 0.5, 1.0):
                there = np.clip(centre + np.longdouble(offset * reach), 0, 1)
                value = self.extended(there)
                at, best = np.where(value > best, there, at), np.maximum(value, best)
            reach *= 0.5
        return best


def angles(left: Any, right: Any, into_left: Any, into_right: Any) -> Any:
    """Angles (..., E) from derivatives (..., 3, E)."""
    A, B = crossed(left, into_left), crossed(into_right, right)
    V = crossed(A, B)
    return np.arctan2(np.sqrt((V * V).sum(axis=-2)), (A * B).sum(axis=-2))


def crossed(a: Any, b: Any) -> Any:
    components = [a[..., k - 2, :] * b[..., k - 1, :] - a[..., k - 1, :] * b[..., k - 2, :] for k in range(3)]
    return np.stack(components, axis=-2)


def pairs(family: str, degrees: tuple[int, int, int], count: int, seed: int = 0) -> PatchPairs:
    """Random pairs of patches with H', F and G of some degrees.

    Families: ``wild``, without any order, folds and near-singular normals included; ``uneven``, the same with lengths
    from a thousandth to a thousand; ``bent``, where the patches lean to
    a common plane; ``hermite``, with common tangent planes at the ends; ``nearly smooth``, with angles of about 1e-7;
    ``with a gap``, with boundary curves that differ by a thousandth; ``rounded``, where they differ by rounding.
    """
    rng = np.random.default_rng([seed, *degrees, *family.encode()])
    T, F, G = (rng.normal(size=(degree + 1, 3, count)) for degree in degrees)
    right = T
    if family == "uneven":
        T, F, G = (field * 10.0 ** rng.uniform(-3.0, 3.0, size=(len(field), 1, count)) for field in (T, F, G))
        right = T
    elif family != "wild":
        plane = np.array([[1.0, 0.0, 0.0], [0.3, 1.0, 0.0], [0.2, -1.0, 0.0]])[:, None, :, None]
        T, F, G = (axis + 0.2 * field for axis, field in zip(plane, (T, F, G), strict=True))
        right = T
    if family == "hermite":
        for end in (0, -1):
            G[end] = 0.4 * T[end] - rng.uniform(0.5, 1.5, size=count) * F[end]
    if family == "nearly smooth":
        steps = [max(degrees) - degree for degree in degrees]
        T, F = (elevated(field, step) for field, step in zip((T, F), steps[:2], strict=True))
        right, G = T, 0.4 * T - F + 1e-7 * rng.normal(size=T.shape)
    if family == "with a gap":
        right = T + 1e-3 * rng.normal(size=T.shape)
    if family == "rounded":
        right = T * (1.0 + 2.0**-52 * rng.integers(-1, 2, size=T.shape))
    return PatchPairs(T, right, F, G)


def elevated(field: Float, steps: int = 1) -> Float:
    """The same field (k, 3, E) with more coefficients."""
    raised = elevate_curve(field.transpose(2, 0, 1), steps)
    as_rows: Float = raised.transpose(1, 2, 0)
    return as_rows
