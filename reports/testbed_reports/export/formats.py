"""Files by their suffix: what each format holds of a surface, and what it loses."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Final, get_args

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.exact import ExactSurface
from testbed.geometry.surface import Surface
from testbed_reports.export.bezier_cells import bezier_cells
from testbed_reports.export.glb import Field, glb
from testbed_reports.export.nets import nets
from testbed_reports.export.obj import obj
from testbed_reports.export.ply import ply
from testbed_reports.export.tessellation import TRIANGLES, Tessellation, tessellate
from testbed_reports.export.vertices import by_patch, by_place
from testbed_reports.export.vtu import bezier_vtu, triangle_vtu

FIELDS: Final[tuple[Field, ...]] = get_args(Field)
#: What the fields are.
NAMES: Final = {"gauss": "Gaussian curvature", "mean": "mean curvature", "distance": "distance"}
SUFFIXES: Final = (".glb", ".ply", ".obj", ".vtu", ".npz")


@dataclass(frozen=True)
class Request:
    """How a surface is to be written.

    Parameters
    ----------
    triangles
        Triangles of a tessellation, about and at most; None for the usual number.
    field
        What the colours of a GLB file show; None for nothing.
    limit
        Upper limit of their scale; None for one that suits the values.
    tessellated
        Whether a VTU file holds triangles instead of Bézier cells.
    split
        Whether every patch has vertices of its own in PLY and VTU files.
    """

    triangles: int | None = None
    field: Field | None = None
    limit: float | None = None
    tessellated: bool = False
    split: bool = False


@dataclass(frozen=True)
class Exported:
    """What was written.

    Parameters
    ----------
    path
        The file.
    content
        What it holds, in a few words.
    remarks
        What the file loses of the surface, a sentence each; they stand in the file too.
    """

    path: Path
    content: str
    remarks: tuple[str, ...]


def export_surface(
    surface: Surface,
    path: str | PathLike[str],
    *,
    exact: ExactSurface | None = None,
    triangles: int | None = None,
    field: Field | None = None,
    limit: float | None = None,
    tessellated: bool = False,
    split: bool = False,
    title: str = "",
) -> Exported:
    """Write a surface to a file for other programs, in the format of its suffix.

    ``.glb``, ``.ply`` and ``.obj`` hold triangles with the patches' exact normals; ``.ply`` the curvatures and
    distances too, ``.glb`` one of them as colours. ``.vtu`` holds the patches themselves as Bézier cells of VTK, or,
    ``tessellated``, triangles with all fields; ``.npz`` the control nets. The same surface gives the same bytes.

    Neighbouring patches share a vertex where they agree to 1e-12 of the size of the mesh, so that triangles of a
    surface without gaps have none. In ``.ply`` and ``.vtu`` such a vertex has the mean of the patches' values and their
    deviation from it, or, with ``split``, every patch has a vertex of its own at the same place; in ``.glb`` patches
    share it if their normals and colours are equal, and in ``.obj`` every patch keeps its normal.

    Parameters
    ----------
    surface
        The surface.
    path
        The file; its directory is made.
    exact
        The surface that it approximates, for distances.
    triangles
        How many, about and at most; None for 50000.
    field
        ``gauss``, ``mean`` or ``distance``: what the colours of a GLB file show. None for one colour.
    limit
        Upper limit of the colours' scale; None for one that suits the values.
    tessellated, split
        See above.
    title
        What the surface is, kept in the file.

    Raises
    ------
    SpecError
        The suffix is no format, an option says nothing in that format, or the file cannot be written.
    TestbedError
        The patches are no Bézier patches where the format needs them, or have points that are no numbers.
    """
    path, request = Path(path), Request(triangles, field, limit, tessellated, split)
    check_request(path, request, exact=exact is not None)
    data, content, remarks = _file(surface, path.suffix.lower(), request, exact, title)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    except OSError as error:
        raise SpecError(f"{path} cannot be written ({error.strerror}): choose another place") from error
    return Exported(path, content, remarks)


def check_request(path: Path, request: Request, *, exact: bool) -> None:
    """Refuse what a format cannot do before anything is computed; SpecError, one sentence."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise SpecError(f"{path} does not end in the name of a format: take {', '.join(SUFFIXES)}")
    if request.field is not None and request.field not in FIELDS:
        raise SpecError(f"there is no field {request.field!r}: take {', '.join(FIELDS)}")
    if (request.field is not None or request.limit is not None) and suffix != ".glb":
        raise SpecError(f"field and limit are about the colours of .glb files: leave them out for {path}")
    if request.limit is not None and (request.field is None or not 0.0 < request.limit < np.inf):
        raise SpecError(f"a scale cannot end at the limit {request.limit:g}: give a positive number, with a field")
    if request.field == "distance" and not exact:
        raise SpecError("there is no exact surface to take distances from: choose another field")
    if request.tessellated and suffix != ".vtu":
        raise SpecError(f"tessellated is about .vtu files, and the others have one form only: leave it out for {path}")
    cells = suffix == ".npz" or (suffix == ".vtu" and not request.tessellated)
    if request.triangles is not None and cells:
        raise SpecError(f"{path} holds the patches themselves: leave out the number of triangles, or write .ply")
    if request.triangles is not None and not 0 < request.triangles <= 20_000_000:
        raise SpecError(f"{request.triangles} triangles cannot be made: ask for 1 to 20000000")
    if request.split and (suffix not in (".ply", ".vtu") or cells):
        raise SpecError(f"split is about the triangles of .ply and .vtu files: leave it out for {path}")


