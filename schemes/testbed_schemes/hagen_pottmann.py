"""Hagen and Pottmann's G2 scheme (Hagen and Pottmann 1989; Mann 1992, section 2.3.2): a blended patch a face.

Matches position, normal and second fundamental form at the vertices; neighbours share boundary curves, the normals and
the second fundamental forms along them, so the surface is G2. The boundary curves are the scheme's own. Towards a
vertex the curvature goes to that of the data, from every direction.

It is Nielson's scheme with curvature. A curve operator g_v joins two points with normals and second forms by a quintic

    H_5[V_0, V_1, V_0', V_1', V_0'', V_1''],   V' = lambda T,   V'' = lambda^2 kappa N + mu V',

with unit tangents T along the projected chord and kappa = -II(T, T) in the sign of this package. On each side of the
face stands such a curve X(s) with a field of tangent planes and second forms
(:mod:`testbed_schemes.continuity_conditions.hagen_pottmann`); each of its points is joined to the opposite vertex by
another. The three patches G_i, of which each has the three boundary curves and the fields of its own side, are blended:

    beta_i = b_j^2 b_k^2 / (b_0^2 b_1^2 + b_1^2 b_2^2 + b_2^2 b_0^2).   (2.14)

As 1 - beta_i vanishes with the square of the distance from side i, and the G agree there, the blend has the second
derivatives of G_i on side i.

Formulas: the blend and the form of g_v as printed. lambda is free there; the chord's length and that of an arc are
fills, and so are the fields, which are described in words. V'' is printed with kappa = <N, C''> / |C'|^2, of the sign
opposite to II in the same source; here II(T, T) enters with a minus. mu is printed as the length of a part along the
unit tangent; here it is relative to lambda, so that the surface scales with the data, and counts away from the vertex.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from testbed.errors import Refused
from testbed.geometry.blended import BlendedTriangles
from testbed.geometry.blocks import in_blocks
from testbed.geometry.composed import weighted_sum
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Bool, Float, cross, dot, norm, quadratic_form, tangential
from testbed.plugins.base import check_finite
from testbed.plugins.corners import check_corners, check_sides
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed_schemes.continuity_conditions.hagen_pottmann import (
    CurvatureField,
    EndField,
    curvature_field,
    end_field,
)
from testbed_schemes.mathematics.planar_frame import edge_normals
from testbed_schemes.mathematics.quintic_hermite import quintic_derivatives, quintic_deviation, quintic_weights
from testbed_schemes.mathematics.side_vertex import CORNER_MARGIN, J, K, separable_blend

#: Least cosine of the angle between a chord and its projection: computed from the sine, it has lost half of its digits
#: here, and all of them at the square.
SHADOW = 1e-4
#: Halvings of the angle between chord and tangent, to at most 5.6 degrees, before arcsin's series, and the ratios of
#: the coefficients of that: (2 m - 1)^2 / (2 m (2 m + 1)).
HALVINGS, SERIES = 4, (1 / 6, 9 / 20, 25 / 42, 49 / 72, 81 / 110, 121 / 156, 169 / 210)
#: Parameters of a side at which its fields are looked at before patches are built.
LOOKS = np.arange(9) / 8.0

Tangents: TypeAlias = Literal["chord", "arc"]


@dataclass(frozen=True)
class HagenPottmann(Scheme):
    """Hagen and Pottmann's curvature continuous scheme.

    Parameters
    ----------
    tangents
        lambda, the length of all tangents: ``chord``, the chord's length L, or ``arc``, that of a circular arc,
        L phi / sin phi with phi the angle between tangent and chord.
    mu
        Acceleration along the curves at their ends, away from the end, in units of the tangent there; planes keep their
        linear parametrisation at 0 only.

    Raises
    ------
    SpecError
        ``mu`` is not finite.
    """

    tangents: Tangents = "chord"
    mu: float = 0.0

    name = "hagen-pottmann"
    title = "Hagen-Pottmann"
    reference = "Hagen and Pottmann 1989; Mann 1992, section 2.3.2"
    formula = (
        "sum beta_i G_i, G_i quintic curves from vertex i to the opposite side, which carries a quintic curve with a "
        "field of tangent planes and second forms; beta_i = b_j^2 b_k^2 / (b_0^2 b_1^2 + b_1^2 b_2^2 + b_2^2 b_0^2)"
    )
    status = (
        "The weights (2.14) and the quintic operator as printed. Fills: lambda, the ends of the cubic cross-boundary "
        "field, and the third value of the curvature field, where the source blends conjugate directions."
    )
    failures = (
        "Second fundamental forms that bend the surface by more than about two radians along an edge make curves with "
        "loops, and curvature extremes far beyond the data; where the patch turns over at its sides it is refused. "
        "Edges along a normal are refused."
    )
    needs = Data.NORMALS | Data.SECOND_FORMS
    matches = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS
    continuity = Continuity.G2
    order = None
    reproduces = (Shape.PLANES,)

    def __post_init__(self) -> None:
        """Check the parameter."""
        check_finite(self, "mu")

    def construct(self, mesh: HermiteMesh) -> Surface:
        """Build one blended patch a face."""
        tangents = self.edge_tangents(mesh)
        check_corners(self, mesh, *tangents)
        check_sides(self, mesh, *tangents)
        points, normals = mesh.corner_points(), mesh.corner_normals()
        assert mesh.second_forms is not None  # noqa: S101 - needed, and checked before
        forms = mesh.second_forms[mesh.faces]
        # tangents at corner i towards corners i + 1 and i + 2
        to_j, to_k = points[:, J] - points, points[:, K] - points
        legs = np.stack([tangent(chord, normals, self.tangents) for chord in (to_j, to_k)], axis=2)
        data = {"points": points, "normals": normals, "forms": forms, "to_j": to_j, "to_k": to_k}
        data["side"], data["ends"], data["across"] = side_data(
            points[:, K] - points[:, J],
            (normals[:, J], normals[:, K]),
            (forms[:, J], forms[:, K]),
            (legs[:, J, 0], -legs[:, K, 1]),
            self.mu,
        )
        self.check_fields(mesh, data)
        formula = partial(hagen_pottmann_patch, tangents=self.tangents, mu=self.mu)
        return Surface.over_faces(mesh, BlendedTriangles(formula, data, points, legs, CORNER_MARGIN))

    def edge_tangents(self, mesh: HermiteMesh) -> tuple[Float, Float]:
        """Return the tangents of g_v at both ends of the edges, (E, 3) each, both away from their vertex.

        Refused if there are edges along the normal at one of their ends; the message names the first one's vertices.
        """
        edges = mesh.edge_data
        chord, normals = edges.p1 - edges.p0, edge_normals(edges)
        shadow = np.minimum(*(norm(tangential(chord, normal)) for normal in normals))
        undefined: Bool = np.asarray(~(shadow > SHADOW * norm(chord)))
        if undefined.any():
            i, j = mesh.edges[undefined][0].tolist()
            raise Refused(
                f"{self} takes no edge that is parallel to the normal at one of its ends: the edge from vertex {i} to "
                f"vertex {j}, the first of {int(undefined.sum())}; turn the normal or move the vertex"
            )
        return tangent(chord, normals[0], self.tangents), -tangent(chord, normals[1], self.tangents)

    def check_fields(self, mesh: HermiteMesh, data: Mapping[str, Float]) -> None:
        """Refuse sides whose tangent planes turn over, or over which the patch folds, between their ends.

        Looked at in a few points of each side; the message names the first such side's vertices.
        """

        def least(faces: slice) -> Float:
            """The least of numbers that are to be positive, (f, 3)."""
            side, ends, across, to_j = (data[name][faces, :, None] for name in ("side", "ends", "across", "to_j"))
            field = side_field(side, ends, across, LOOKS, LOOKS[::-1])
            # one step farther, the plane is seen from the same side
            turning = dot(field.normal[:, :, 1:], field.normal[:, :, :-1])
            # the vertex stays on one side of the curve, as seen along the normal
            chord = to_j + LOOKS[:, None] * side[..., 0, :] + quintic_deviation(side, LOOKS, LOOKS[::-1])
            off = dot(cross(field.normal, field.tangent), chord)
            numbers = np.concatenate([turning, np.sign(off[:, :, :1]) * off], axis=2)
            return np.asarray(numbers.min(axis=2))

        folds: Bool = np.asarray(~(in_blocks(least, len(mesh.faces)) > 0.0))
        if folds.any():
            face, i = (int(index[0]) for index in np.nonzero(folds))
            start, end = mesh.faces[face, J[i]], mesh.faces[face, K[i]]
            raise Refused(
                f"{self} folds over on {int(folds.sum())} of {folds.size} sides of faces, the first that of face "
                f"{face} from vertex {start} to vertex {end}, where the data bend too much for so long an edge: "
                "check the second fundamental forms and the normals, or refine the mesh"
            )


def side_data(
    chord: Float, normals: tuple[Float, Float], forms: tuple[Float, Float], tangents: tuple[Float, Float], mu: float
) -> tuple[Float, Float, Float]:
    """Return what a side's curve and fields are made of, from the data at its two ends.

    Parameters
    ----------
    chord
        (..., 3) from the first end to the second.
    normals, forms, tangents
        (..., 3), (..., 3, 3) and (..., 3) at the first and at the second end; the tangents as the curve runs.
    mu
        The parameter of the scheme.

    Returns
    -------
    side
        (..., 5, 3): chord, X'(0), X'(1), X''(0), X''(1).
    ends
        (..., 4, 3): D(0), D(1), D'(0), D'(1).
    across
        (..., 2): II(D, D) at the ends.
    """
    bends = [
        # kappa = -II(T, T): the curve bends to where the normal points if the surface is curved negatively
        sign * mu * t - quadratic_form(t, W, t)[..., None] * n
        for sign, t, W, n in zip((1.0, -1.0), tangents, forms, normals, strict=True)
    ]
    ends = [end_field(n, t, W) for n, t, W in zip(normals, tangents, forms, strict=True)]
    side = np.stack([chord, *tangents, *bends], axis=-2)
    fields = np.stack([*(end.across for end in ends), *(end.turn for end in ends)], axis=-2)
    return side, fields, np.stack([end.curvature for end in ends], axis=-1)


def side_field(side: Float, ends: Float, across: Float, s: Float, rest: Float) -> CurvatureField:
    """Return the fields of :func:`side_data` at ``s`` = 1 - ``rest``."""
    first, last = (EndField(ends[..., i, :], ends[..., 2 + i, :], across[..., i]) for i in range(2))
    return curvature_field(*quintic_derivatives(side, s, rest), first, last, s, rest)


def hagen_pottmann_patch(
    b0: Float,
    b1: Float,
    b2: Float,
    points: Float,
    normals: Float,
    forms: Float,
    to_j: Float,
    to_k: Float,
    side: Float,
    ends: Float,
    across: Float,
    tangents: Tangents,
    mu: float,
) -> Float:
    """Points (..., 3) of the patch.

    Parameters
    ----------
    points, normals, forms
        (..., 3, 3) vertices and normals, (..., 3, 3, 3) second fundamental forms.
    to_j, to_k
        (..., 3, 3) chords from each vertex to the next two.
    side, ends, across
        :func:`side_data` of the side opposite to each vertex.
    """

    def terms(r: Float, rest: Float, s: Float, rest_s: Float) -> tuple[tuple[Float, ...], tuple[Float, ...]]:
        # the side's point, seen from the flat side and from the vertex, and the fields there
        off_side = quintic_deviation(side, s, rest_s)
        chord = weighted_sum((rest_s, s), (to_j, to_k)) + off_side
        field = side_field(side, ends, across, s, rest_s)
        # the curve to it has tangents k (chord - height n), and normal parts -k^2 II n of second derivatives
        square, height0, height1 = (np.vecdot(chord, a) for a in (chord, normals, field.normal))
        k0, k1 = (stretch(sine2, tangents) for sine2 in (height0**2 / square, height1**2 / (square * field.square)))
        form0 = k0**2 * np.vecdot(chord, np.einsum("...ij,...j->...i", forms, chord))
        form1 = k1**2 * field.second_form(chord) / np.sqrt(field.square)
        leaving = k0[..., None] * (chord - height0[..., None] * normals)
        arriving = k1[..., None] * (chord - (height1 / field.square)[..., None] * field.normal)
        along, first, last, bend0, bend1 = quintic_weights(r, rest, mu)
        return (
            (r, along, first, -last, -bend0, -bend1),
            (off_side, chord, leaving, arriving, form0[..., None] * normals, form1[..., None] * field.normal),
        )

    # with the squares of (2.14)
    return separable_blend(terms, points, b0, b1, b2, 2)


def tangent(chord: Float, normal: Float, tangents: Tangents) -> Float:
    """Tangents (..., 3) of g_v: the chord projected onto the tangent plane, made as long as ``tangents`` says."""
    height, square = dot(chord, normal), dot(chord, chord)
    return stretch(height**2 / square, tangents)[..., None] * tangential(chord, normal)


def stretch(sine2: Float, tangents: Tangents) -> Float:
    """Factor (...) on the projected chord, from the square of the sine of its angle phi with the chord.

    1 / cos phi makes it as long as the chord. The arc's phi / (sin phi cos phi) needs care at phi = 0: by Viete,
    phi / sin phi is the product of 1 / cos(phi / 2^m) over some halvings, times theta / sin theta of the angle theta
    that is left; that is a power series of arcsin in sin^2 theta.
    """
    cosine = np.sqrt(1.0 - sine2)
    product = cosine
    if tangents == "chord":
        return 1.0 / product
    for _ in range(HALVINGS):
        sine2 = 0.5 * sine2 / (1.0 + cosine)
        cosine = np.sqrt(1.0 - sine2)
        product = product * cosine
    series: Float = 1.0 + sine2 * SERIES[-1]
    for ratio in SERIES[-2::-1]:
        series = 1.0 + series * sine2 * ratio
    return series / product
