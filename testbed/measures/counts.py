"""What is counted: the size of the surface, and the fallbacks that were taken while it was built."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from testbed.plugins.measure import Column, Measure, Survey, Value


@dataclass(frozen=True)
class Size(Measure):
    """Vertices, faces, patches and edge length."""

    name: ClassVar[str] = "size"
    title: ClassVar[str] = "Size"
    reference: ClassVar[str] = "a count"
    columns: ClassVar[tuple[Column, ...]] = (
        Column("vertices", "vertices of the mesh"),
        Column("faces", "faces of the mesh"),
        Column("patches", "patches of the surface"),
        Column("h", "length of the longest edge of the mesh"),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns."""
        mesh = survey.surface.mesh
        return {
            "vertices": len(mesh.points),
            "faces": len(mesh.faces),
            "patches": survey.surface.patch_count,
            "h": mesh.h,
        }


@dataclass(frozen=True)
class Fallbacks(Measure):
    """What a scheme or its curves had to do differently, and which of its ways were taken, as surfaces note."""

    name: ClassVar[str] = "fallbacks"
    title: ClassVar[str] = "Fallbacks taken"
    reference: ClassVar[str] = "a count"
    columns: ClassVar[tuple[Column, ...]] = (
        Column("fallbacks", "fallbacks taken while the surface was built, all kinds together"),
        Column("notes", "the fallbacks by kind, for instance '3 curves without a root; 1 singular centres'"),
        Column("branches", "the ordinary ways its construction took, where it has several, by kind", optional=True),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns."""
        surface = survey.surface
        result: dict[str, Value] = {"fallbacks": sum(surface.notes.values()), "notes": listed(surface.notes)}
        if surface.branches:
            result["branches"] = listed(surface.branches)
        return result


def listed(counts: Mapping[str, int]) -> str:
    """Text of counts by kind, those that are not zero, in alphabetical order."""
    return "; ".join(f"{count} {kind}" for kind, count in sorted(counts.items()) if count)
