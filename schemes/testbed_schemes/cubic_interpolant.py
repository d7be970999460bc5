"""The cubic interpolant (Mann 1992, chapter 3): one cubic Bezier triangle a face.

Matches position, normal and second fundamental form at the three corners, as far as the boundary curves do; neighbours
share these, so the surface is C0. The centre is where three planes meet, one a corner. Formulas: as printed, in the
signs of the thesis's section 1.2, which are ours.
"""

import math
from dataclasses import dataclass

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.blocks import blocks
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.mesh_checks import named
from testbed.geometry.nets import CENTRE, boundary_net, corner_legs
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, Int, cross, dot, norm, tangential, unit
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.boundary_curves.hermite import Hermite
from testbed_schemes.mathematics.quadratic_precision import quadratic_precision_centre

#: Singular values of the three normals below this, relative to the largest, count as zero: half of the digits, so that
#: the tangential place of the centre keeps the other half. Normals of a smooth surface have singular values of order 1,
#: h, h (h, h^2 on parabolic lines): a larger cut-off would in the end drop them on every fine mesh, and with them the
#: order of convergence.
CUTOFF = 1e-8
#: How far the second fundamental forms may move a centre, in heights of the face: at the inverse of the machine
#: precision nothing is left of the normals of the patch, here six of their digits.
FARTHEST = 1e10
#: Damping of centres out of reach is sought from this to its inverse, so many times halved on a logarithmic scale.
LEAST_DAMPING, HALVINGS = 1e-16, 60


@dataclass(frozen=True)
class CubicInterpolant(Scheme):
    """Cubic interpolant.

    Parameters
    ----------
    boundary
        Curve construction on the mesh edges; geometric Hermite cubics match the normal curvature of the data, where one
        exists (the notes count where not).
    reach
        How far, in heights of the face, the second fundamental forms may move the centre along the plane of the face
        from the point of quadratic precision. Where they ask for more, the point nearest to the three planes within
        that reach is taken, and the face counted. Near parabolic lines, where corner normals are nearly coplanar,
        centres go far astray and patches fold; 0.2 prevents that.
    """

    boundary: BoundaryCurve = Hermite()
    reach: float = math.inf

    name = "cubic-interpolant"
    title = "Cubic interpolant"
    reference = "Mann 1992, section 3.2"
    formula = (
        "Geometric Hermite edges; centre P_111 from <P_111 - V, n> = -3/2 II(u, v) at the corners, u and v the legs."
    )
    status = (
        "As printed, solved about the point of quadratic precision; the sign of II is that of section 1.2; "
        "fill: reach, for the thesis does not say when planes count as parallel."
    )
    failures = (
        "The order falls where edges have no geometric Hermite cubic (rows of a torus on its top circle): they take "
        "planar curves, counted, and second fundamental forms are not matched there. Patches fold where corner normals "
        "are nearly coplanar, as near the inflections of the offset surface, not with reach=0.2."
    )
    needs = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS
    continuity = Continuity.C0
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the reach."""
        if not self.reach > 0.0:
            raise SpecError(f"parameter reach of {self.name} cannot be {self.reach}: give a positive number of heights")

    @property
    def matches(self) -> Data:  # type: ignore[override]  # a claim that the boundary curves decide
        """What the boundary curves match: the centre adds the mixed part of the second fundamental form."""
        return self.boundary.matches

    @property
    def order(self) -> float | None:  # type: ignore[override]  # likewise
        """Five, conjectured in section 3.4, on boundary curves that match the curvature of the data."""
        return 5.0 if Data.SECOND_FORMS in self.boundary.matches else None

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Return the cubic triangles; counts faces whose three planes do not meet in a point."""
        curves = self.boundary.network(mesh)
        net = boundary_net(curves)
        singular, limited = 0, 0
        for faces in blocks(len(net)):
            net[faces, CENTRE], rank = centre_points(mesh, net[faces], faces)
            singular += int((rank < 3).sum())
            limited += limit_centres(mesh, net[faces], faces, self.reach) if math.isfinite(self.reach) else 0
        check_centres(self, mesh, net)
        counted = {"singular centres": singular, "centres out of reach": limited}
        notes = {**curves.notes, **{kind: count for kind, count in counted.items() if count}}
        return Surface.over_faces(mesh, BezierTriangles(net), notes)


