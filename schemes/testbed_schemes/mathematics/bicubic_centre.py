"""The inner control points of a bicubic patch from second-order data at its corners and at its centre.

Split at (1/2, 1/2), a patch has next to its centre p the control points t1 and t2, the neighbours of p along v and u,
c1 and c2 beyond them, and m between t1 and t2 (:data:`~testbed_schemes.mathematics.bicubic_nets.QUARTER`). With unit
normals and II(u, v) = -<D_uv S, n>,

    <C11 - C00, N00> = -II00(C10 - C00, C01 - C00), and likewise at the other corners,                 (4.4) to (4.7)
    C(1/2, 1/2) = p,    <t1 - p, N> = <t2 - p, N> = 0,                                                 (4.2), (4.3)
    <m - t1, N> = -II(t1 - p, t2 - p),                                                                 (4.8)
    2 <c1 - 2 t1 + p, N> = -3 II(t1 - p, t1 - p), and likewise c2, t2                                  (4.9), (4.10)

(Mann 1992, chapter 4): nine linear equations and three quadrics for the twelve coordinates of C11, C12, C21, C22.
**Corrected**: the signs of the right-hand sides, printed for the opposite sign of II, and the known sides of (4.3): the
last row of the matrix for z(t1) is 1 2 1 0, and the rows of that for z(t2) are 1 3 3 1, 2 0 0 2, 1 0 0 1, 0 0 0 0.

Unknown are the offsets from the zero-twist points, in units of the face's size. The nine equations leave three of them
free, an affine space with an orthonormal basis about its point nearest to the zero-twist points, in which distances are
those of the control points.

On short edges the system is nearly singular, whatever the surface: on the paraboloid over a parallelogram a
two-parameter family of parametrisations satisfies all twelve equations to first order, so that four of the eight roots
come together at it, at distances of order h from each other, relative to the face. Whether any of them is real is a
matter of the surface's fourth derivatives, not of the edge length.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from testbed.geometry.face_data import Centres
from testbed.geometry.vectors import Bool, Float, Int, dot, norm
from testbed_schemes.mathematics.bicubic_nets import QUARTER, I, J
from testbed_schemes.mathematics.three_quadrics import real_roots

#: Singular values of the nine equations below this, relative to the largest, count as zero. On a smooth surface four
#: are of order h, the edge length times the curvature, by which the tangent planes at corners and centre differ.
CUTOFF = 1e-8
#: Roots are equally near to the zero-twist points if their distances differ by less than this, relatively. On a face
#: with a plane of symmetry they come in mirror images, known to a part of their digits only, four roots being close.
TIE = 1e-4
#: A quadric smaller than this, in units of the face's size, is rounding of coordinates and no condition.
ROUNDING = 64.0 * float(np.finfo(np.float64).eps)


class Branch(IntEnum):
    """How the inner control points of a face were found."""

    ONE_ROOT = 0
    NEAREST_ROOT = 1
    TIED_ROOTS = 2
    NO_ROOT = 3
    SINGULAR = 4


@dataclass(frozen=True)
class CentreSystem:
    """Nine linear equations and three quadrics of F faces, in the offsets of the inner control points.

    Parameters
    ----------
    linear
        (F, 9, 13) coefficients, the constant first: position, tangent plane and the four corners.
    tangents
        (F, 2, 3, 13): t1 - p and t2 - p.
    heights
        (F, 3, 13): 2 <c1 - 2 t1 + p, N> / 3, 2 <c2 - 2 t2 + p, N> / 3 and <m - t1, N>.
    second_forms
        (F, 3, 3) at the centre, times the size.
    """

    linear: Float
    tangents: Float
    heights: Float
    second_forms: Float

    @classmethod
    def of(cls, net: Float, corner_normals: Float, centres: Centres, size: Float) -> "CentreSystem":
        """Set up the equations.

        Parameters
        ----------
        net
            (F, 4, 4, 3) nets whose inner control points satisfy the corner equations: offsets are from them.
        corner_normals
            (F, 4, 3) at the corners next to the inner control points.
        centres
            Samples at the centres.
        size
            (F,) the unit of the offsets.
        """
        N, p = centres.normals, centres.points
        from_centre = (net - p[:, None, None]) / size[:, None, None, None]

        def point(name: str) -> Float:
            """A control point of the quarter, from p, (F, 3, 13)."""
            weights = QUARTER[name]
            constant = np.einsum("ij,fijx->fx", weights, from_centre)
            moved = np.broadcast_to(np.kron(weights[I, J], np.eye(3)), (len(net), 3, 12))
            return np.concatenate([constant[:, :, None], moved], axis=2)

        centre, t1, t2, c1, c2, m = (point(name) for name in ("p", "t1", "t2", "c1", "c2", "m"))
        corners = np.zeros((len(net), 4, 13))
        for k in range(4):
            corners[:, k, 1 + 3 * k : 4 + 3 * k] = QUARTER["p"][I[k], J[k]] * corner_normals[:, k]
        plane = np.einsum("fx,tfxk->ftk", N, np.stack([t1, t2]))
        bends = np.stack([(c1 - 2.0 * t1) * (2.0 / 3.0), (c2 - 2.0 * t2) * (2.0 / 3.0), m - t1])
        return cls(
            np.concatenate([centre, plane, corners], axis=1),
            np.stack([t1, t2], axis=1),
            np.einsum("fx,qfxk->fqk", N, bends),
            centres.second_forms * size[:, None, None],
        )

    def solved_linearly(self) -> tuple[Float, Bool]:
        """Affine maps (F, 13, 4) from (1, y) to (1, offsets) that solve the nine equations; where those are regular.

        The map's columns are orthogonal, those of y orthonormal: the offsets at y = 0 are the shortest.
        """
        left, sizes, right = np.linalg.svd(self.linear[:, :, 1:])
        regular: Bool = np.greater(sizes[:, -1], CUTOFF * sizes[:, 0])
        components = -np.einsum("fji,fj->fi", left, self.linear[:, :, 0]) / np.where(regular[:, None], sizes, 1.0)
        result = np.zeros((len(left), 13, 4))
        result[:, 0, 0] = 1.0
        result[:, 1:, 0] = np.einsum("fji,fj->fi", right[:, :9], components)
        result[:, 1:, 1:] = right[:, 9:].swapaxes(1, 2)
        return result, regular

    def quadrics(self, affine: Float) -> Float:
        """Quadrics (F, 3, 4, 4) in (1, y): (4.9), (4.10), (4.8)."""
        tangents = np.einsum("ftxk,fkl->ftxl", self.tangents, affine)
        heights = np.einsum("fqk,fkl->fql", self.heights, affine)
        bent = np.einsum("fxy,ftyl->ftxl", self.second_forms, tangents)
        pairs = [np.einsum("fxk,fxl->fkl", tangents[:, a], bent[:, b]) for a, b in ((0, 0), (1, 1), (0, 1))]
        result = np.stack(pairs, axis=1)
        result[:, :, 0] += heights
        symmetric: Float = 0.5 * (result + result.swapaxes(2, 3))
        return symmetric


def inner_points(net: Float, corner_normals: Float, centres: Centres, size: Float, reach: float) -> tuple[Float, Int]:
    """Inner control points (F, 4, 3) with which the patches match the samples at their centres, and the branch taken.

    Parameters
    ----------
    net
        (F, 4, 4, 3) nets with zero-twist points inside.
    corner_normals
        (F, 4, 3) at the corners next to the inner control points.
    centres
        Samples at the centres.
    size
        (F,) sizes of the faces.
    reach
        Roots whose offsets are longer than this, in sizes, do not count.

    Returns
    -------
    points
        Those of the root nearest to the zero-twist points; the mean of roots that are equally near, which solves the
        linear equations; without a root the solution of the linear equations that is nearest to the zero-twist points;
        these themselves where the linear equations are singular.
    branch
        (F,) :class:`Branch`.
    """
    system = CentreSystem.of(net, corner_normals, centres, size)
    affine, regular = system.solved_linearly()
    noise = ROUNDING * (1.0 + np.abs(centres.points).max(axis=1) / size)
    with np.errstate(
        over="ignore", invalid="ignore"
    ):  # second forms of any size: a system that is not finite has no root
        quadrics = system.quadrics(affine)
        sizes = np.abs(quadrics).max(axis=(2, 3), keepdims=True)
    roots = real_roots(np.where(sizes <= noise[:, None, None, None], 0.0, quadrics))
    # NaN after the last root
    distance = np.sqrt(dot(affine[:, 1:, 0], affine[:, 1:, 0])[:, None] + dot(roots, roots))
    roots[~(distance <= reach)] = np.nan
    away = norm(roots)
    found = np.isfinite(away)
    nearest = found & (away <= away[:, :1] * (1.0 + TIE) + TIE**2)
    y = np.where(nearest[..., None], roots, 0.0).sum(axis=1) / np.maximum(nearest.sum(axis=1), 1)[:, None]
    offsets = affine[:, 1:, 0] + np.einsum("fik,fk->fi", affine[:, 1:, 1:], y)
    offsets = np.where(regular[:, None], offsets * size[:, None], 0.0)
    branch = np.select(
        [~regular, ~found[:, 0], nearest[:, 1], found[:, 1]],
        [Branch.SINGULAR, Branch.NO_ROOT, Branch.TIED_ROOTS, Branch.NEAREST_ROOT],
        Branch.ONE_ROOT,
    )
    return net[:, I, J] + offsets.reshape(-1, 4, 3), branch.astype(np.int64)
