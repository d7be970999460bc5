"""``export``: a surface as a file for other programs."""

from pathlib import Path
from typing import Annotated

import typer


def export(
    scheme: Annotated[str, typer.Argument(metavar="SCHEME", help="The scheme, as name or name\\[field=value,...].")],
    *,
    dataset: Annotated[str, typer.Option("-d", "--dataset", metavar="DATASET", help="The dataset.")],
    level: Annotated[int, typer.Option("--level", min=0, metavar="L", help="Level of the dataset.")] = 0,
    triangles: Annotated[
        int | None, typer.Option("--triangles", metavar="N", help="How many, about and at most. Default: 50000.")
    ] = None,
    field: Annotated[
        str | None,
        typer.Option(
            "--field", metavar="FIELD", help="Colours of a .glb file: gauss, mean or distance. Default: none."
        ),
    ] = None,
    limit: Annotated[
        float | None, typer.Option("--limit", help="Upper limit of their scale. Default: one that suits the values.")
    ] = None,
    tessellated: Annotated[
        bool, typer.Option("--tessellated", help="A .vtu file of triangles with fields, not of Bézier cells.")
    ] = False,
    split: Annotated[
        bool, typer.Option("--split", help="Vertices of their own for each patch in .ply and .vtu, none shared.")
    ] = False,
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The file: .glb, .ply, .obj, .vtu or .npz.")
    ],
) -> None:
    """Write a surface to a file for other programs; the suffix is the format.

    .glb, .ply, .obj: triangles with exact normals; .ply with curvatures and distances, .glb with one of them as
    colours. .vtu: the patches themselves, as Bézier cells, for ParaView. .npz: their control nets.
    """
    from rich.console import Console

    from testbed import registry
    from testbed.errors import SpecError
    from testbed_reports.export.formats import FIELDS, Request, check_request, export_surface

    chosen = next((one for one in FIELDS if one == field), None)
    if field is not None and chosen is None:
        raise SpecError(f"there is no field {field!r}: take {', '.join(FIELDS)}")
    data, fitted = registry.dataset(dataset), registry.scheme(scheme)
    request = Request(triangles, chosen, limit, tessellated, split)
    check_request(output, request, exact=data.surface is not None)
    written = export_surface(
        fitted.fit(data.mesh(level)),
        output,
        exact=data.surface,
        triangles=triangles,
        field=chosen,
        limit=limit,
        tessellated=tessellated,
        split=split,
        title=f"{fitted} on {data}, level {level}",
    )
    console = Console()
    console.print(f"{written.path}: {written.content}", markup=False, soft_wrap=True)
    for remark in written.remarks:
        console.print(remark, markup=False, style="dim", soft_wrap=True)
