"""Bézier patches as VTK's cells: their control points in VTK's order, with weights and degrees.

VTK orders the points of a cell of higher order by what they lie on: corners, then the inside of the sides as they run,
then the inside of the cell. Inside of a triangle there is a smaller triangle, ordered in the same way; inside of a quad
the points run along u first. The sides of a triangle run around it, those of a quad along u and along v.
"""

from dataclasses import dataclass
from functools import cache
from typing import Final, TypeGuard

import numpy as np

from testbed.errors import TestbedError
from testbed.geometry.bernstein import index_of
from testbed.geometry.bezier import BezierQuads, BezierTriangles, RationalBezierTriangles
from testbed.geometry.patches import PatchBatch
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int

#: Numbers of VTK's cell types.
BEZIER_TRIANGLE: Final = 76
BEZIER_QUADRILATERAL: Final = 77


@dataclass(frozen=True, eq=False)
class BezierCells:
    """The patches of a surface as cells; each has points of its own, so that no control point is rounded.

    Parameters
    ----------
    points
        (N, 3) control points, cell by cell.
    weights
        (N,) their weights; None where all patches are polynomial.
    offsets
        (C,) where the points of each cell end.
    types
        (C,) VTK's cell types.
    degrees
        (C, 3) degrees along u and v, and 0.
    part, face
        (C,) the part of the surface and the mesh face that each came from.
    """

    points: Float
    weights: Float | None
    offsets: Int
    types: Int
    degrees: Int
    part: Int
    face: Int


@cache
def triangle_order(degree: int) -> tuple[tuple[int, int, int], ...]:
    """Exponents (i, j, k) of b0, b1, b2 of the points of a triangle of the degree, in VTK's order.

    >>> triangle_order(2)
    ((2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (0, 1, 1), (1, 0, 1))
    """
    if degree < 0:
        return ()
    if degree == 0:
        return ((0, 0, 0),)
    corners = np.eye(3, dtype=np.int64)
    rows = [degree * corners]
    for side in range(3):
        step = np.arange(1, degree)[:, None]
        rows.append((degree - step) * corners[side] + step * corners[(side + 1) % 3])
    inner = [(i + 1, j + 1, k + 1) for i, j, k in triangle_order(degree - 3)]
    return (*((i, j, k) for i, j, k in np.concatenate(rows).tolist()), *inner)


@cache
def quad_order(m: int, n: int) -> tuple[tuple[int, int], ...]:
    """Places (i, j) along u and v of the points of a quad of degrees m and n, in VTK's order.

    >>> quad_order(2, 1)
    ((0, 0), (2, 0), (2, 1), (0, 1), (1, 0), (1, 1))
    """
    along_u, along_v = range(1, m), range(1, n)
    return (
        *((0, 0), (m, 0), (m, n), (0, n)),
        *((i, 0) for i in along_u),
        *((m, j) for j in along_v),
        *((i, n) for i in along_u),
        *((0, j) for j in along_v),
        *((i, j) for j in along_v for i in along_u),
    )


def is_bezier(batch: PatchBatch) -> TypeGuard[BezierTriangles | RationalBezierTriangles | BezierQuads]:
    """Whether the patches of a batch are Bézier patches, with control points."""
    return isinstance(batch, BezierTriangles | RationalBezierTriangles | BezierQuads)


def check_bezier(surface: Surface, instead: str) -> None:
    """Refuse a surface with patches that have no control net.

    Raises
    ------
    TestbedError
        One sentence that names the kind of the patches and ends with what to do ``instead``.
    """
    for part in surface.parts:
        if not is_bezier(part.batch):
            raise TestbedError(
                f"the patches are no Bézier patches but of the kind `{part.batch.kind}`, and have no control net: "
                f"{instead}"
            )


def bezier_cells(surface: Surface) -> BezierCells:
    """Return the patches of a surface as cells.

    Raises
    ------
    TestbedError
        Some patches are no Bézier patches.
    """
    check_bezier(surface, "write triangles with --tessellated")
    points, weights, sizes, types, degrees = [], [], [], [], []
    for part in surface.parts:
        batch = part.batch
        assert is_bezier(batch)  # noqa: S101 - checked above
        count = len(batch)
        if isinstance(batch, BezierQuads):
            order = np.array(quad_order(*batch.degree))
            net, degree, kind = batch.control_points[:, order[:, 0], order[:, 1]], batch.degree, BEZIER_QUADRILATERAL
            weight = np.ones(net.shape[:2])
        else:
            place = [index_of(indices) for indices in triangle_order(batch.degree)]
            net, degree, kind = batch.control_points[:, place], (batch.degree, batch.degree), BEZIER_TRIANGLE
            weight = np.ones(net.shape[:2]) if isinstance(batch, BezierTriangles) else batch.weights[:, place]
        weights.append(weight.ravel())
        points.append(net.reshape(-1, 3))
        sizes.append(np.full(count, net.shape[1]))
        types.append(np.full(count, kind))
        degrees.append(np.broadcast_to([*degree, 0], (count, 3)))
    rational = any(isinstance(batch, RationalBezierTriangles) for batch in surface.batches)
    return BezierCells(
        np.concatenate(points),
        np.concatenate(weights) if rational else None,
        np.cumsum(np.concatenate(sizes)),
        np.concatenate(types),
        np.concatenate(degrees),
        np.concatenate([np.full(len(part.batch), index) for index, part in enumerate(surface.parts)]),
        np.concatenate([part.faces for part in surface.parts]),
    )
