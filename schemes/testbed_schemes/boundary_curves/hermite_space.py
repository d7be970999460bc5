"""Geometric Hermite curves in space (Mann 1992, section 2.4.4): a given normal curvature at both ends, no common plane.

The equations are in :mod:`testbed_schemes.mathematics.space_hermite`; **corrected**: the printed first equation has the
other sign on its right. Tangents are for the caller to give there: those of the curve to follow where the mesh has one;
elsewhere, **fill**: unit projections of the chord, and k = -II(t, t) of the data in their direction. Where normals and
chord are in one plane the curve is that of `hermite`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from testbed.geometry.mesh import EdgeData
from testbed.geometry.vectors import Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Data
from testbed_schemes.mathematics.geometric_hermite import Root, check_guard
from testbed_schemes.mathematics.planar_frame import edge_normals, projected_tangents
from testbed_schemes.mathematics.space_hermite import followed_tangents, space_curves


@dataclass(frozen=True)
class HermiteSpace(BoundaryCurve):
    """Space cubics along the projected chord that match the data's normal curvature at both ends.

    Parameters
    ----------
    root
        Which of several solutions to take: ``best``, the most uniform speed (least standard deviation of |C'| over its
        mean), or ``worst``, the least uniform, with the longer leg at the lower vertex id of two mirror images.
    guard
        Least and greatest leg, in chords, of a solution that counts. The default leaves out the spurious ones next to
        zero and infinity only.
    """

    root: Root = "best"
    guard: tuple[float, ...] = (1e-4, 1e4)

    name = "hermite-space"
    title = "Geometric Hermite in space"
    reference = "Mann 1992, section 2.4.4"
    needs = Data.NORMALS | Data.SECOND_FORMS
    matches = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS
    formula = (
        "Legs d0, d1 > 0 along the unit projected chord, or the tangents of a curve to follow, with <n1, t0> d0 = "
        "<n1, a> + 3/2 k1 d1^2, <n0, t1> d1 = <n0, a> - 3/2 k0 d0^2; k = -II(t, t), a = p1 - p0."
    )
    status = (
        "Corrected: the sign of the first equation's right side; fill: the tangents, which the thesis takes as given."
    )
    failures = (
        "Refused where a chord is parallel to a normal. Data whose normals and curvatures disagree have no root (18 of "
        "30 edges of an icosahedron with normals turned by ten degrees), nor have some long edges of a coarse torus (8 "
        "of 120). Short legs make patches lumpy: K from -300 to 180 on a torus of 50 points, -17 to 12 with "
        "guard=(0.15 0.75)."
    )

    def __post_init__(self) -> None:
        """Check the guard."""
        check_guard(self.name, self.guard)

    def curves(self, edges: EdgeData) -> tuple[Float, Mapping[str, int]]:
        """Return the matching curves, (E, 4, 3); cubics with legs of L / 3, counted, where there is none."""
        projected, _ = projected_tangents(edges.p1 - edges.p0, *edge_normals(edges))
        control_points, solved = space_curves(edges, followed_tangents(edges, projected), self.root, self.guard)
        missing = ~solved & np.isfinite(control_points).all(axis=(1, 2))
        return control_points, {"curves without a root": int(missing.sum())} if missing.any() else {}
