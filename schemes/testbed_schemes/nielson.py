"""Nielson's side-vertex method for points and normals (Nielson 1987; Mann 1992, section 2.3.2): a blended patch a face.

Matches position and normal at the vertices; neighbours share boundary curves and the normals along them, so the surface
is G1. The boundary curves are the scheme's own. At the vertices the curvature depends on the direction.

A curve operator g_v joins two points with normals by a cubic whose end tangents are perpendicular to the normals, and a
normal operator g_n gives normals along it. On each side of the face stands a curve; each of its points is joined to the
opposite vertex by another. Both are built by g_v, the second with the normals of g_n:

    G_i = g_v[V_i, N_i, g_v[V_j, N_j, V_k, N_k](s), g_n(s)](b_j + b_k),   s = b_k / (b_j + b_k).

The three patches G_i interpolate all sides, each the tangent planes of its own; they are blended with (2.12).

Formulas: the construction as printed. The operators, which the thesis only describes, are filled in: tangents of g_v
along the projected chord, and g_n perpendicular to the curve's tangent and to a cross-boundary vector that is linear
between N_j x X'(0) and N_k x X'(1). That g_n is perpendicular to X' is not said there; the second property needs it.
"""

from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Literal, TypeAlias

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.blended import BlendedTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, norm, tangential
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.planar_frame import PARALLEL, edge_normals
from testbed_schemes.side_vertex import (
    CORNER_MARGIN,
    J,
    K,
    hermite_derivative,
    hermite_deviation,
    hermite_weights,
    side_vertex_blend,
)

#: Least cosine of the angle between a chord and its projection: computed from the sine, it has lost half of its digits
#: here, and all of them at the square.
SHADOW = 1e-4

Tangents: TypeAlias = Literal["chord", "circular"]


@dataclass(frozen=True)
class Nielson(Scheme):
    """Nielson's side-vertex method.

    Parameters
    ----------
    fullness
        Factor on the length of all tangents; planes keep their linear parametrisation at 1 only.
    tangents
        Length of the tangents before the factor: ``chord``, the chord's length L, or ``circular`` (not Nielson's), that
        of a circular arc, 2 L / (1 + c) with c the cosine of the angle between tangent and chord.

    Raises
    ------
    SpecError
        ``fullness`` is not positive and finite.
    """

    fullness: float = 1.0
    tangents: Tangents = "chord"

    name = "nielson"
    title = "Nielson"
    reference = "Nielson 1987; Mann 1992, section 2.3.2"
    needs = Data.NORMALS
    matches = Data.POINTS | Data.NORMALS
    continuity = Continuity.G1
    order = None
    reproduces = (Shape.PLANES,)
    bounds = MappingProxyType({"fullness": (0.3, 2.0)})

    def __post_init__(self) -> None:
        """Check the parameter."""
        if not 0.0 < self.fullness < np.inf:
            raise SpecError(f"{self.name}: fullness must be positive and finite, and here it is {self.fullness}")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build one blended patch a face."""
        tangents = edge_tangents(mesh, self.fullness, self.tangents)
        check_corners(self, mesh, *tangents)
        check_sides(self, mesh, *tangents)
        points, normals = mesh.corner_points(), mesh.corner_normals()
        formula = partial(nielson_patch, fullness=self.fullness, tangents=self.tangents)
        # tangents at corner i towards corners i + 1 and i + 2
        ends = np.stack([np.roll(points, -1, axis=1), np.roll(points, -2, axis=1)], axis=2)
        legs = tangent(ends - points[:, :, None], normals[:, :, None], self.fullness, self.tangents)
        data = patch_data(points, normals, legs)
        return Surface.over_faces(mesh, BlendedTriangles(formula, data, points, legs, CORNER_MARGIN))


def patch_data(points: Float, normals: Float, legs: Float) -> dict[str, Float]:
    """What the formula takes: vertices, normals and sides (P, 3, 3) from the corner tangents (P, 3, 2, 3), by vertex.

    The side of a vertex is the opposite one, from vertex j to vertex k.
    """
    leaving, arriving = legs[:, J, 0], -legs[:, K, 1]
    return {
        "points": points,
        "normals": normals,
        "to_j": points[:, J] - points,
        "to_k": points[:, K] - points,
        "side": points[:, K] - points[:, J],
        "leaving": leaving,
        "arriving": arriving,
        "across_j": cross(normals[:, J], leaving),
        "across_k": cross(normals[:, K], arriving),
    }


def nielson_patch(
    b0: Float,
    b1: Float,
    b2: Float,
    points: Float,
    normals: Float,
    to_j: Float,
    to_k: Float,
    side: Float,
    leaving: Float,
    arriving: Float,
    across_j: Float,
    across_k: Float,
    fullness: float,
    tangents: Tangents,
) -> Float:
    """Points (..., 3) of the patch from :func:`patch_data`, (..., 3, 3) each."""

    def deviation(r: Float, rest: Float, s: Float, rest_s: Float) -> Float:
        # the side's point, seen from the flat side and from the vertex, and its normal
        off_side = hermite_deviation(side, leaving, arriving, s, rest_s)
        chord = rest_s[..., None] * to_j + s[..., None] * to_k + off_side
        normal = side_normal(side, leaving, arriving, across_j, across_k, s, rest_s)
        # the curve to it; its tangents are stretch (chord - height n)
        square, size = np.vecdot(chord, chord), np.vecdot(normal, normal)
        along, first, last = hermite_weights(r, rest)
        height0, height1 = np.vecdot(chord, normals), np.vecdot(chord, normal)
        # by Pythagoras the cosine between chord and tangent is that of the sine height / |chord| |n|
        cosine0, cosine1 = (np.sqrt(1.0 - sine2) for sine2 in (height0**2 / square, height1**2 / (square * size)))
        first, last = first * stretch(cosine0, fullness, tangents), last * stretch(cosine1, fullness, tangents)
        result: Float = (
            r[..., None] * off_side
            + (along + first - last)[..., None] * chord
            - (first * height0)[..., None] * normals
            + (last * (height1 / size))[..., None] * normal
        )
        return result

    return side_vertex_blend(deviation, points, b0, b1, b2)


def side_normal(
    side: Float, leaving: Float, arriving: Float, across0: Float, across1: Float, s: Float, rest_s: Float
) -> Float:
    """Normals (..., 3) of g_n, not of length one: X'(s) x ((1 - s) N_j x X'(0) + s N_k x X'(1))."""
    across = rest_s[..., None] * across0 + s[..., None] * across1
    normal: Float = np.cross(hermite_derivative(side, leaving, arriving, s, rest_s), across)
    return normal


