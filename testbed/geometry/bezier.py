"""Bezier patches in batches: triangles of any degree, rational triangles, tensor-product patches.

Samples shared by all patches: one matrix product, a table of Bernstein polynomials and their derivatives times the
control points. The rows of the table and the columns of the control points are padded to whole blocks of the BLAS
kernels, because those round differently at ragged ends: so a patch has the same bits whatever it is evaluated with, and
so has a sample. Samples of their own for each patch: the de Casteljau algorithm, element by element.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from testbed.geometry.bernstein import casteljau_step, tensor_tables, triangle_degree, triangle_tables
from testbed.geometry.domain import barycentric
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Bool, Float, Int, as_float

# whole blocks of every OpenBLAS kernel tried (x86-64 from SSE2 to AVX-512, one thread and two)
_ROW_BLOCK = 16
_PATCH_BLOCK = 16


def _frozen(values: Any) -> Float:
    array: Float = as_float(values).view()
    array.flags.writeable = False
    return array


def apply_table(table: Float, nets: Float) -> Float:
    """Table (rows, S, n) times nets (P, n, dim), to a view (rows, P, S, dim) of component-planar memory."""
    rows, samples, n = table.shape
    patches, _, dim = nets.shape
    padded_table = np.zeros((-(-rows * samples // _ROW_BLOCK) * _ROW_BLOCK, n))
    padded_table[: rows * samples] = table.reshape(rows * samples, n)
    padded = -(-patches // _PATCH_BLOCK) * _PATCH_BLOCK
    columns = np.zeros((n, dim, padded))
    columns[..., :patches] = nets.transpose(1, 2, 0)
    with np.errstate(invalid="ignore", over="ignore"):  # a patch that is not finite stays so, for the caller to find
        product = padded_table @ columns.reshape(n, dim * padded)
    planar = product[: rows * samples].reshape(rows, samples, dim, padded)[..., :patches]
    return planar.transpose(0, 3, 1, 2)


def _triangle_casteljau(nets: Float, at: Float, order: int) -> Float:
    """Jets of nets (P, n, dim) at each patch's own points (P, S, 2), to (rows, P, S, dim)."""
    degree = triangle_degree(nets.shape[1])
    b = barycentric(at)
    with np.errstate(invalid="ignore", over="ignore"):
        levels = [np.broadcast_to(nets[:, None], (*at.shape[:2], *nets.shape[1:]))]
        for _ in range(degree):
            levels.append(casteljau_step(levels[-1], b))
        result = np.zeros((ROWS[order], *at.shape[:2], nets.shape[-1]))
        result[0] = levels[degree][..., 0, :]
        if order >= 1 and degree >= 1:
            p0, p1, p2 = np.moveaxis(levels[degree - 1], -2, 0)
            result[1], result[2] = degree * (p1 - p0), degree * (p2 - p0)
        if order >= 2 and degree >= 2:
            q00, q01, q02, q11, q12, q22 = np.moveaxis(levels[degree - 2], -2, 0)
            result[3] = q11 - 2.0 * q01 + q00
            result[4] = (q12 - q02) - (q01 - q00)
            result[5] = q22 - 2.0 * q02 + q00
            result[3:] *= degree * (degree - 1)
    return result


def _triangle_jets(nets: Float, at: Float, order: int) -> Float:
    if at.ndim == 2:
        return apply_table(triangle_tables(triangle_degree(nets.shape[1]), at, order), nets)
    return _triangle_casteljau(nets, at, order)


