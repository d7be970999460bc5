"""Rows of a comparison above planes, made up, and a small comparison that is quick to measure."""

from dataclasses import replace

from testbed_reports.range_comparison import ComparedScheme, RangeSet
from testbed_reports.range_tables import RangeRow

SCHEMES = (
    ComparedScheme("plain", "clough-tocher"),
    ComparedScheme("clipped", "clough-tocher[clip=true]", against="plain"),
    ComparedScheme("flat", "flat"),
    ComparedScheme("by normals", "clough-tocher[gradients=data]", uses="normals"),
)
WITH_TRUTH = RangeSet("scattered[points=12,ground=0.001]")
WITHOUT = RangeSet("scattered[points=12,field=noise,normals=none,ground=0.001]")
CLOSED = RangeSet("lifted[of=octahedron,level=0,plane={plane}]", plane=(0.3, -0.2, 1.0, 0.1))

GOOD = RangeRow(
    "first", 0, "(0.0 0.0 1.0 0.0)", "good", "good[plane=(0.0 0.0 1.0 0.0)]", "points", "wild", "ok",
    faces=8, patches=8, lowest=0.01, lowest_bound=0.005, epsilon_deg=1e-12, crease_deg=0.0, gap_max=0.0, data_max=0.0,
    rms=0.02, distance_max=0.1, moved=0.03, seconds=0.5, branches="2 edges with shortened tangents; 3 faces kept",
)  # fmt: skip
WILD = replace(GOOD, label="wild", scheme="wild", against="", lowest=-0.2, lowest_bound=-0.3, rms=0.01, branches="")
SHARP = replace(
    GOOD, label="sharp", scheme="sharp", lowest=0.0, lowest_bound=float("nan"), crease_deg=30.0, rms=0.04, notes=""
)
ROWS = (
    GOOD,
    WILD,
    SHARP,
    replace(GOOD, dataset="second", rms=float("nan"), moved=0.05),
    replace(WILD, dataset="second", rms=float("nan"), lowest=-0.5),
    replace(SHARP, dataset="second", status="refused", reason="sharp <takes> no such data"),
)
