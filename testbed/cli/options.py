"""Options that several commands take, with their help."""

from pathlib import Path
from typing import Annotated

import typer

Json = Annotated[bool, typer.Option("--json", help="Print JSON for machines instead of tables.")]
Pdf = Annotated[bool, typer.Option("--pdf", help="Write report.pdf too: the page on paper, with every number.")]
Schemes = Annotated[
    list[str] | None,
    typer.Option(
        "-s", "--scheme", metavar="SCHEME", help="A scheme, as name or name\\[field=value,...]; may be repeated."
    ),
]
Datasets = Annotated[
    list[str] | None,
    typer.Option("-d", "--dataset", metavar="DATASET", help="A dataset, as name\\[field=value,...] or mesh:PATH."),
]
Levels = Annotated[
    str | None,
    typer.Option("--levels", metavar="A:B", help="Levels A to B, both included. Default: each dataset's own."),
]
Boundaries = Annotated[
    list[str] | None,
    typer.Option(
        "-b",
        "--boundary",
        metavar="CURVE",
        help="Compute schemes on a curve network with these boundary curves too; all for all; may be repeated.",
    ),
]
Complete = Annotated[
    bool, typer.Option("--all", help="All levels, where a plain run leaves out the finest to be done in minutes.")
]
Jobs = Annotated[
    int | None, typer.Option("-j", "--jobs", min=1, metavar="N", help="Worker processes. Default: one a processor.")
]
Directory = Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Where the results are kept.")]

Studied = Annotated[str, typer.Argument(metavar="SCHEME", help="The scheme, as name or name\\[field=value,...].")]
StudiedData = Annotated[
    list[str], typer.Option("-d", "--dataset", metavar="DATASET", help="A dataset; may be repeated.")
]
Level = Annotated[str, typer.Option("--level", metavar="L", help="Level of the datasets.")]
Maximise = Annotated[bool, typer.Option("--maximise", help="Look for large values instead of small ones.")]
