"""The bicubic interpolant (Mann 1992, chapter 4): one bicubic patch a quadrilateral, from its corners and its centre.

Matches position, normal and second fundamental form at the four corners, as far as the boundary curves do, and at the
centre of the face; neighbours share their boundary curves, so the surface is C0. The inner control points solve nine
linear equations and three quadrics; of several real solutions the one nearest to the zero-twist points is taken, and
without one these. **Corrected**: signs and some entries of the printed equations
(:mod:`testbed_schemes.mathematics.bicubic_centre`). **Fill**: how far solutions may be, and what is done with those
that are equally near, which a face with a plane of symmetry has in mirror images: their mean matches position and
normal at the centre and nearly the second form.

The thesis conjectures order six, from bounds on derivatives that the solutions do not have. In the limit of short edges
the equations leave two parameters of the patch free, to first order a reparametrisation of the paraboloid; roots fix
them only by the square roots of smaller terms, at displacements of the control points of second order in h. So the
third derivatives of the patch grow as 1/h, and the order is four where there are such roots, three where there are none
and the zero-twist points are taken. Refinement does not bring roots: whether there are any is decided by the signs of
terms of fourth order.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.bezier import BezierQuads
from testbed.geometry.blocks import in_blocks
from testbed.geometry.face_data import Centres
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.mathematics.bicubic_centre import Branch, inner_points
from testbed_schemes.mathematics.bicubic_nets import (
    CORNERS,
    I,
    J,
    boundary_nets,
    check_inner_points,
    face_sizes,
    zero_twist_points,
)

#: What is counted for each branch: ordinary ones, and departures from the construction.
ORDINARY = {Branch.ONE_ROOT: "centres with one root", Branch.NEAREST_ROOT: "centres with several roots"}
DEPARTURES = {
    Branch.TIED_ROOTS: "centres with roots equally near",
    Branch.NO_ROOT: "centres without a root",
    Branch.SINGULAR: "centres with singular equations",
}


@dataclass(frozen=True)
class BicubicInterpolant(Scheme):
    """Bicubic interpolant.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges; geometric Hermite cubics match the normal curvature of the data, where one
        exists (the notes count where not).
    without_root
        What a face without a solution takes: the ``zero-twist`` points, as published, or, of the solutions of the nine
        ``linear`` equations, which match position and normal at the centre, the one nearest to the zero-twist points.
    reach
        Solutions farther than this from the zero-twist points, in mean sides of the face, do not count. The default
        leaves out spurious ones near infinity only; 1 leaves out those whose patch folds.
    """

    boundary: BoundaryCurve = Hermite()
    without_root: Literal["zero-twist", "linear"] = "zero-twist"
    reach: float = 1.0

    name = "bicubic-interpolant"
    title = "Bicubic interpolant"
    reference = "Mann 1992, chapter 4"
    formula = (
        "Geometric Hermite edges; C_11, C_12, C_21, C_22 from the second forms at the corners (4 linear equations) and "
        "point, normal, second form at the centre (5 linear, 3 quadratic): nearest real root to zero twist."
    )
    status = "Corrected: printed signs of II, two matrices. Fill: the reach of roots, the mean of equally near ones."
    failures = (
        "The order is four, not six, where there are roots, and three elsewhere: where K < 0 many faces have none, or "
        "far ones only. Faces with a plane of symmetry have roots in pairs, none nearer than the other."
    )
    domain = (4,)
    needs = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS | Data.CENTRES
    continuity = Continuity.C0
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the reach."""
        if not self.reach > 0.0:
            raise SpecError(f"{self.name}: reach must be positive, and here it is {self.reach}")

    @property
    def matches(self) -> Data:  # type: ignore[override]  # a claim that the boundary curves decide
        """What the boundary curves match at the corners, and the samples at the centres."""
        return self.boundary.matches | Data.CENTRES

    @property
    def order(self) -> float | None:  # type: ignore[override]  # likewise
        """Six, conjectured in section 4.2, on boundary curves that match the curvature of the data."""
        return 6.0 if Data.SECOND_FORMS in self.boundary.matches else None

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the bicubic patches; counts which faces took which branch."""
        curves = self.boundary.network(mesh)
        branches = np.empty(len(mesh.faces), dtype=np.int64)

        def nets(faces: slice) -> Float:
            net = boundary_nets(curves, faces)
            normals, forms = mesh.corner_normals(faces)[:, CORNERS], mesh.corner_second_forms(faces)[:, CORNERS]
            net[:, I, J] = zero_twist_points(net, normals, forms)
            points, branch = inner_points(net, normals, self.centres(mesh, faces), face_sizes(mesh, faces), self.reach)
            departs = (branch == Branch.NO_ROOT) & (self.without_root == "zero-twist")
            net[:, I, J] = np.where(departs[:, None, None], net[:, I, J], points)
            branches[faces] = branch
            return net

        net = in_blocks(nets, len(mesh.faces))
        check_inner_points(self, mesh, net)
        notes = {**curves.notes, **counted(branches, DEPARTURES)}
        return Surface.over_faces(mesh, BezierQuads(net), notes, counted(branches, ORDINARY))

    def centres(self, mesh: HermiteMesh, faces: slice) -> Centres:
        """Return the samples at the centres of some faces."""
        centres = mesh.face_data.centres
        assert centres is not None  # noqa: S101 - fit has checked that
        return Centres(centres.points[faces], centres.normals[faces], centres.second_forms[faces])


def counted(branches: Int, names: dict[Branch, str]) -> dict[str, int]:
    """Numbers of faces by branch, those that occur."""
    numbers = {name: int((branches == branch).sum()) for branch, name in names.items()}
    return {name: number for name, number in numbers.items() if number}
