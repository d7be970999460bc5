"""The torus in quadrilaterals, with samples at the centres of the faces."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.vectors import Float
from testbed.plugins.dataset import Dataset
from testbed_datasets.parameters import finite, positive
from testbed_datasets.quad_halving import halved_quads, quad_centres
from testbed_datasets.torus import STEPS, RoundTorus, around


@dataclass(frozen=True)
class QuadTorus(Dataset):
    """Torus, 10 steps around the axis and 5 around the tube: 50 vertices, 50 quadrilaterals.

    Every face has a plane of symmetry, and so have its solutions of the bicubic centre: they come in mirror images,
    none nearer than the other. ``twist=1`` shears the faces.

    Parameters
    ----------
    major
        Radius R of the core circle.
    minor
        Radius r of the tube, less than ``major``.
    phase
        Shift of the rows around the tube, from the outer equator upward, as a fraction of level 0's row step of 72
        degrees; 0 <= phase < 1. At 0 finer levels have rows exactly on the top and bottom circles.
    twist
        Steps around the axis by which a column is turned on its way around the tube.
    """

    major: float = 1.0
    minor: float = 0.5
    phase: float = 0.15
    twist: int = 0

    name = "quad-torus"
    title = "Torus of quadrilaterals"
    reference = "Mann 1992, figures 4.2 and 4.4; its mesh and radii are not printed"
    closed = True
    finest = 4

    def __post_init__(self) -> None:
        positive(self.name, major=self.major, minor=self.minor)
        finite(self.name, phase=self.phase)
        if self.minor >= self.major:
            raise SpecError(
                f"parameter minor of {self.name} cannot be {self.minor}: the tube meets itself, give less than "
                f"major = {self.major}"
            )
        if not 0.0 <= self.phase < 1.0:
            raise SpecError(f"parameter phase of {self.name} cannot be {self.phase}: give a fraction from 0 to below 1")
        if abs(self.twist) > MOST_TWIST:
            raise SpecError(
                f"parameter twist of {self.name} cannot be {self.twist}: faces would be needles, give {-MOST_TWIST} to "
                f"{MOST_TWIST}"
            )

    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, halved in the two angles; Refused if there is none."""
        columns, rows = (int(steps) for steps in STEPS)
        column, row = (index.ravel() for index in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
        # the last row meets the first one ``twist`` columns on
        above = np.where(row + 1 == rows, column + self.twist, column)
        next_row = (row + 1) % rows

        def vertex(i: Any, j: Any) -> Any:
            return i % columns * rows + j

        corners = [vertex(column, row), vertex(column + 1, row), vertex(above + 1, next_row), vertex(above, next_row)]
        start = np.stack([column + self.twist * row / rows, row], axis=-1)
        steps, faces = halved_quads(start, np.stack(corners, axis=-1), level, name=self.name, middle=around)
        return self.surface.sample(self._at(steps), faces, self._at(quad_centres(steps, faces, around)))

    def _at(self, steps: Float) -> Float:
        """Points (N, 3) at steps (N, 2) around the axis and around the tube."""
        u, v = (2.0 * np.pi * (steps + np.array([0.0, self.phase])) / STEPS).T
        rho = self.major + self.minor * np.cos(v)
        return np.stack([rho * np.cos(u), rho * np.sin(u), self.minor * np.sin(v)], axis=-1)

    @property
    def surface(self) -> RoundTorus:
        """The torus."""
        return RoundTorus(self.major, self.minor)


#: Columns may be turned by so many steps.
MOST_TWIST = 3
