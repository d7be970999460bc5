"""Jets: value, first and second derivatives of a patch at sample points, and the differential geometry read off them.

Signs: n = f_u x f_v normalised, II(u, v) = -<D_uv f, n>; curvature is positive where the surface bends away from its
normal (unit sphere with outward normal: both principal curvatures +1).
"""

from dataclasses import dataclass

from testbed.geometry.vectors import Float, cross, dot, unit

#: Rows of a jet of order 0, 1, 2.
ROWS = (1, 3, 6)


@dataclass(frozen=True, slots=True)
class Jet:
    """Derivatives up to an order at sample points.

    Parameters
    ----------
    coefficients
        (1, ..., 3), (3, ..., 3) or (6, ..., 3): f | f_u, f_v | f_uu, f_uv, f_vv; usually (6, patches, samples, 3).
        Only values are promised, not the memory layout.
    """

    coefficients: Float

    @property
    def order(self) -> int:
        """0, 1 or 2."""
        return ROWS.index(len(self.coefficients))

    def _row(self, index: int) -> Float:
        if index >= len(self.coefficients):
            raise ValueError(f"this jet stops at order {self.order}: ask the patch for a higher order")
        row: Float = self.coefficients[index]
        return row

    @property
    def f(self) -> Float:
        """Points, (..., 3)."""
        return self._row(0)

    @property
    def fu(self) -> Float:
        """First derivatives along u, (..., 3)."""
        return self._row(1)

    @property
    def fv(self) -> Float:
        """First derivatives along v, (..., 3)."""
        return self._row(2)

    @property
    def fuu(self) -> Float:
        """Second derivatives along u, (..., 3)."""
        return self._row(3)

    @property
    def fuv(self) -> Float:
        """Mixed second derivatives, (..., 3)."""
        return self._row(4)

    @property
    def fvv(self) -> Float:
        """Second derivatives along v, (..., 3)."""
        return self._row(5)

    @property
    def normal(self) -> Float:
        """Unit normals f_u x f_v / |f_u x f_v|, (..., 3); NaN where the parametrisation is singular."""
        return unit(cross(self.fu, self.fv))

    @property
    def first_form(self) -> tuple[Float, Float, Float]:
        """E, F, G of the first fundamental form, (...) each."""
        return dot(self.fu, self.fu), dot(self.fu, self.fv), dot(self.fv, self.fv)

    @property
    def second_form(self) -> tuple[Float, Float, Float]:
        """L, M, N of the second fundamental form in the parameters, (...) each; II = -<D f, n>."""
        n = self.normal
        return -dot(self.fuu, n), -dot(self.fuv, n), -dot(self.fvv, n)
