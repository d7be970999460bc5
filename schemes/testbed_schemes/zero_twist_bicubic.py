"""The zero-twist bicubic (Mann 1992, chapter 4): one bicubic patch a quadrilateral, from data at its corners.

Matches position, normal and second fundamental form at the four corners, as far as the boundary curves do; neighbours
share these, so the surface is C0. The inner control points are C10 + C01 - C00 and so on, moved along the normals.
**Corrected**: the sign of the second fundamental form in (4.4) to (4.7). **Fill**: Adini's twist in place of zero.

The thesis conjectures order five. It is three: the zero twist misses the tangential part of the twist of any smooth
parametrisation, (V00 - V30 - V03 + V33) / 9, which is of second order in h, and a tangential displacement of that size,
with heights adapted to the tangent planes at the corners, is off the surface by the third power of h in between.
Adini's twist, that of the bilinearly blended boundary curves, has that part, and with it the order is five to six where
opposite boundary curves are built from corresponding roots of their equations, and four where they are not.
"""

from dataclasses import dataclass
from typing import Literal

from testbed.geometry.bezier import BezierQuads
from testbed.geometry.blocks import in_blocks
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.mathematics.bicubic_nets import (
    CORNERS,
    I,
    J,
    adini_points,
    boundary_nets,
    check_inner_points,
    in_tangent_planes,
    zero_twist_points,
)


@dataclass(frozen=True)
class ZeroTwistBicubic(Scheme):
    """Zero-twist bicubic.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges; geometric Hermite cubics match the normal curvature of the data, where one
        exists (the notes count where not).
    twist
        Where the inner control points are before they are moved along the normals: ``zero`` twist, or ``adini``, on the
        bilinearly blended Coons patch of the boundary curves.
    """

    boundary: BoundaryCurve = Hermite()
    twist: Literal["zero", "adini"] = "zero"

    name = "zero-twist-bicubic"
    title = "Zero-twist bicubic"
    reference = "Mann 1992, chapter 4"
    formula = (
        "Geometric Hermite edges; C_11 = C_10 + C_01 - C_00 moved along n_00 until <C_11 - C_00, n_00> = "
        "-II_00(C_10 - C_00, C_01 - C_00), and likewise at the other corners."
    )
    status = "Corrected: the printed equations have the opposite sign of II. Fill: Adini's twist."
    failures = (
        "The order is three, not five: the zero twist is tangentially wrong in second order of h wherever faces are no "
        "parallelograms in arc length. With Adini's twist it is five to six, but four in faces whose opposite sides "
        "took different ones of three geometric Hermite cubics."
    )
    domain = (4,)
    needs = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS
    continuity = Continuity.C0
    reproduces = (Shape.PLANES,)

    @property
    def matches(self) -> Data:  # type: ignore[override]  # a claim that the boundary curves decide
        """What the boundary curves match: the inner control points add the mixed part of the second form."""
        return self.boundary.matches

    @property
    def order(self) -> float | None:  # type: ignore[override]  # likewise
        """Five, conjectured in section 4.1, on boundary curves that match the curvature of the data."""
        return 5.0 if Data.SECOND_FORMS in self.boundary.matches else None

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the bicubic patches."""
        curves = self.boundary.network(mesh)

        def nets(faces: slice) -> Float:
            net = boundary_nets(curves, faces)
            normals, forms = mesh.corner_normals(faces)[:, CORNERS], mesh.corner_second_forms(faces)[:, CORNERS]
            if self.twist == "zero":
                net[:, I, J] = zero_twist_points(net, normals, forms)
            else:
                net[:, I, J] = in_tangent_planes(net, adini_points(net), normals, forms)
            return net

        net = in_blocks(nets, len(mesh.faces))
        check_inner_points(self, mesh, net)
        return Surface.over_faces(mesh, BezierQuads(net), curves.notes)
