"""Offsets of parametrised surfaces: positions, tangents and second derivatives, exactly.

The offset at distance d of a surface S with unit normals N is S* = S + d N (Mann 1992, section 5.4.2). With curvature
positive where the surface bends away from its normal, dN = W, so dS* = (Id + d W) dS, the normals stay and

    W* = W (Id + d W)^-1,    k_i* = k_i / (1 + d k_i):

the thesis's law k / (1 - d k), whose curvatures have the other sign. Equation (5.1) has a misplaced parenthesis: both
terms in brackets are vectors, II(v, p_1) p_1 and II(v, p_2) p_2. The offset is regular where 1 + d k_i > 0.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from testbed.geometry.bernstein import subdivide_tensor
from testbed.geometry.charted_surface import BoundedCharts, CurvedBoxes
from testbed.geometry.jets import ROWS, Jet
from testbed.geometry.taylor import Taylor
from testbed.geometry.vectors import Bool, Float, Int, as_float, norm
from testbed_datasets.bicubic_spline import BicubicSpline
from testbed_datasets.principal_bounds import area_vectors, middle_normals, principal_bounds, quarters

#: Rows, in a jet of order 3, of the jets of order 2 of S_u and S_v.
ALONG_U, ALONG_V = [1, 3, 4, 6, 7, 8], [2, 4, 5, 7, 8, 9]
#: How often the spline's patches are halved for bounds of the curvature.
HALVINGS = 3
#: Boxes are larger than rounding could make the surface, relative to its coordinates.
ROUNDING = 1e-12


class Parametrised(Protocol):
    """A parametrised surface with third derivatives."""

    def jet(self, at: Float, order: int) -> Float:
        """Derivatives up to ``order``, at most 3, at parameters (N, 2): (1 | 3 | 6 | 10, N, 3).

        f | f_u, f_v | f_uu, f_uv, f_vv | f_uuu, f_uuv, f_uvv, f_vvv.
        """


def offset_jet(base: Parametrised, distance: float, at: Float, order: int = 2) -> Jet:
    """Jet (rows, N, 3) of the offset of a surface at parameters (N, 2).

    S_u and S_v with their own derivatives go through Taylor arithmetic: S* = S + d (S_u x S_v) / |S_u x S_v|, whose
    second derivatives take the third derivatives of S.
    """
    known = base.jet(at, order + 1)
    rows = ROWS[order]
    along_u: Any = Taylor(known[ALONG_U[:rows]])
    along_v: Any = Taylor(known[ALONG_V[:rows]])
    n: Any = np.cross(along_u, along_v)
    point: Any = Taylor(known[:rows]) + distance * (n / np.linalg.norm(n, axis=-1)[..., None])
    return Jet(point.coefficients)


def offset_form(W: Float, distance: float) -> Float:
    """Second fundamental forms W (Id + d W)^-1 (..., 3, 3) of the offset where the base has W; both share normals."""
    form = as_float(np.linalg.solve(np.eye(3) + distance * W, W))
    return 0.5 * (form + form.swapaxes(-1, -2))


@dataclass(frozen=True)
class OffsetSpline(BoundedCharts):
    """The offset of a bicubic spline surface, in one chart: the spline is smooth enough for that.

    Its second derivatives jump at the spline's knots, which the third derivatives of the spline enter; its second
    fundamental form does not.

    Parameters
    ----------
    spline
        The surface S.
    distance
        The distance d, along the spline's normals.
    margin
        How far the chart goes beyond the square [0, m]^2, in parameters, as the polynomials that the spline has there.
    """

    spline: BicubicSpline
    distance: float
    margin: float = 0.25

    def __len__(self) -> int:
        return 1

    def polygon(self, chart: int) -> Float:
        """The square [-margin, m + margin]^2, (4, 2)."""
        del chart
        low, high = -self.margin, self.spline.cells + self.margin
        return np.array([[low, low], [high, low], [high, high], [low, high]])

    def jets(self, chart: Int, at: Float, order: int = 2) -> Jet:
        """Jets (rows, N, 3) at parameters (N, 2)."""
        del chart
        return offset_jet(self.spline, self.distance, at, order)

    def boxes(self) -> CurvedBoxes:
        """Boxes (B, 3) of the offset's pieces over parts of the spline's patches, with bounds of the curvature."""
        return curved_pieces(self)[0]

    def rim(self) -> tuple[Float, Float]:
        """Boxes (R, 3) of the pieces at the sides of the polygon."""
        pieces, outermost = curved_pieces(self)
        return pieces.low[outermost], pieces.high[outermost]


@lru_cache(maxsize=8)
def curved_pieces(offset: OffsetSpline) -> tuple[CurvedBoxes, Bool]:
    """Bound the offset of pieces of the spline; and which (B,) are at the sides of the polygon. Remembered."""
    nets = extended_patches(offset.spline, offset.margin)
    column, row = (index.ravel() for index in np.indices((offset.spline.cells, offset.spline.cells)))
    for _ in range(HALVINGS):
        nets = quarters(nets)
        # in the order of the quarters: first along u, then along v
        column, row = np.tile(np.concatenate([2 * column, 2 * column + 1]), 2), np.tile(row, 2)
        row = np.concatenate([2 * row, 2 * row + 1])
    last = 2**HALVINGS * offset.spline.cells - 1
    outermost: Bool = (column == 0) | (column == last) | (row == 0) | (row == last)
    low, high = principal_bounds(nets)
    d = offset.distance
    with np.errstate(divide="ignore", invalid="ignore"):  # beyond the focal distance nothing is bounded
        ends = np.stack([np.where(1.0 + d * k > 0.0, np.abs(k / (1.0 + d * k)), np.inf) for k in (low, high)])
    bound = np.where(np.isnan(ends), np.inf, ends).max(axis=0) * (1.0 + ROUNDING)
    normals = d * normal_boxes(nets)
    corners = nets.reshape(len(nets), -1, 3)
    loose = ROUNDING * (np.abs(nets).max() + abs(d))
    lower = corners.min(axis=1) + normals.min(axis=0) - loose
    return CurvedBoxes(lower, corners.max(axis=1) + normals.max(axis=0) + loose, bound), outermost


def normal_boxes(nets: Float) -> Float:
    """Boxes of the unit normals of patches (P, 4, 4, 3): their lower and upper corners, (2, P, 3).

    A normal is an area vector, which is between the extremes of the coefficients, over its length.
    """
    area = area_vectors(nets)
    shortest = np.einsum("pijx,px->pij", area, middle_normals(area)).min(axis=(1, 2))
    longest = norm(area).max(axis=(1, 2))
    # where the area may vanish, all that is known of a unit vector is its length
    known = (shortest > 0.0)[:, None]
    lengths = np.stack([np.where(shortest > 0.0, shortest, 1.0), longest])[:, :, None]
    quotients = np.concatenate([area.min(axis=(1, 2)) / lengths, area.max(axis=(1, 2)) / lengths])
    low, high = np.where(known, quotients.min(axis=0), -1.0), np.where(known, quotients.max(axis=0), 1.0)
    boxes: Float = np.clip(np.stack([low, high]), -1.0, 1.0)
    return boxes


@lru_cache(maxsize=8)
def extended_patches(spline: BicubicSpline, margin: float) -> Float:
    """Bezier nets (m^2, 4, 4, 3) of the cells, those at the boundary continued by ``margin``; read-only, remembered."""
    nets = spline.patches()
    # an only cell is longer by the margin at its start when its end is moved
    end = 1.0 + margin if spline.cells > 1 else (1.0 + 2.0 * margin) / (1.0 + margin)
    nets[0] = subdivide_tensor(nets[0], 0, -margin)[1]
    nets[-1] = subdivide_tensor(nets[-1], 0, end)[0]
    nets[:, 0] = subdivide_tensor(nets[:, 0], 1, -margin)[1]
    nets[:, -1] = subdivide_tensor(nets[:, -1], 1, end)[0]
    nets = nets.reshape(-1, 4, 4, 3)
    nets.flags.writeable = False
    return nets
