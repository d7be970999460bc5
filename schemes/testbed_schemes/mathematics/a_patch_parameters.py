"""The free coefficients f0003 of A-patches on one side: chosen, and raised above their bounds (steps 6 and 8).

A face's coefficient is raised above its bound B_ijk. Then the edges are looked at with the coefficients of their faces,
and these are raised by the largest positive B_ijkl of their edges. That bound is for raising both faces of an edge
alike; raising one alone lowers the function where a weight of (4.15) is below -1/2. So edges are looked at until none
lacks anything.

**Fill**: the paper looks at the edges with B_ijk and B_ijl in place of the coefficients, and so can ask for more than
is needed where these are far below the choice or far apart: a fourth of the faces inside a coarse torus would be raised
by up to 57 %, and none of them lacks anything. The order of the edges' bounds is the largest one at once; the margin is
that of :func:`~testbed_schemes.mathematics.a_patch_bounds.above`; and bounds are searched only where the signs of
coefficients leave a doubt (:func:`face_is_certain`): of b_0 < 0, b_1, b_2 >= 0 and b_3 > 0 the signs change once,
whatever b_1 is, so that there is exactly one root and it is simple. Most faces and edges are like that.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from testbed.errors import Refused
from testbed.geometry.vectors import Bool, Float, Int
from testbed_schemes.mathematics.a_patch_bounds import above, edge_bounds, face_bounds, raised_bounds
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets
from testbed_schemes.mathematics.a_patch_edges import EdgeNets, tetrahedron_place
from testbed_schemes.mathematics.a_patch_free import opposite_vertices, quadric_parameters
from testbed_schemes.mathematics.a_patch_sides import SIDES, Hull, nets_of_edges

#: How free coefficients are chosen: the paper's default, so that quadrics are kept, or all the same number.
Free: TypeAlias = Literal["default", "quadric"] | float
#: Looks at the edges, each after raising faces.
LOOKS = 8
#: Places of the coefficients of layers 2 and 3 of an edge's tetrahedron.
LAYER2 = tuple(tetrahedron_place(*corners) for corners in ((0, 0, 1), (0, 0, 2), (1, 3, 3), (2, 3, 3)))
LAYER3 = tuple(tetrahedron_place(*corners) for corners in ((0, 0, 0), (0, 0, 3), (0, 3, 3), (3, 3, 3)))


@dataclass(frozen=True, slots=True)
class FreeCoefficients:
    """Free coefficients of the faces on one side.

    Attributes
    ----------
    top
        (N,) f0003, in the frame of the side.
    raised
        (N,) true where the choice was too low.
    searched
        Faces and edges whose bounds were searched.
    """

    top: Float
    raised: Bool
    searched: int


def free_coefficients(
    found: Hull, side: int, nets: FaceNets, free: Free, place: Callable[[int], str]
) -> FreeCoefficients:
    """Return the free coefficients of the faces on a side.

    Parameters
    ----------
    found
        The hull.
    side
        0 or 1.
    nets
        F over the tetrahedra of the faces on that side.
    free
        How they are chosen.
    place
        From an edge of the hull's mesh to words that say where it is.

    Raises
    ------
    Refused
        At an edge the tetrahedron is so wide that raising the coefficients does not help, or not enough; the message
        names the edge.
    """
    chosen = chosen_coefficients(found, side, nets, free)
    asked = np.flatnonzero(~face_is_certain(nets, chosen))
    bounds = np.full(len(nets), -np.inf)
    bounds[asked] = bounds_of_faces(nets, asked)
    top = above(chosen, bounds, scale=nets.default)
    searched = len(asked)
    for _ in range(LOOKS):
        edges = nets_of_edges(found, side, nets, top)
        doubtful = np.flatnonzero(~sheet_is_certain(edges))
        searched += len(doubtful)
        further = _raised_by_edges(edges, doubtful, len(nets), place)
        if not further.any():
            return FreeCoefficients(top, top > chosen, searched)
        top = np.where(further > 0.0, above(top, top + further), top)
    raise Refused(
        f"free coefficients raised {LOOKS} times ensure no single sheet yet at {place(int(edges.edges[doubtful[0]]))} "
        "or elsewhere: give a finer mesh or other normals"
    )


def chosen_coefficients(found: Hull, side: int, nets: FaceNets, free: Free) -> Float:
    """Return the coefficients (N,) as chosen, whatever their bounds."""
    if free == "default":
        return nets.default
    if free != "quadric":
        return np.full(len(nets), float(free))
    mesh = found.mesh
    beyond = opposite_vertices(mesh.faces, mesh.edges, mesh.face_edges, mesh.edge_faces)[nets.faces]
    points = np.where((beyond >= 0)[..., None], mesh.points[beyond], np.nan)
    return quadric_parameters(nets, points, SIDES[side] * found.vectors[beyond])


def face_is_certain(nets: FaceNets, top: Float) -> Bool:
    """Return the faces (N,) that have one sheet whatever their layers 0 and 1: layer 2 >= 0 and f0003 > 0."""
    layer2 = top[:, None] + 2.0 * nets.q
    return np.asarray((layer2 >= 0.0).all(axis=1) & (top > 0.0))


def sheet_is_certain(edges: EdgeNets) -> Bool:
    """Return the edges (N,) that have one sheet whatever their layers 0 and 1: layer 2 >= 0 and layer 3 > 0."""
    layer2 = (edges.nets[:, LAYER2] >= 0.0).all(axis=1) & (edges.rational >= 0.0).all(axis=1)
    return np.asarray(layer2 & (edges.nets[:, LAYER3] > 0.0).all(axis=1))


def bounds_of_faces(nets: FaceNets, rows: Int) -> Float:
    """Return the bounds B_ijk of chosen faces, the largest one of the three pieces of a split face."""
    if not len(rows):
        return np.empty(0)
    pieces = nets.take(rows).pieces()
    bounds = face_bounds(pieces.layer0, pieces.rational, pieces.layer1, pieces.q)
    largest: Float = np.maximum.reduceat(bounds, np.searchsorted(pieces.owner, np.arange(len(rows))))
    return largest


def _raised_by_edges(edges: EdgeNets, rows: Int, faces: int, place: Callable[[int], str]) -> Float:
    """Return what the bounds of some edges add to each of so many faces; Refused where a bound is not a number."""
    bounds = edge_bounds(edges.nets[rows], edges.rational[rows], edges.mu[rows], edges.nu[rows])
    if np.isnan(bounds).any():
        row = int(rows[np.argmax(np.isnan(bounds))])
        raise Refused(
            f"the tetrahedron at {place(int(edges.edges[row]))} is so wide, nu_1 + mu_4 = "
            f"{float(edges.nu[row, 0] + edges.mu[row, 3]):.3g}, that no free coefficients ensure one sheet there: give "
            "a finer mesh, other normals or a larger epsilon"
        )
    return raised_bounds(np.zeros(faces), bounds, edges.rows[rows])
