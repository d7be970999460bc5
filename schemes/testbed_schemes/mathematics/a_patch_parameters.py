"""The free coefficients f0003 of A-patches on one side: chosen, and raised above their bounds (steps 6 and 8).

A face's bound is B_ijk, raised by the largest positive B_ijkl of its edges, whose function depends on both faces. The
bound of an edge is for raising both faces alike; raising one alone lowers the other's part where a weight of (4.15) is
below -1/2. There the edges are looked at again with the coefficients as they came out, and both are raised further.

Formulas: as printed. **Fill**: the order of the edges' bounds, the largest one at once; the look at the result; the
margin above the bound, :func:`~testbed_schemes.mathematics.a_patch_bounds.above`.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from testbed.errors import Refused
from testbed.geometry.vectors import Float
from testbed_schemes.mathematics.a_patch_bounds import MARGIN, above, edge_bounds, face_bounds, raised_bounds
from testbed_schemes.mathematics.a_patch_coefficients import FaceNets
from testbed_schemes.mathematics.a_patch_edges import EdgeNets
from testbed_schemes.mathematics.a_patch_free import opposite_vertices, quadric_parameters
from testbed_schemes.mathematics.a_patch_sides import SIDES, Hull, nets_of_edges

#: How free coefficients are chosen: the paper's default, so that quadrics are kept, or all the same number.
Free: TypeAlias = Literal["default", "quadric"] | float
#: Looks at edges after raising one face alone.
LOOKS = 8


@dataclass(frozen=True, slots=True)
class FreeCoefficients:
    """Free coefficients of the faces on one side.

    Attributes
    ----------
    top
        (N,) f0003, in the frame of the side.
    bounds
        (N,) what they have to exceed, B_ijk with the edges' part; -inf where nothing is asked.
    raised
        (N,) true where the choice was too low.
    """

    top: Float
    bounds: Float
    raised: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


def free_coefficients(found: Hull, side: int, nets: FaceNets, free: Free) -> FreeCoefficients:
    """Return the free coefficients of the faces ``nets`` on a side.

    Raises
    ------
    Refused
        At an edge the tetrahedron is so wide that raising the coefficients does not help; the message names the edge.
    """
    chosen = _chosen(found, side, nets, free)
    pieces = nets.pieces()
    of_pieces = face_bounds(pieces.layer0, pieces.rational, pieces.layer1, pieces.q)
    bounds = (
        np.maximum.reduceat(of_pieces, np.searchsorted(pieces.owner, np.arange(len(nets)))) if len(nets) else chosen
    )
    # where nothing is asked of a face, edges are looked at with its own choice
    lowest = np.where(np.isfinite(bounds), bounds, chosen)
    edges = nets_of_edges(found, side, nets, lowest)
    of_edges = _checked(found, edges, edge_bounds(edges.nets, edges.rational, edges.mu, edges.nu))
    bounds = np.where(
        (of_edges_by_face := raised_bounds(np.zeros(len(nets)), of_edges, edges.rows)) > 0.0, lowest, bounds
    )
    bounds = bounds + of_edges_by_face
    top = above(chosen, bounds)
    alone = np.minimum(edges.mu[:, 3], edges.nu[:, 0]) < -0.5
    for _ in range(LOOKS if alone.any() else 0):
        edges = nets_of_edges(found, side, nets, top)
        lack = edge_bounds(edges.nets[alone], edges.rational[alone], edges.mu[alone], edges.nu[alone])
        if not (lack > 0.0).any():
            break
        further = raised_bounds(np.zeros(len(nets)), lack, edges.rows[alone])
        top = top + (1.0 + MARGIN) * further
        bounds = np.maximum(bounds, top)
    return FreeCoefficients(top, bounds, top > chosen)


def _chosen(found: Hull, side: int, nets: FaceNets, free: Free) -> Float:
    """Return the coefficients (N,) as chosen, whatever their bounds."""
    if free == "default":
        return nets.default
    if free != "quadric":
        return np.full(len(nets), float(free))
    mesh = found.mesh
    beyond = opposite_vertices(mesh.faces, mesh.edges, mesh.face_edges, mesh.edge_faces)[nets.faces]
    points = np.where((beyond >= 0)[..., None], mesh.points[beyond], np.nan)
    return quadric_parameters(nets, points, SIDES[side] * found.vectors[beyond])


def _checked(found: Hull, edges: EdgeNets, bounds: Float) -> Float:
    """Return the bounds of edges, Refused where one is not a number."""
    if np.isnan(bounds).any():
        row = int(np.argmax(np.isnan(bounds)))
        edge = int(edges.edges[row])
        start, end = found.mesh.edges[edge].tolist()
        raise Refused(
            f"the tetrahedron of edge {edge} (vertices {start}, {end}) is so wide, nu_1 + mu_4 = "
            f"{float(edges.nu[row, 0] + edges.mu[row, 3]):.3g}, that no free coefficients give one sheet there: give a "
            "finer mesh or other normals"
        )
    return bounds
