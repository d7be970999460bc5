"""Tangent plane continuity of two cubic triangles: Peters' conditions for a quadratic and for a cubic boundary.

A boundary H_0 to H_3 with v_r = H_{r+1} - H_r carries the second rows F_0, F_1, F_2 of the cubic on one side and G_0,
G_1, G_2 of the one on the other (Mann 1992, section 2.2.4, figure 2.4). F_0 and F_2, G_0 and G_2 are given, in the
tangent planes at the ends; F_1 and G_1 are sought.

*Quadratic boundary*, raised to a cubic: each row by itself, from one field of tangent planes (equation 2.8),

    sum_r B^2_r(t) (F_r - H_r) = k(t) C(t) + h(t) ((1 - t) v_0 + t v_2),    C(t) = (1 - t) n0 x v_0 + t n1 x v_2,

k and h linear. *Cubic boundary*: both rows together, from

    a(t) sum_r B^2_r(t) v_r = b(t) sum_r B^2_r(t) (F_r - H_r) + c(t) sum_r B^2_r(t) (G_r - H_r),    a, b, c linear.

The end values of a, b, c follow from the data but for their scale, and the two inner coefficients are linear equations
for F_1 and G_1 with determinant 4 (b_0 c_1 - b_1 c_0).

Formulas: (2.8) as printed. The thesis describes the system for cubic boundaries and does not print it; **fill**: it is
written out here, with the scale b + c = 1 at both ends, which is the same for both sides and for the reversed edge.
"""

from dataclasses import dataclass

import numpy as np

from testbed.geometry.vectors import Float, cross, dot


def quadratic_boundary_point(
    curve: Float, start_leg: Float, end_leg: Float, start_normal: Float, end_normal: Float
) -> Float:
    """Return the middle point F1 of a cubic's second row along a quadratic boundary, (2.8).

    Parameters
    ----------
    curve
        (..., 4, 3) control points H of the boundary, a quadratic raised to a cubic; v_1 = (v_0 + v_2) / 2 is not read.
    start_leg, end_leg
        (..., 3) F0 - H0 and F2 - H3, in the tangent planes at the ends.
    start_normal, end_normal
        (..., 3) unit normals at the ends.

    Returns
    -------
    F1
        (..., 3); NaN where an end tangent of the boundary is zero.
    """
    v0, v2 = curve[..., 1, :] - curve[..., 0, :], curve[..., 3, :] - curve[..., 2, :]
    f0, f2 = start_leg, end_leg + v2
    across0, across2 = cross(start_normal, v0), cross(end_normal, v2)
    with np.errstate(invalid="ignore", divide="ignore"):  # no tangent: NaN
        k0, h0 = (dot(a, f0) / dot(a, a) for a in (across0, v0))
        k1, h1 = (dot(a, f2) / dot(a, a) for a in (across2, v2))
    twice = k0[..., None] * across2 + k1[..., None] * across0 + h0[..., None] * v2 + h1[..., None] * v0
    first: Float = curve[..., 1, :] + twice / 2.0
    return first


@dataclass(frozen=True, slots=True)
class CubicJoin:
    """The system for two cubics that share a cubic boundary.

    Parameters
    ----------
    curve
        (..., 4, 3) control points H of the boundary.
    f
        F_0 - H_0 and F_2 - H_2, (..., 3) each.
    g
        G_0 - H_0 and G_2 - H_2.
    a, b
        End values of a and b, (...) each; c = 1 - b. Where the two patches lie on different sides of the boundary, both
        b and c are above 0.
    """

    curve: Float
    f: tuple[Float, Float]
    g: tuple[Float, Float]
    a: tuple[Float, Float]
    b: tuple[Float, Float]

    @classmethod
    def between(
        cls,
        curve: Float,
        first: tuple[Float, Float],
        second: tuple[Float, Float],
        normals: tuple[Float, Float],
    ) -> "CubicJoin":
        """Find the end values of a and b.

        Parameters
        ----------
        curve
            (..., 4, 3) control points H of the boundary.
        first, second
            F0 - H0 and F2 - H3, G0 - H0 and G2 - H3, (..., 3) each, in the tangent planes at the ends.
        normals
            Unit normals at both ends, (..., 3) each.
        """
        v0, v2 = curve[..., 1, :] - curve[..., 0, :], curve[..., 3, :] - curve[..., 2, :]
        f, g = (first[0], first[1] + v2), (second[0], second[1] + v2)
        a0, b0 = _end_values(v0, f[0], g[0], normals[0])
        a1, b1 = _end_values(v2, f[1], g[1], normals[1])
        return cls(curve, f, g, (a0, a1), (b0, b1))

    @property
    def determinant(self) -> Float:
        """b_0 c_1 - b_1 c_0 = b_0 - b_1, (...), between -1 and 1 for patches on different sides of their boundary.

        Zero where F_0 P / G_0 P = F_2 Q / G_2 Q, with P and Q where the boundary's end tangents meet the segments F_0
        G_0 and F_2 G_2: the characterisation of data for which F_1 and G_1 may not exist.
        """
        return self.b[0] - self.b[1]

    @property
    def contradiction(self) -> Float:
        """How far the two equations contradict each other where the determinant is zero, (..., 3).

        (a_0 - a_1) (2 v_1 - v_0 - v_2): there is a solution if H_0 P / H_1 P = H_2 Q / H_3 Q, or if the boundary is a
        quadratic.
        """
        v0, v1, v2 = (self.curve[..., r + 1, :] - self.curve[..., r, :] for r in range(3))
        bend: Float = (self.a[0] - self.a[1])[..., None] * (2.0 * v1 - v0 - v2)
        return bend

    def right_sides(self) -> tuple[Float, Float]:
        """Right sides r, s, (..., 3), of 2 b_0 f_1 + 2 c_0 g_1 = r, 2 b_1 f_1 + 2 c_1 g_1 = s; f_1, g_1 from H_1."""
        (a0, a1), (b0, b1) = ([value[..., None] for value in pair] for pair in (self.a, self.b))
        v0, v1, v2 = (self.curve[..., r + 1, :] - self.curve[..., r, :] for r in range(3))
        r = 2.0 * a0 * v1 + a1 * v0 - b1 * self.f[0] - (1.0 - b1) * self.g[0]
        s = a0 * v2 + 2.0 * a1 * v1 - b0 * self.f[1] - (1.0 - b0) * self.g[1]
        return r, s

    def points(self) -> tuple[Float, Float]:
        """Return F1 and G1, (..., 3) each; not finite where the determinant is zero."""
        r, s = self.right_sides()
        b0, b1 = (value[..., None] for value in self.b)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):  # no solution: not finite
            scale = 0.5 / self.determinant[..., None]
            f, g = ((1.0 - b1) * r - (1.0 - b0) * s) * scale, (b0 * s - b1 * r) * scale
            start = self.curve[..., 1, :]
            return start + f, start + g


def _end_values(v: Float, f: Float, g: Float, normal: Float) -> tuple[Float, Float]:
    """Solve a v = b f + (1 - b) g in the plane of the normal for a and b; NaN where f - g is along v, or v is zero."""
    across = cross(normal, v)
    above, below = dot(across, f), dot(across, g)
    with np.errstate(invalid="ignore", divide="ignore"):
        b = -below / (above - below)
        a = (b * dot(v, f) + (1.0 - b) * dot(v, g)) / dot(v, v)
    return a, b