def _file(
    surface: Surface, suffix: str, request: Request, exact: ExactSurface | None, title: str
) -> tuple[bytes, str, tuple[str, ...]]:
    """Return the bytes of the file, what it holds, and what it loses."""
    named = (title,) if title else ()
    if suffix == ".npz":
        return nets(surface, named), f"{surface.patch_count} control nets", ()
    if suffix == ".vtu" and not request.tessellated:
        cells = bezier_cells(surface)
        return bezier_vtu(cells, named), f"{len(cells.types)} Bézier cells", ()
    triangles = TRIANGLES if request.triangles is None else request.triangles
    # distances cost most, and are not looked at where they are not written
    wanted = suffix in (".ply", ".vtu") or request.field == "distance"
    one = tessellate(surface, triangles, exact if wanted else None)
    content = f"{len(one.triangles)} triangles"
    remarks = (_chords(one), *_lost(one, suffix, request))
    texts = (*named, *remarks)
    if suffix == ".glb":
        return glb(one, request.field, request.limit, texts), content, remarks
    if suffix == ".obj":
        return obj(one, texts), content, remarks
    vertices = by_patch(one) if request.split else by_place(one)
    write = ply if suffix == ".ply" else triangle_vtu
    return write(vertices, one, texts), content, remarks


def _chords(one: Tessellation) -> str:
    return f"{len(one.triangles)} flat triangles stand for the surface; their corners lie on it"


def _lost(one: Tessellation, suffix: str, request: Request) -> tuple[str, ...]:
    """What a format loses of the values at the points, a sentence each."""
    lost = []
    bare = int(np.isnan(one.normals).any(axis=1).sum())
    if suffix == ".obj":
        lost.append("OBJ has no fields: curvatures and distances are left out")
    if suffix == ".glb":
        lost.append("GLB is single precision; curvatures and distances are left out, but for the colours")
    if suffix in (".glb", ".obj") and bare:
        lost.append(f"{bare} points of patches without a normal there have that of the triangles around them")
    if suffix == ".glb" and request.field is not None:
        blank = int(np.isnan(one.scalars[request.field]).sum())
        if blank:
            name = NAMES[request.field]
            lost.append(f"{blank} points of patches without a {name} there have the colour around them")
    if suffix in (".ply", ".vtu"):
        if not request.split:
            lost.append(
                "where patches meet, values are means of the patches', and deviations tell how far those are off"
            )
        flat = int(np.isnan(one.gauss).sum())
        if flat:
            lost.append(f"{flat} points of patches without a curvature there have NaN")
    return tuple(lost)