@dataclass(frozen=True, eq=False)
class BezierTriangles(PatchBatch):
    """Polynomial Bezier triangles of one degree.

    Parameters
    ----------
    control_points
        (P, n, 3), n = (d + 1)(d + 2) / 2, multi-indices by decreasing i, then decreasing j (see
        :mod:`testbed.geometry.bernstein`).
    """

    control_points: Float
    sides: ClassVar[int] = 3

    def __post_init__(self) -> None:
        points = _frozen(self.control_points)
        if points.ndim != 3 or points.shape[-1] != 3:
            raise ValueError(f"control points of triangles are (P, n, 3), not {points.shape}")
        triangle_degree(points.shape[1])
        object.__setattr__(self, "control_points", points)

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def degree(self) -> int:
        """Degree of the patches."""
        return triangle_degree(self.control_points.shape[1])

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets`."""
        return Jet(_triangle_jets(self.control_points, at, order))

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.control_points[patches])

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate is finite."""
        return np.asarray(np.isfinite(self.control_points).all(axis=(1, 2)))


@dataclass(frozen=True, eq=False)
class RationalBezierTriangles(PatchBatch):
    """Rational Bezier triangles of one degree, sum w B P / sum w B.

    Parameters
    ----------
    control_points
        (P, n, 3) in space.
    weights
        (P, n).
    """

    control_points: Float
    weights: Float
    sides: ClassVar[int] = 3

    def __post_init__(self) -> None:
        points, weights = _frozen(self.control_points), _frozen(self.weights)
        if points.ndim != 3 or points.shape[-1] != 3 or weights.shape != points.shape[:2]:
            raise ValueError(
                f"rational triangles need control points (P, n, 3) and weights (P, n), "
                f"not {points.shape} and {weights.shape}"
            )
        triangle_degree(points.shape[1])
        object.__setattr__(self, "control_points", points)
        object.__setattr__(self, "weights", weights)

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def degree(self) -> int:
        """Degree of numerator and denominator."""
        return triangle_degree(self.control_points.shape[1])

    @property
    def homogeneous(self) -> Float:
        """Control points (w x, w y, w z, w), (P, n, 4)."""
        return np.concatenate([self.control_points * self.weights[..., None], self.weights[..., None]], axis=-1)

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets`."""
        return Jet(project(_triangle_jets(self.homogeneous, at, order)))

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.control_points[patches], self.weights[patches])

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate and weight is finite."""
        return np.asarray(np.isfinite(self.homogeneous).all(axis=(1, 2)))


def project(homogeneous: Float) -> Float:
    """Jets (rows, ..., 4) in homogeneous coordinates (w f, w) to jets (rows, ..., 3) of f, by the quotient rule."""
    a, w = homogeneous[..., :3], homogeneous[..., 3:]
    f = np.empty_like(a)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # a vanishing denominator is NaN or infinite
        f[0] = a[0] / w[0]
        if len(a) >= 3:
            for r in (1, 2):
                f[r] = (a[r] - w[r] * f[0]) / w[0]
        if len(a) == 6:
            for row, (r, s) in zip((3, 4, 5), ((1, 1), (1, 2), (2, 2)), strict=True):
                f[row] = (a[row] - w[r] * f[s] - w[s] * f[r] - w[row] * f[0]) / w[0]
    return f


@dataclass(frozen=True, eq=False)
class BezierQuads(PatchBatch):
    """Tensor-product Bezier patches of one bidegree over the unit square.

    Parameters
    ----------
    control_points
        (P, m + 1, n + 1, 3): axis 1 along u, axis 2 along v.
    """

    control_points: Float
    sides: ClassVar[int] = 4

    def __post_init__(self) -> None:
        points = _frozen(self.control_points)
        if points.ndim != 4 or points.shape[-1] != 3 or 0 in points.shape[1:3]:
            raise ValueError(f"control points of tensor-product patches are (P, m + 1, n + 1, 3), not {points.shape}")
        object.__setattr__(self, "control_points", points)

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def degree(self) -> tuple[int, int]:
        """Degrees (m, n) along u and v."""
        return self.control_points.shape[1] - 1, self.control_points.shape[2] - 1

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at (S, 2) or (P, S, 2); see :meth:`PatchBatch.jets`."""
        table = tensor_tables(self.degree, at, order)
        nets = self.control_points.reshape(len(self), -1, 3)
        table = table.reshape(*table.shape[:-2], -1)
        if at.ndim == 2:
            return Jet(apply_table(table, nets))
        result = np.zeros((*table.shape[:-1], 3))
        with np.errstate(invalid="ignore", over="ignore"):
            for place in range(nets.shape[1]):
                result += table[..., place, None] * nets[:, place, None, :]
        return Jet(result)

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.control_points[patches])

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate is finite."""
        return np.asarray(np.isfinite(self.control_points).all(axis=(1, 2, 3)))
