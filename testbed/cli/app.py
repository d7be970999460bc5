"""Commands, their options and their help; exit codes: 0 all cells ok or refused, 1 some failed, 2 bad usage."""

import os
import sys
import traceback
from pathlib import Path
from typing import Annotated

import typer

from testbed.cli.differing import diff
from testbed.cli.exporting import export
from testbed.cli.options import (
    Boundaries,
    Complete,
    Datasets,
    Directory,
    Jobs,
    Json,
    Level,
    Levels,
    Maximise,
    Pdf,
    Schemes,
    Studied,
    StudiedData,
)
from testbed.cli.rendering import render

app = typer.Typer(
    name="testbed",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help=(
        "Compare surface interpolation schemes: convergence order, curvature extremes and normal jumps, measured.\n\n"
        "[dim]Examples:[/dim]  testbed run  |  testbed run -s nielson -d torus --levels 0:2  |  testbed info nielson"
    ),
)


@app.callback()
def options(
    *,
    show_traceback: Annotated[
        bool, typer.Option("--traceback", help="Show where an error was raised, with any command.")
    ] = False,
) -> None:
    """Take the options that stand before the command; ``main`` looks for them itself, wherever they stand."""
    del show_traceback


@app.command(
    epilog="[dim]Example:[/dim]  testbed run -s 'shirman-sequin\\[boundary=hermite]' -s nielson -d torus -o out"
)
def run(
    *,
    schemes: Schemes = None,
    datasets: Datasets = None,
    levels: Levels = None,
    boundaries: Boundaries = None,
    complete: Complete = False,
    jobs: Jobs = None,
    output: Directory = Path("results"),
    timeout: Annotated[float, typer.Option(min=0.001, metavar="SECONDS", help="What a cell may take.")] = 300.0,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Compute failed cells again.")] = False,
    parquet: Annotated[bool, typer.Option("--parquet", help="Write results.parquet too.")] = False,
    pdf: Pdf = False,
    as_json: Json = False,
) -> None:
    """Compute schemes x datasets x levels, and write tables and a page; what was computed before is reused.

    A plain run takes all schemes to levels that are done in a few minutes, and says what it leaves out.
    """
    from testbed.cli.running import Grid, run_command

    raise typer.Exit(
        run_command(
            Grid(schemes, datasets, levels, boundaries, complete=complete),
            jobs,
            output,
            timeout,
            retry_failed=retry_failed,
            parquet=parquet,
            pdf=pdf,
            as_json=as_json,
        )
    )


@app.command(epilog="[dim]Example:[/dim]  testbed plan -d torus --levels 0:5")
def plan(
    *,
    schemes: Schemes = None,
    datasets: Datasets = None,
    levels: Levels = None,
    boundaries: Boundaries = None,
    complete: Complete = False,
    output: Directory = Path("results"),
    as_json: Json = False,
) -> None:
    """Show what a run would compute, what it would reuse, and what will be refused, without computing it."""
    from testbed.cli.running import Grid, plan_command

    plan_command(Grid(schemes, datasets, levels, boundaries, complete=complete), output, as_json=as_json)


@app.command("list", epilog="[dim]Example:[/dim]  testbed list schemes")
def list_plugins(
    kind: Annotated[
        str | None, typer.Argument(metavar="[KIND]", help="schemes, curves, datasets, measures or reports; else all.")
    ] = None,
    *,
    as_json: Json = False,
) -> None:
    """List what is registered, and what could not be imported."""
    from testbed.cli.listing import list_command

    list_command(kind, as_json=as_json)


@app.command(epilog="[dim]Example:[/dim]  testbed info shirman-sequin")
def info(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A scheme, boundary curve, dataset, measure or report.")],
    *,
    as_json: Json = False,
) -> None:
    """Tell what a plugin is: citation, claims, parameters with their defaults, and its documentation."""
    from testbed.cli.describing import info_command

    info_command(name, as_json=as_json)


@app.command(epilog="[dim]Example:[/dim]  testbed check 'triangular-gregory\\[boundary=hermite]'")
def check(
    names: Annotated[
        list[str], typer.Argument(metavar="SCHEME...", help="Schemes, as name or name\\[field=value,...].")
    ],
    *,
    as_json: Json = False,
) -> None:
    """Check every claim of a scheme and every property it owes; exit code 1 if one fails, with its witness."""
    from testbed.cli.checking import check_command

    raise typer.Exit(check_command(names, as_json=as_json))


