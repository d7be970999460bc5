"""Datasets: meshes of growing density and, where there is one, the exact surface they were sampled from."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from testbed.geometry.charted import ChartedMesh
from testbed.geometry.exact import ExactSurface
from testbed.geometry.mesh import HermiteMesh
from testbed.plugins.base import Plugin
from testbed.plugins.scheme import Shape


@dataclass(frozen=True)
class Dataset(Plugin):
    """A family of meshes; a frozen dataclass whose fields are its parameters.

    Attributes
    ----------
    closed
        Whether the meshes have no boundary; None where it depends on the parameters.
    finest
        The highest level that a plain run computes; level 0 is the coarsest.
    effort
        What measuring against its exact surface makes of the cost of a cell, as a factor: 1 where nearest points have
        closed formulas or take a few steps. Used to plan runs.
    compared
        Whether schemes are compared on it where no dataset is named. Not so on data made for one purpose: a surface
        that samples miss, where schemes without guaranteed distances would seem exact; data close above a plane.
    shape
        What its exact surface is, where a scheme may claim to reproduce that; None for any other surface.
    """

    closed: ClassVar[bool | None]
    finest: ClassVar[int]
    effort: ClassVar[float] = 1.0
    compared: ClassVar[bool] = True
    shape: ClassVar[Shape | None] = None
    required: ClassVar[tuple[str, ...]] = (*Plugin.required, "closed", "finest")

    @abstractmethod
    def mesh(self, level: int) -> HermiteMesh:
        """Return the mesh of a level, each halving the edges of the one before.

        Raises
        ------
        Refused
            There is no such level.
        """

    @property
    @abstractmethod
    def surface(self) -> ExactSurface | None:
        """The exact surface, or None."""

    def charted(self) -> ChartedMesh | None:
        """Return the mesh of level 0 with its place in the surface's charts, or None if the surface has none.

        New vertices are then found in the charts; those of a surface without charts are projected onto it.
        """
        return None
