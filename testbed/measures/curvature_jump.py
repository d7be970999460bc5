"""How the curvature joins: the difference of the second fundamental forms on the two sides of an edge."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.edges import PatchEdges
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.geometry.vectors import Float, norm
from testbed.measures.continuity import NEAR_ENDS, edge_jets, grained, interior_edges, largest
from testbed.measures.sampling import CHUNK
from testbed.plugins.measure import Column, Measure, Survey, Value

#: Fewest and most intervals between the samples of an edge.
INTERVALS = (4, 32)


@dataclass(frozen=True)
class CurvatureJump(Measure):
    """Largest difference of second fundamental forms over the edges between patches, inner edges of split faces too.

    The forms are matrices in space, so that their difference knows of no parameters: its Frobenius norm, relative to
    the larger of the two norms plus one over the mesh's diameter, which keeps rounding in flat places from counting.
    Surfaces with continuous tangent planes differ across their edges only; others differ in their planes too.

    Edges are sampled, many edges only in part; the largest samples are searched further. A surface without edges
    between patches has nothing that could jump, and its maximum is 0.

    Parameters
    ----------
    budget
        Samples on all edges together, about; an edge that is looked at has at least 5, and where they are too many for
        that, some are looked at, evenly chosen.
    candidates
        Edges in which a maximum is searched for.
    """

    budget: int = 6_000
    candidates: int = 16

    name: ClassVar[str] = "curvature-jump"
    title: ClassVar[str] = "Curvature jump between patches"
    reference: ClassVar[str] = "a comparison along the edges"
    columns: ClassVar[tuple[Column, ...]] = (
        Column(
            "curvature_jump_max",
            "largest difference of second fundamental forms across an edge, relative to the larger plus 1/diameter; "
            f"on blended patches not nearer to the ends than {NEAR_ENDS[0]:g} of the edge",
        ),
        Column("curvature_jump_face", "mesh face of the largest curvature jump, on the left of the edge; -1 for none"),
        Column("curvature_jump_bary", "place of the largest curvature jump in the face"),
    )

    def measure(self, survey: Survey) -> Mapping[str, Value]:
        """Return the columns."""
        surface = survey.surface
        edges = interior_edges(surface)
        count = len(edges)
        intervals = int(np.clip(self.budget // max(count, 1) - 1, *INTERVALS))
        blended = any(batch.corner_margin > 0.0 for batch in surface.batches)
        t = jump_parameters(intervals, NEAR_ENDS[0] if blended else 0.0)
        looked_at = min(count, max(1, self.budget // len(t)))
        edges = edges[np.linspace(0, count - 1, looked_at, dtype=np.int64)]
        jumps = np.empty((1, len(edges), len(t)))
        step = max(1, CHUNK // len(t))
        for start in range(0, len(edges), step):
            some = slice(start, start + step)
            jumps[:, some] = curvature_jumps(surface, edges[some], t)
        (jump,) = largest(surface, edges, t, jumps, self.candidates, curvature_jumps)
        return {
            "curvature_jump_max": jump.value,
            "curvature_jump_face": jump.face,
            "curvature_jump_bary": jump.bary(surface.mesh.sides) if len(edges) else "",
        }


def jump_parameters(intervals: int, margin: float) -> Float:
    """Even parameters (T,) from ``margin`` to 1 - ``margin``, symmetric under t -> 1 - t to the last bit."""
    half = grained(margin + (1.0 - 2.0 * margin) * np.arange(intervals // 2 + 1) / intervals)
    return np.unique(np.concatenate([half, 1.0 - half]))


def curvature_jumps(surface: Surface, edges: PatchEdges, t: Float) -> Float:
    """Return relative differences of second fundamental forms, (1, E, T), at parameters (T,) or (E, T) of edges."""
    # patches that are not finite have NaN for a jump, without a warning
    with np.errstate(invalid="ignore", over="ignore"):
        left, right = (second_form_matrix(jet).reshape(*jet.f.shape[:-1], 9) for jet in edge_jets(surface, edges, t, 2))
        scale = np.maximum(norm(left), norm(right)) + 1.0 / diameter(surface.mesh)
        return np.asarray(norm(left - right) / scale)[None]


def diameter(mesh: HermiteMesh) -> float:
    """Twice the largest distance of a vertex from the mean of all: unlike a bounding box, it turns with the mesh."""
    return 2.0 * float(norm(mesh.points - mesh.points.mean(axis=0)).max())