@app.command(epilog="[dim]Example:[/dim]  testbed catalogue -o catalogue")
def catalogue(*, output: Directory = Path("catalogue"), jobs: Jobs = None) -> None:
    """Check everything registered, and write a page that tells what each scheme and boundary curve is.

    Exit code 1 if a check failed.
    """
    from testbed.cli.cataloguing import catalogue_command

    raise typer.Exit(catalogue_command(output, jobs))


@app.command(epilog="[dim]Example:[/dim]  testbed report results")
def report(
    directory: Annotated[Path, typer.Argument(metavar="[DIR]", help="A directory that a run has written.")] = Path(
        "results"
    ),
    *,
    pdf: Pdf = False,
    as_json: Json = False,
) -> None:
    """Write the reports of a finished or interrupted run again, and print its tables."""
    from testbed.cli.running import report_command

    raise typer.Exit(report_command(directory, pdf=pdf, as_json=as_json))


@app.command(epilog="[dim]Example:[/dim]  testbed reproduce mann-1992 -o reproduction")
def reproduce(
    paper: Annotated[str, typer.Argument(metavar="PAPER", help="A paper, as mann-1992; or all.")],
    *,
    output: Directory = Path("reproduction"),
    jobs: Jobs = None,
    as_json: Json = False,
) -> None:
    """Measure the numbers that a paper prints, draw its figures again, and show both next to the printed ones.

    Differences are explained; index.html has the figures beside their numbers, and what is not made again. Exit code 1
    if a number could not be measured or a difference has no explanation.
    """
    from testbed.cli.reproducing import reproduce_command

    raise typer.Exit(reproduce_command(paper, output, jobs, as_json=as_json))


@app.command(
    epilog="[dim]Example:[/dim]  testbed sweep 'jensen\\[boundary=hermite]' --over jensen_c=0.9:1.4:26 -d octahedron"
)
def sweep(
    scheme: Studied,
    *,
    over: Annotated[
        list[str],
        typer.Option(
            "--over", metavar="NAME=VALUES", help="A parameter, as name=low:high:count or name=a,b,c; once or twice."
        ),
    ],
    datasets: StudiedData,
    level: Level = "0",
    measures: Annotated[
        list[str] | None,
        typer.Option(
            "--measure",
            metavar="QUANTITY",
            help="A column of the results, or gauss_spread, mean_spread, gauss_ratio, gauss_error, mean_error; may be "
            "repeated. Default: gauss_spread.",
        ),
    ] = None,
    maximise: Maximise = False,
    jobs: Jobs = None,
    output: Directory = Path("sweep"),
    as_json: Json = False,
) -> None:
    """Compute a scheme at all values of one or two parameters, plot what becomes of it, and print the best values."""
    from testbed.cli.studying import Study, sweep_command

    study = Study(scheme, datasets, level, over, measures or ["gauss_spread"], maximise, jobs, output)
    raise typer.Exit(sweep_command(study, as_json=as_json))


@app.command(epilog="[dim]Example:[/dim]  testbed tune 'shirman-sequin\\[boundary=hermite]' -d octahedron")
def tune(
    scheme: Studied,
    *,
    datasets: StudiedData,
    level: Level = "0",
    minimise: Annotated[
        str,
        typer.Option(
            "--minimise",
            metavar="QUANTITY",
            help="A column of the results, or gauss_spread, mean_spread, gauss_ratio, gauss_error, mean_error.",
        ),
    ] = "gauss_spread",
    maximise: Annotated[
        str | None, typer.Option("--maximise", metavar="QUANTITY", help="The same, to be made large instead.")
    ] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="NAME[=LOW:HIGH]",
            help="A real parameter; may be repeated. Default: all that the scheme declares bounds for.",
        ),
    ] = None,
    jobs: Jobs = None,
    output: Directory = Path("tune"),
    as_json: Json = False,
) -> None:
    """Search for the values of a scheme's real parameters at which a quantity is smallest, and print what that gains.

    On several datasets a setting counts by the one where it gains least on the scheme as given.
    """
    from testbed.cli.studying import Study, tune_command

    study = Study(scheme, datasets, level, over or [], [maximise or minimise], maximise is not None, jobs, output)
    raise typer.Exit(tune_command(study, as_json=as_json))


