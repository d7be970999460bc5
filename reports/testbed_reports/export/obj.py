"""OBJ files of triangles: a vertex for each place and every patch's own normals, which the format keeps apart."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from testbed_reports.export.ply import one_line
from testbed_reports.export.tessellation import Tessellation
from testbed_reports.export.vertices import distinct, shared_normals

#: Normals of patches at one place up to this far apart are one.
AGREEMENT: Final = 1e-10


def obj(tessellation: Tessellation, remarks: Sequence[str]) -> bytes:
    """Return a file: vertices to all digits, and normals, those of patches that agree at a vertex written once.

    A group of triangles ``face<number>`` for each mesh face.
    """
    leader = np.unique(tessellation.place, return_index=True)[1]
    normals = shared_normals(tessellation, AGREEMENT)
    own, ids = distinct(np.concatenate([tessellation.place[:, None].astype(np.float64), normals], axis=1))
    corners, of_corners = tessellation.place[tessellation.triangles], ids[tessellation.triangles]
    lines = [f"# {one_line(remark)}" for remark in remarks]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in tessellation.points[leader].tolist()]
    lines += [f"vn {x!r} {y!r} {z!r}" for x, y, z in normals[own].tolist()]
    order = np.argsort(tessellation.face, kind="stable")
    face = -1
    rows = np.concatenate([corners, of_corners], axis=1)[order] + 1
    for number, (a, b, c, of_a, of_b, of_c) in zip(tessellation.face[order].tolist(), rows.tolist(), strict=True):
        if number != face:
            lines.append(f"g face{number}")
            face = number
        lines.append(f"f {a}//{of_a} {b}//{of_b} {c}//{of_c}")
    return ("\n".join(lines) + "\n").encode("ascii")