def tangent(chord: Float, normal: Float, fullness: float, tangents: Tangents) -> Float:
    """Tangents (..., 3) of g_v: the chord projected onto the tangent plane, made as long as ``tangents`` says."""
    projected = tangential(chord, normal)
    return stretch(norm(projected) / norm(chord), fullness, tangents)[..., None] * projected


def stretch(c: Float, fullness: float, tangents: Tangents) -> Float:
    """Factor (...) on the projected chord; c is the cosine of the angle between the chord and its projection."""
    return fullness / c if tangents == "chord" else 2.0 * fullness / (c * (1.0 + c))


def edge_tangents(mesh: HermiteMesh, fullness: float, tangents: Tangents) -> tuple[Float, Float]:
    """Return the tangents of g_v at both ends of the edges, (E, 3) each, both away from their vertex.

    Refused if there are edges on which the operators are not defined; the message names the first one's vertices.
    """
    edges = mesh.edge_data
    chord, (n0, n1) = edges.p1 - edges.p0, edge_normals(edges)
    length, shadow = norm(chord), np.minimum(norm(tangential(chord, n0)), norm(tangential(chord, n1)))
    undefined: Bool = np.asarray(~(shadow > SHADOW * length))
    refuse(mesh, undefined, "is parallel to the normal at one of its ends")
    leaving, arriving = tangent(chord, n0, fullness, tangents), tangent(chord, n1, fullness, tangents)
    half = np.full(len(chord), 0.5)
    middle = side_normal(chord, leaving, arriving, cross(n0, leaving), cross(n1, arriving), half, half)
    vanishes: Bool = np.asarray(~(norm(middle) > PARALLEL * length**2))
    refuse(mesh, vanishes, "has no normal half-way, where those of its ends cancel out")
    return leaving, -arriving


def refuse(mesh: HermiteMesh, unfit: Bool, why: str) -> None:
    """Raise Refused if any edge (E,) is unfit."""
    if unfit.any():
        i, j = mesh.edges[unfit][0].tolist()
        raise Refused(
            f"{Nielson.name} takes no edge that {why}: the edge from vertex {i} to vertex {j}, the first of "
            f"{int(unfit.sum())}; check the normals"
        )