@app.command(epilog="[dim]Example:[/dim]  testbed approximate ellipsoid --epsilon 0.4 --distance 1e-3 -o ellipsoid")
def approximate(
    dataset: Annotated[
        str,
        typer.Argument(
            metavar="DATASET", help="What to approximate, as name\\[field=value,...]; level 0 is the start."
        ),
    ],
    *,
    epsilon: Annotated[
        float,
        typer.Option("--epsilon", metavar="DEG", help="Largest angle between the normals of neighbouring patches."),
    ],
    distance: Annotated[
        float | None,
        typer.Option("--distance", metavar="D", help="Largest distance to the exact surface. Default: any."),
    ] = None,
    scheme: Annotated[
        str, typer.Option("-s", "--scheme", metavar="SCHEME", help="A scheme, as name or name\\[field=value,...].")
    ] = "cubic-interpolant[boundary=hermite[guard=(0.15 0.75)],reach=0.2]",
    split: Annotated[
        str, typer.Option(metavar="RULE", help="How triangles are split: longest-edge, or template (Mann 1992).")
    ] = "longest-edge",
    criterion: Annotated[
        str,
        typer.Option(metavar="HOW", help="The angle counts anywhere on an edge (exact) or at ten places (sampled)."),
    ] = "exact",
    steps: Annotated[int, typer.Option(min=0, metavar="N", help="Most refinements.")] = 40,
    most_faces: Annotated[int, typer.Option(min=1, metavar="N", help="Most faces of a mesh.")] = 50_000,
    least_angle: Annotated[float, typer.Option(min=0.0, metavar="DEG", help="Smallest angle of a face.")] = 0.5,
    output: Directory = Path("approximation"),
    as_json: Json = False,
) -> None:
    """Approximate a dataset's exact surface: refine its mesh until all bounds are reached, or say what prevents it.

    Exit code 1 if a bound was not reached.
    """
    from testbed.cli.approximating import Task, approximate_command

    task = Task(dataset, scheme, epsilon, distance, split, criterion, steps, most_faces, least_angle, output)
    raise typer.Exit(approximate_command(task, as_json=as_json))


@app.command(epilog="[dim]Example:[/dim]  testbed costs branch")
def costs(
    dataset: Annotated[
        str, typer.Argument(metavar="DATASET", help="A network of S-patches: branch, ring or network:PATH.")
    ],
    *,
    triangles: Annotated[
        int | None,
        typer.Option(min=1, metavar="N", help="Cubic triangles to compare with. Default: as many as are published."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Count what S-patches cost to store and to evaluate, and cubic triangles in their place."""
    from testbed.cli.costing import costs_command

    costs_command(dataset, triangles, as_json=as_json)


app.command(
    epilog="[dim]Example:[/dim]  testbed render shirman-sequin nielson -d torus --style gauss -o torus.png\n\n"
    "[dim]Example:[/dim]  testbed render --curves hermite projected -d octahedron -o curves.png"
)(render)
app.command(epilog="[dim]Example:[/dim]  testbed diff before after --fail-on regressed")(diff)
app.command(epilog="[dim]Example:[/dim]  testbed export nielson -d torus --level 1 --field gauss -o torus.glb")(export)


@app.command(epilog="[dim]Example:[/dim]  testbed ranges --sets 4 -o ranges")
def ranges(
    *,
    output: Directory = Path("ranges"),
    sets: Annotated[
        int | None, typer.Option("--sets", min=1, metavar="N", help="The first N sets of data only. Default: all.")
    ] = None,
    jobs: Jobs = None,
    pictures: Annotated[bool, typer.Option(help="Draw the surfaces of every set.")] = True,
    as_json: Json = False,
) -> None:
    """Compare surfaces over data above a plane: who stays above it, who stays smooth, who is nearer the truth.

    Exit code 1 if a surface failed; refusals are results.
    """
    from testbed.cli.ranging import ranges_command

    raise typer.Exit(ranges_command(output, sets, jobs, pictures=pictures, as_json=as_json))


def main() -> None:
    """Run the command line and leave with its exit code."""
    # numpy reads these when it is imported; results do not depend on the number of threads, and workers are the threads
    for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    from testbed.errors import TestbedError

    arguments = [argument for argument in sys.argv[1:] if argument != "--traceback"]
    try:
        app(args=arguments, prog_name="testbed")
    except TestbedError as error:
        if len(arguments) < len(sys.argv) - 1:
            traceback.print_exc()
        print(f"testbed: {error}", file=sys.stderr)  # noqa: T201 - the command line speaks here
        sys.exit(2)
