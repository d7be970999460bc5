"""S-patches: patches of any number of sides, Bezier simplices composed with a map from a polygon into the simplex.

S(p) = sum over s of P_s d! / (s_0! ... s_{n-1}!) l_0(p)^{s_0} ... l_{n-1}(p)^{s_{n-1}}, with the barycentric
coordinates l of a convex polygon. Three sides: a Bezier triangle of degree d. Four: rational patches, of which the
tensor-product patches of bidegree (d, d) are a special case. The boundary curves are polynomials of degree d.

Source: Loop and DeRose 1989; derivatives: Mann 1992, appendix B, corrected (the inner products there multiply pi where
alpha is meant; the last factor of D_xx S in section 5.4.3 is the depth, not the number of sides).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from testbed.geometry.bezier import BezierQuads, BezierTriangles
from testbed.geometry.domain import CORNERS
from testbed.geometry.evaluation import apply_table
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.polygon_coordinates import corner_areas, polygon_coordinates, regular_polygon
from testbed.geometry.simplex_bernstein import (
    composed_jets,
    composed_tables,
    elevate_simplex,
    simplex_multi_indices,
    simplex_point_count,
)
from testbed.geometry.vectors import Bool, Float, Int, as_float

#: Control points of the patches that are evaluated together, each at a point of its own: they stay in the cache.
RUN = 1 << 16


@dataclass(frozen=True, eq=False)
class SPatches:
    """S-patches of one number of sides and one depth over one polygon; immutable.

    Parameters
    ----------
    control_points
        (P, C(n - 1 + d, d), 3), multi-indices (s_0, ..., s_{n-1}) by decreasing s_0, then decreasing s_1, and so on
        (see :mod:`testbed.geometry.simplex_bernstein`). Corner i is the point d e_i.
    sides
        Number of sides n, 3 or more.
    depth
        Degree d of the simplex, 1 or more.
    polygon
        (n, 2) corners of the domain, convex and counterclockwise; the regular polygon (cos 2 pi k / n, sin 2 pi k / n)
        by default. Side i runs from corner i to corner i + 1.

    Raises
    ------
    ValueError
        One sentence: too few sides, no depth, a net of the wrong size, a polygon that is not convex.
    """

    control_points: Float
    sides: int
    depth: int
    polygon: Float | None = None

    def __post_init__(self) -> None:
        points = as_float(self.control_points)
        if self.sides < 3:
            raise ValueError(f"an S-patch has 3 sides or more, not {self.sides}: give the corners of a polygon")
        if self.depth < 1:
            raise ValueError(f"an S-patch has depth 1 or more, not {self.depth}: a single point has no normal")
        count = simplex_point_count(self.sides, self.depth)
        if points.ndim != 3 or points.shape[1:] != (count, 3):
            raise ValueError(
                f"S-patches with {self.sides} sides and depth {self.depth} have control points (P, {count}, 3), not "
                f"{points.shape}: give a point for each of the C(n - 1 + d, d) multi-indices"
            )
        corners = regular_polygon(self.sides) if self.polygon is None else as_float(self.polygon)
        if corners.shape != (self.sides, 2):
            raise ValueError(f"the domain of these S-patches has {self.sides} corners (n, 2), not {corners.shape}")
        if not is_convex(corners):
            raise ValueError("the domain of S-patches is a strictly convex polygon, counterclockwise: move a corner")
        object.__setattr__(self, "control_points", _locked(points))
        object.__setattr__(self, "polygon", _locked(corners))

    def __len__(self) -> int:
        return len(self.control_points)

    @property
    def corners(self) -> Float:
        """(n, 2) corners of the domain."""
        assert self.polygon is not None  # noqa: S101 - set at construction
        return self.polygon

    @property
    def finite(self) -> Bool:
        """(P,) true where every coordinate is finite."""
        return np.asarray(np.isfinite(self.control_points).all(axis=(1, 2)))

    def take(self, patches: Int | slice) -> Self:
        """Return the chosen patches."""
        return type(self)(self.control_points[patches], self.sides, self.depth, self.polygon)

    def tables(self, at: Float, order: int = 2) -> Float:
        """Jets (1 | 3 | 6, N, ...) of the basis functions at points (..., 2) of the polygon, one a control point."""
        return composed_tables(self.depth, polygon_coordinates(self.corners, at, order))

    def jets(self, at: Float, order: int = 2) -> Jet:
        """Jets at points (S, 2) of the polygon, or at each patch's own, (P, S, 2).

        Value, first and second derivatives along the two coordinates, (1 | 3 | 6, P, S, 3). Results do not depend on
        how patches or points are divided over calls.
        """
        if at.ndim == 2:
            return Jet(apply_table(np.moveaxis(self.tables(at, order), 1, -1), self.control_points))
        samples = at.shape[1]
        patch = np.repeat(np.arange(len(self)), samples)
        flat = self.jets_of(patch, at.reshape(-1, 2), order).coefficients
        return Jet(flat.reshape(-1, len(self), samples, 3))

    def jets_of(self, patch: Int, at: Float, order: int = 2) -> Jet:
        """Jets (1 | 3 | 6, N, 3) of patches (N,) at points (N, 2), one of each."""
        result = np.empty((ROWS[order], 3, len(at)))
        run = max(1, RUN // self.control_points.shape[1])
        with np.errstate(invalid="ignore", over="ignore"):  # a patch that is not finite stays so
            for start in range(0, len(at), run):
                some = slice(start, start + run)
                nets = np.ascontiguousarray(self.control_points[patch[some]].transpose(1, 2, 0))
                coordinates = polygon_coordinates(self.corners, at[some], order)
                result[:, :, some] = composed_jets(self.depth, nets, coordinates)
        return Jet(np.moveaxis(result, 1, -1))

    def elevated(self, steps: int = 1) -> Self:
        """Return the same patches written with depth + steps."""
        net = elevate_simplex(self.control_points, self.sides, self.depth, steps)
        return type(self)(net, self.sides, self.depth + steps, self.polygon)

    @classmethod
    def from_triangles(cls, triangles: BezierTriangles) -> Self:
        """Return Bezier triangles as S-patches over the triangle (0, 0), (1, 0), (0, 1): the same nets and jets."""
        return cls(triangles.control_points, 3, triangles.degree, CORNERS[3])

    def as_triangles(self) -> BezierTriangles:
        """Return three-sided patches as Bezier triangles, corner by corner; ValueError if they have more sides."""
        if self.sides != 3:
            raise ValueError(f"S-patches with {self.sides} sides are no triangles: take those with 3 sides")
        return BezierTriangles(self.control_points)

    @classmethod
    def from_quads(cls, quads: BezierQuads) -> Self:
        """Return tensor-product patches of bidegree (d, d) as S-patches of depth d over the unit square.

        P_s = b_{s_1 + s_2, s_2 + s_3}: the bilinear coordinates of the square, raised to the power d, multiply out to
        the products of two Bernstein polynomials. ValueError if the two degrees differ.
        """
        m, n = quads.degree
        if m != n:
            raise ValueError(f"patches of bidegree ({m}, {n}) are no S-patches: elevate them to one degree both ways")
        return cls(tensor_net(quads.control_points), 4, m, CORNERS[4])


def tensor_net(control_points: Float) -> Float:
    """Four-sided nets (P, C(3 + d, d), 3) of tensor-product patches (P, d + 1, d + 1, 3): b_{s_1 + s_2, s_2 + s_3}."""
    s = simplex_multi_indices(4, control_points.shape[1] - 1)
    return control_points[:, s[:, 1] + s[:, 2], s[:, 2] + s[:, 3]]


def is_convex(corners: Float) -> bool:
    """Whether a polygon (n, 2) turns left at every corner, and once around in all."""
    sides = np.roll(corners, -1, axis=0) - corners
    turns = corner_areas(corners)
    before = np.roll(sides, 1, axis=0)
    angles = np.arctan2(turns, (before * sides).sum(axis=1))
    return bool((turns > 0.0).all() and abs(angles.sum() - 2.0 * np.pi) < 1.0)


def _locked(array: Float) -> Float:
    """Read-only array: a copy, unless nobody can write to it anyway."""
    if array.flags.writeable:
        array = array.copy()
        array.flags.writeable = False
    return array
