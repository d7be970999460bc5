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
from testbed.geometry.composed import weighted_sum
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, norm, tangential
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.mathematics.planar_frame import PARALLEL, edge_normals
from testbed_schemes.mathematics.side_vertex import (
    CORNER_MARGIN,
    J,
    K,
    hermite_weights,
    separable_blend,
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
    formula = (
        "sum beta_i G_i, G_i = g_v[V_i, N_i, X(s), n(s)](b_j + b_k) with s = b_k / (b_j + b_k), X = g_v[V_j, N_j, V_k, "
        "N_k] and n its g_n; beta_i = b_j b_k / (b_0 b_1 + b_1 b_2 + b_2 b_0)."
    )
    status = (
        "As printed: the construction and the blend. Fill: the operators, described in words, and that g_n is "
        "perpendicular to X', which is not said and without which normals jump. Circular tangents are ours."
    )
    failures = (
        "Dented where edges turn far: K on the octahedron of radius 1 is in [0.59, 2.51], with tangents=circular in "
        "[0.93, 1.05]. Curvature at a vertex depends on the direction. Refuses edges along a normal of their ends."
    )
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
        leaving, arriving = edge_tangents(self, mesh, self.fullness, self.tangents)
        edges, half = mesh.edge_data, np.full(len(mesh.edges), 0.5)
        coefficients = side_normals(edges.p1 - edges.p0, leaving, arriving, *edge_normals(edges))
        check_middles(self, mesh, side_normal(coefficients, half, half))
        check_corners(self, mesh, leaving, -arriving)
        check_sides(self, mesh, leaving, -arriving)
        points, normals = mesh.corner_points(), mesh.corner_normals()
        legs = corner_tangents(points, normals, self.fullness, self.tangents)
        formula = partial(nielson_patch, fullness=self.fullness, tangents=self.tangents)
        patches = BlendedTriangles(formula, patch_data(points, normals, legs), points, legs, CORNER_MARGIN)
        return Surface.over_faces(mesh, patches)


def corner_tangents(points: Float, normals: Float, fullness: float, tangents: Tangents) -> Float:
    """Return the tangents (P, 3, 2, 3) of g_v at corner i towards corners i + 1 and i + 2."""
    ends = np.stack([np.roll(points, -1, axis=1), np.roll(points, -2, axis=1)], axis=2)
    return tangent(ends - points[:, :, None], normals[:, :, None], fullness, tangents)


def patch_data(points: Float, normals: Float, legs: Float) -> dict[str, Float]:
    """What the formula takes, from vertices, normals (P, 3, 3) and corner tangents (P, 3, 2, 3), by vertex.

    The side of a vertex is the opposite one, from vertex j to vertex k.
    """
    side, leaving, arriving = points[:, K] - points[:, J], legs[:, J, 0], -legs[:, K, 1]
    return {
        "points": points,
        "normals": normals,
        "to_j": points[:, J] - points,
        "to_k": points[:, K] - points,
        "leaving": leaving - side,
        "arriving": arriving - side,
        "side_normals": side_normals(side, leaving, arriving, normals[:, J], normals[:, K]),
    }


def nielson_patch(
    b0: Float,
    b1: Float,
    b2: Float,
    points: Float,
    normals: Float,
    to_j: Float,
    to_k: Float,
    leaving: Float,
    arriving: Float,
    side_normals: Float,
    fullness: float,
    tangents: Tangents,
) -> Float:
    """Points (..., 3) of the patch.

    Parameters
    ----------
    points, normals
        (..., 3, 3) at the vertices.
    to_j, to_k
        (..., 3, 3) chords from each vertex to the next two.
    leaving, arriving
        (..., 3, 3) end tangents of the opposite side, less its chord.
    side_normals
        (..., 3, 4, 3) normals along it, see :func:`side_normals`.
    """

    def terms(r: Float, rest: Float, s: Float, rest_s: Float) -> tuple[tuple[Float, ...], tuple[Float, ...]]:
        # the side's point, seen from the flat side and from the vertex, and its normal
        product = s * rest_s
        off_side = weighted_sum((product * rest_s, -product * s), (leaving, arriving))
        chord = weighted_sum((rest_s, s), (to_j, to_k)) + off_side
        normal = side_normal(side_normals, s, rest_s)
        # tangents of the curve to it; by Pythagoras the cosine to the chord is that of the sine height / |chord| |n|
        square, size = np.vecdot(chord, chord), np.vecdot(normal, normal)
        height0, height1 = np.vecdot(chord, normals), np.vecdot(chord, normal)
        cosine0, cosine1 = (np.sqrt(1.0 - sine2) for sine2 in (height0**2 / square, height1**2 / (square * size)))
        first = stretch(cosine0, fullness, tangents)[..., None] * (chord - height0[..., None] * normals)
        last = stretch(cosine1, fullness, tangents)[..., None] * (chord - (height1 / size)[..., None] * normal)
        return (r, *hermite_weights(r, rest)), (off_side, chord, first, last)

    return separable_blend(terms, points, b0, b1, b2)


def side_normals(chord: Float, leaving: Float, arriving: Float, normal0: Float, normal1: Float) -> Float:
    """Coefficients (..., 4, 3) of g_n, not of length one: X'(s) x ((1 - s) N_j x X'(0) + s N_k x X'(1)).

    They belong to the powers (1 - s)^3, (1 - s)^2 s, (1 - s) s^2 and s^3.
    """
    across0, across1 = cross(normal0, leaving), cross(normal1, arriving)
    # X' = (1 - s)^2 X'(0) + (1 - s) s middle + s^2 X'(1)
    middle = 6.0 * chord - 2.0 * (leaving + arriving)
    inner0 = cross(leaving, across1) + cross(middle, across0)
    inner1 = cross(middle, across1) + cross(arriving, across0)
    return np.stack([cross(leaving, across0), inner0, inner1, cross(arriving, across1)], axis=-2)


def side_normal(coefficients: Float, s: Float, rest_s: Float) -> Float:
    """Normals (..., 3) of g_n, from their coefficients."""
    product = s * rest_s
    weights = rest_s * rest_s * rest_s, product * rest_s, product * s, s * s * s
    normal: Float = weighted_sum(weights, [coefficients[..., r, :] for r in range(4)])
    return normal


def tangent(chord: Float, normal: Float, fullness: float, tangents: Tangents) -> Float:
    """Tangents (..., 3) of g_v: the chord projected onto the tangent plane, made as long as ``tangents`` says."""
    projected = tangential(chord, normal)
    return stretch(norm(projected) / norm(chord), fullness, tangents)[..., None] * projected


def stretch(c: Float, fullness: float, tangents: Tangents) -> Float:
    """Factor (...) on the projected chord; c is the cosine of the angle between the chord and its projection."""
    return fullness / c if tangents == "chord" else 2.0 * fullness / (c * (1.0 + c))


def edge_tangents(scheme: Scheme, mesh: HermiteMesh, fullness: float, tangents: Tangents) -> tuple[Float, Float]:
    """Return the tangents of g_v at both ends of the edges, (E, 3) each, as the edges run.

    Refused if there are edges on which the operator is not defined; the message names the first one's vertices.
    """
    edges = mesh.edge_data
    chord, (n0, n1) = edges.p1 - edges.p0, edge_normals(edges)
    shadow = np.minimum(norm(tangential(chord, n0)), norm(tangential(chord, n1)))
    undefined: Bool = np.asarray(~(shadow > SHADOW * norm(chord)))
    refuse(scheme, mesh, undefined, "is parallel to the normal at one of its ends")
    return tangent(chord, n0, fullness, tangents), tangent(chord, n1, fullness, tangents)


def check_middles(scheme: Scheme, mesh: HermiteMesh, middle: Float) -> None:
    """Refuse edges whose normals (E, 3) half-way, of the size of the chord's square, vanish."""
    vanishes: Bool = np.asarray(~(norm(middle) > PARALLEL * norm(mesh.edge_data.p1 - mesh.edge_data.p0) ** 2))
    refuse(scheme, mesh, vanishes, "has no normal half-way, where those of its ends cancel out")


def refuse(scheme: Scheme, mesh: HermiteMesh, unfit: Bool, why: str) -> None:
    """Raise Refused if any edge (E,) is unfit."""
    if unfit.any():
        i, j = mesh.edges[unfit][0].tolist()
        raise Refused(
            f"{scheme} takes no edge that {why}: the edge from vertex {i} to vertex {j}, the first of "
            f"{int(unfit.sum())}; check the normals"
        )