def centre_points(mesh: HermiteMesh, net: Float, faces: slice = slice(None)) -> tuple[Float, Int]:
    """P111 from the mixed partials at the corners (3.4): <P111 - V, n> = -3/2 II(u, v), u and v the net's legs there.

    The three planes are solved by singular value decomposition about the point of quadratic precision: where they are
    parallel or meet in a line, the solution next to that point is taken.

    Parameters
    ----------
    mesh
        The mesh, with normals and second forms.
    net
        (F, 10, 3) cubic nets with their boundaries.
    faces
        Which faces of the mesh these are.

    Returns
    -------
    centres
        (F, 3).
    rank
        (F,) of the three planes; below 3 the mixed partials are matched as nearly as possible, in least squares.
    """
    guess = quadratic_precision_centre(net)
    normals, heights = centre_planes(mesh, net, faces, guess)
    left, size, right = np.linalg.svd(normals)
    kept = size > CUTOFF * size[:, :1]
    components = np.einsum("fji,fj->fi", left, heights) / np.where(kept, size, np.inf)
    return guess + np.einsum("fij,fi->fj", right, components), kept.sum(axis=1)


def centre_planes(mesh: HermiteMesh, net: Float, faces: slice, guess: Float) -> tuple[Float, Float]:
    """Unit normals (F, 3, 3) of the three planes of (3.4), a row each, and their heights (F, 3) over points (F, 3)."""
    vertex, leg_u, leg_v = corner_legs(net)
    normals = mesh.corner_normals(faces)
    return normals, dot(vertex - guess[:, None], normals) - 1.5 * mesh.second_form(leg_u, leg_v, faces)


def limit_centres(mesh: HermiteMesh, net: Float, faces: slice, reach: float) -> int:
    """Draw centres of nets (F, 10, 3) back into reach, in heights of the face along its plane; return how many.

    A centre out of reach becomes the point x within it that is nearest to the three planes N x = b in least squares:
    (N^T N + l T) x = N^T b, T the projection onto the plane of the face, with the least l for which |T x| is the reach.
    """
    guess = quadratic_precision_centre(net)
    corners = mesh.points[mesh.faces[faces]]
    upright = unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    room = reach * face_heights(mesh, faces)
    (far,) = np.nonzero(norm(tangential(net[:, CENTRE] - guess, upright)) > room)
    if len(far):
        normals, heights = (planes[far] for planes in centre_planes(mesh, net, faces, guess))
        square = np.einsum("fki,fkj->fij", normals, normals)
        right = np.einsum("fki,fk->fi", normals, heights)
        across = np.eye(3) - upright[far, :, None] * upright[far, None, :]
        low, high = np.full(len(far), LEAST_DAMPING), np.full(len(far), 1.0 / LEAST_DAMPING)
        for _ in range(HALVINGS):
            middle = np.sqrt(low * high)
            step = np.linalg.solve(square + middle[:, None, None] * across, right[..., None])[..., 0]
            beyond = norm(tangential(step, upright[far])) > room[far]
            low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
        net[far, CENTRE] = guess[far] + step
    return len(far)


def face_heights(mesh: HermiteMesh, faces: slice = slice(None)) -> Float:
    """Heights (F,) of the triangles over their longest sides."""
    corners = mesh.points[mesh.faces[faces]]
    sides = np.roll(corners, -1, axis=1) - corners
    heights: Float = norm(cross(sides[:, 0], sides[:, 1])) / norm(sides).max(axis=1)
    return heights


def check_centres(scheme: CubicInterpolant, mesh: HermiteMesh, net: Float) -> None:
    """Refuse data that move the centre of a face by more than ``FARTHEST``; the message names the first face."""
    moved = norm(net[:, CENTRE] - quadratic_precision_centre(net)) / face_heights(mesh)
    far = moved > FARTHEST
    if far.any():
        face = int(np.argmax(far))
        raise Refused(
            f"{scheme} moves the centre of {named(mesh.faces, face)} by {moved[face]:.0e} heights of the face to match "
            "the second fundamental forms there: check their size, or refine the mesh"
        )
