"""Algebraic surfaces: the zero sets of polynomials in x, y, z that are given as text."""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Final

import numpy as np

from testbed.errors import Refused, SpecError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float, Int
from testbed.plugins.dataset import Dataset
from testbed_datasets.algebraic_start import TooCoarse, place, refined, start_mesh
from testbed_datasets.algebraic_surface import AlgebraicSurface, Corner
from testbed_datasets.halving import check_level
from testbed_datasets.polynomial import Evaluated
from testbed_datasets.polynomial_text import parse_polynomial
from testbed_datasets.polynomial_zeros import singular_place

#: Sides of a box are at least this long relative to its largest coordinate, and to its longest side.
SHORTEST_SIDE: Final = 1e-3
#: Coordinates of a box lie between these.
SMALLEST, LARGEST = 1e-12, 1e12
#: Cells along the longest side, at most and as advised.
MOST_CELLS, TRIED_CELLS = 64, (5, 6, 8, 12, 16)
#: As much of a polynomial is repeated in a message.
SHOWN: Final = 60


@dataclass(frozen=True)
class Algebraic(Dataset):
    """The surface P(x, y, z) = 0 of a polynomial P within a box, ``algebraic:POLYNOMIAL``, normals to where P grows.

    The start mesh comes from marching cubes, is projected onto the surface and made even; levels halve its edges, and
    their middles are projected along the gradient. Closed surfaces have to lie within the box; the box cuts others
    off, and boundary vertices stay on its sides and on the surface.

    Parameters
    ----------
    polynomial
        Numbers, x, y, z, ``+``, ``-``, ``*``, ``/`` by numbers, ``**`` or ``^`` with whole numbers, and parentheses; of
        degree 20 at most. It is read, never executed.
    box
        Half the side of a cube about the origin, or ``(x0 y0 z0 x1 y1 z1)``, the corners of a box.
    cells
        Cells of the start mesh's grid along the longest side of what bounds the surface within the box.
    flip
        Whether normals point to where P falls.
    """

    polynomial: str = "4*x**2+2*y**2+z**2-4"
    box: float | tuple[float, float, float, float, float, float] = 3.0
    cells: int = 4
    flip: bool = False

    name = "algebraic"
    title = "Algebraic surface"
    reference = "Mann 1992, section 5.4.1; the start mesh of figure 5.2 is lost"
    formula = "P(x, y, z) = 0, n = grad P/|grad P|, II(u, v) = u . H v/|grad P| with the Hessian H of P"
    status = (
        "The normal and the second form as printed (5.4.1), by the gradient and the Hessian, which equal the printed "
        "blossoms. A fill: the start mesh, of which the thesis says only that it is a variation of marching cubes."
    )
    failures = (
        "Refused: surfaces with a singular point in the box, or nearly so; surfaces too thin or bent too much for the "
        "cells."
    )
    positional: ClassVar[str | None] = "polynomial"
    closed: ClassVar[bool | None] = None
    finest = 4
    effort = 4.0

    def __post_init__(self) -> None:
        parse_polynomial(self.polynomial, f"the polynomial of {self.name}")
        corners = np.array(self._corners)
        sides = corners[1] - corners[0]
        if not np.isfinite(corners).all() or not SMALLEST <= np.abs(corners).max() <= LARGEST:
            raise SpecError(f"parameter box of {self.name} cannot be {self.box}: give lengths about 1")
        if (sides <= SHORTEST_SIDE * max(np.abs(corners).max(), sides.max())).any():
            raise SpecError(
                f"parameter box of {self.name} cannot be {self.box}: give a positive number, or the lowest x, y, z and "
                "then the highest, with no side much shorter than the others"
            )
        if not 1 <= self.cells <= MOST_CELLS:
            raise SpecError(f"parameter cells of {self.name} cannot be {self.cells}: give 1 to {MOST_CELLS}")

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level.

        Raises
        ------
        Refused
            There is no such level; the surface has no point in the box, or a singular one, or is too thin for the
            cells: the message names the place.
        """
        check_level(level, 1, self.name)
        points, faces = self._start
        check_level(level, len(faces), self.name)
        for halving in range(level):
            points, faces = refined(self.surface, points, faces)
            if not np.isfinite(points).all():
                raise Refused(f"{self._what} bends too much for level {halving + 1} with {self.cells} cells: take more")
        return self.surface.sample(points, faces)

    @property
    def surface(self) -> AlgebraicSurface:
        """The surface; it goes on beyond the box."""
        return self._surface

    @cached_property
    def _surface(self) -> AlgebraicSurface:
        polynomial = parse_polynomial(self.polynomial)
        low, high = self._corners
        return AlgebraicSurface(Evaluated.over(-polynomial if self.flip else polynomial, low, high), low, high)

    @property
    def _corners(self) -> tuple[Corner, Corner]:
        if isinstance(self.box, tuple):
            x0, y0, z0, x1, y1, z1 = self.box
            return (x0, y0, z0), (x1, y1, z1)
        return (-self.box,) * 3, (self.box,) * 3

    @cached_property
    def _start(self) -> tuple[Float, Int]:
        """Vertices (V, 3) and faces (F, 3) of level 0, of a surface that is proved to be regular in the box."""
        surface = self.surface
        doubt = singular_place(surface.evaluated, np.array(surface.low), np.array(surface.high))
        if doubt is not None:
            where = place(doubt.place)
            why = (
                f"has a singular point at {where}, where the polynomial and its gradient vanish"
                if doubt.proved
                else f"has too small a gradient near {where} to be told from a singular surface"
            )
            raise Refused(f"{self._what} {why}: take a box without that place, or another polynomial")
        try:
            return start_mesh(surface, self.cells, self._what)
        except TooCoarse as error:
            raise Refused(f"{error.reason}: {self._advice()}") from None

    def _advice(self) -> str:
        """What to do about too few cells: the first number of cells, of some tried, with which there is a mesh."""
        for cells in TRIED_CELLS:
            if cells > self.cells:
                try:
                    start_mesh(self.surface, cells, self._what)
                except Refused:
                    continue
                return f"take cells={cells}"
        return f"take another box or many more cells, {max(TRIED_CELLS[-1], self.cells)} are too few"

    @property
    def _what(self) -> str:
        text = self.polynomial if len(self.polynomial) <= SHOWN else f"{self.polynomial[: SHOWN - 3]}..."
        return f"{self.name}:{text}"
