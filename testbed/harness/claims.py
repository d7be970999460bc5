"""What schemes claim against what was measured: met, missed, exceeded, or not testable, a row a claim and dataset."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING, Final

from testbed.harness.plan import Plan, PlannedDataset, PlannedScheme

if TYPE_CHECKING:
    import pandas as pd

#: Degrees between normals at an edge that count as none.
SMOOTH_DEG: Final = 1e-8
#: Difference of the second fundamental forms of neighbours at an edge, relative to them, that counts as none; and of
#: those of blended patches from the data, relative to the inverse of the diameter: second derivatives of blends lose up
#: to half of their digits near corners.
CURVED: Final = 1e-6
#: Distance between neighbours at an edge that counts as none, relative to the diameter of the mesh.
CLOSED: Final = 1e-12
#: Distance to the exact surface, relative to the same, and angle to its normals in degrees, that count as reproduction.
EXACT: Final = 1e-10
EXACT_DEG: Final = 1e-6

#: Data at the vertices, the column that tells how far the surface is from them, and what of it counts as none.
INTERPOLATED: Final = {
    "POINTS": ("vertex_distance_max", CLOSED),
    "NORMALS": ("vertex_normal_max_deg", SMOOTH_DEG),
    "SECOND_FORMS": ("vertex_form_max", 1e-8),
}

#: Kinds of surfaces that a dataset of some shape is an example of.
EXAMPLE_OF: Final = {"planes": ("planes", "quadrics"), "spheres": ("spheres", "quadrics"), "quadrics": ("quadrics",)}


@dataclass(frozen=True)
class Verdict:
    """How a claim of a scheme stands on a dataset.

    Parameters
    ----------
    scheme
        Text of the scheme.
    claim
        ``continuity G1``, ``order 4``, ``reproduces spheres``, ``matches NORMALS``.
    dataset
        Text of the dataset; empty where the claim could be tested on none.
    verdict
        ``met``, ``missed``, ``exceeded`` or ``not testable``.
    measured
        The number that decided it, NaN if none did.
    reason
        One line that says which number it is, or why there is none.
    """

    scheme: str
    claim: str
    dataset: str
    verdict: str
    measured: float
    reason: str


def verdicts(plan: Plan, cells: "pd.DataFrame", orders: "pd.DataFrame") -> list[Verdict]:
    """Return the verdicts on all claims, by scheme in the plan's order.

    Parameters
    ----------
    plan
        The plan.
    cells, orders
        As in :class:`testbed.harness.results.Results`.
    """
    return [verdict for scheme in plan.schemes for verdict in _of_scheme(scheme, plan, cells, orders)]


def _of_scheme(scheme: PlannedScheme, plan: Plan, cells: "pd.DataFrame", orders: "pd.DataFrame") -> Iterator[Verdict]:
    own = cells[cells["scheme"] == scheme.spec]
    by_dataset = [
        (dataset, own[own["dataset"] == dataset.spec])
        for dataset in plan.datasets
        if (scheme.spec, dataset.spec) in plan.pairs
    ]
    for dataset, rows in by_dataset:
        yield _continuity(scheme, dataset, rows)
    yield from _orders(scheme, plan, orders)
    yield from _reproductions(scheme, by_dataset)
    for data in scheme.matches:
        for dataset, rows in by_dataset:
            yield _interpolation(scheme, dataset, data, rows)


def _orders(scheme: PlannedScheme, plan: Plan, orders: "pd.DataFrame") -> Iterator[Verdict]:
    if scheme.order is None:
        return
    # on a plane there is rounding only, and reproduction is the claim to test
    curved = [dataset.spec for dataset in plan.datasets if dataset.shape != "planes"]
    chosen = orders[(orders["scheme"] == scheme.spec) & (orders["quantity"] == "distance_max")]
    chosen = chosen[chosen["dataset"].isin(curved)]
    names = ("dataset", "verdict", "order", "low", "high", "levels_used", "reason")
    for spec, text, order, low, high, used, reason in zip(*(chosen[name] for name in names), strict=True):
        fitted = f"order {order:.2f}, {low:.2f} to {high:.2f}, over levels {used}" if used else ""
        yield Verdict(
            scheme.spec, f"order {scheme.order:g}", spec, text, order, "; ".join(filter(None, [fitted, reason]))
        )


def _reproductions(scheme: PlannedScheme, by_dataset: "list[tuple[PlannedDataset, pd.DataFrame]]") -> Iterator[Verdict]:
    tested = set()
    for dataset, rows in by_dataset:
        for shape in EXAMPLE_OF.get(dataset.shape or "", ()):
            judged = _reproduction(scheme, dataset, shape, rows)
            if judged is not None:
                tested.add(shape)
                yield judged
    for shape in scheme.reproduces:
        if shape not in tested:
            reason = f"no dataset of the plan is declared an example of {shape}"
            yield Verdict(scheme.spec, f"reproduces {shape}", "", "not testable", nan, reason)


def _continuity(scheme: PlannedScheme, dataset: PlannedDataset, own: "pd.DataFrame") -> Verdict:
    def verdict(text: str, measured: float, reason: str) -> Verdict:
        return Verdict(scheme.spec, f"continuity {scheme.continuity}", dataset.spec, text, measured, reason)

    ok = own[own["status"] == "ok"]
    obstacle = _obstacle(own, ("gap_max", "epsilon_deg"))
    if obstacle:
        return verdict("not testable", nan, obstacle)
    if "interior_edges" in ok and not (ok["interior_edges"] > 0).any():
        return verdict("not testable", nan, "the surfaces have no edges between patches")
    gap, epsilon = float(ok["gap_max"].max()), float(ok["epsilon_deg"].max())
    partly = _partly(own)
    # written so that NaN, were there one, would miss
    if not gap <= CLOSED * float(ok["diameter"].max()):
        return verdict("missed", gap, f"gap_max {gap:.3g} on {_worst(ok, 'gap_max')}{partly}")
    smooth = epsilon <= SMOOTH_DEG
    if scheme.continuity == "C0":
        better = smooth and dataset.shape != "planes"  # there, any faces join smoothly
        return verdict("exceeded" if better else "met", gap, f"gap_max {gap:.3g}, epsilon_deg {epsilon:.3g}{partly}")
    if not smooth:
        return verdict("missed", epsilon, f"epsilon_deg {epsilon:.3g} on {_worst(ok, 'epsilon_deg')}{partly}")
    if scheme.continuity == "G1":
        return verdict("met", epsilon, f"epsilon_deg {epsilon:.3g}, gap_max {gap:.3g}{partly}")
    if scheme.continuity != "G2" or "curvature_jump_max" not in ok:
        return verdict("not testable", epsilon, f"G1 is met, and no measure reads off more than that{partly}")
    jump = float(ok["curvature_jump_max"].max(skipna=False))
    if not jump <= CURVED:
        return verdict("missed", jump, f"curvature_jump_max {jump:.3g} on {_worst(ok, 'curvature_jump_max')}{partly}")
    return verdict("met", jump, f"curvature_jump_max {jump:.3g}, epsilon_deg {epsilon:.3g}{partly}")


def _reproduction(scheme: PlannedScheme, dataset: PlannedDataset, shape: str, own: "pd.DataFrame") -> Verdict | None:
    """Return the verdict, or None where there is neither a claim nor a reproduction."""

    def verdict(text: str, measured: float, reason: str) -> Verdict:
        return Verdict(scheme.spec, f"reproduces {shape}", dataset.spec, text, measured, reason)

    claimed = shape in scheme.reproduces
    if not claimed and shape != dataset.shape:
        return None  # that a plane is a quadric, too, is nothing to boast of
    obstacle = _obstacle(own, ("distance_max", "normal_max_deg"))
    if obstacle:
        return verdict("not testable", nan, obstacle) if claimed else None
    ok = own[own["status"] == "ok"]
    distance, angle = float(ok["distance_max"].max()), float(ok["normal_max_deg"].max())
    reproduced = distance <= EXACT * float(ok["diameter"].max()) and angle <= EXACT_DEG
    if not (claimed or reproduced):
        return None
    text = ("met" if claimed else "exceeded") if reproduced else "missed"
    reason = f"distance_max {distance:.3g}, normal_max_deg {angle:.3g}{_partly(own)}"
    return verdict(text, distance, reason)


def _interpolation(scheme: PlannedScheme, dataset: PlannedDataset, data: str, own: "pd.DataFrame") -> Verdict:
    if data == "CENTRES":
        return _at_centres(scheme, dataset, own)
    column, bound = INTERPOLATED[data]

    def verdict(text: str, measured: float, reason: str) -> Verdict:
        return Verdict(scheme.spec, f"matches {data.lower().replace('_', ' ')}", dataset.spec, text, measured, reason)

    # the claim ends where the scheme says that it had to depart from its construction
    departed = own["fallbacks"].fillna(0) > 0 if data == "SECOND_FORMS" and "fallbacks" in own else own["level"] < 0
    if len(own) and departed.all():
        return verdict("not testable", nan, "every level has fallbacks, and the claim ends there")
    obstacle = _obstacle(own[~departed], (column,))
    if obstacle:
        return verdict("not testable", nan, obstacle)
    ok = own[~departed & (own["status"] == "ok")]
    # distances are relative to the mesh, curvatures to its inverse
    power = {"POINTS": -1, "NORMALS": 0, "SECOND_FORMS": 1}[data]
    error = float((ok[column] * ok["diameter"] ** power).max())
    if data == "SECOND_FORMS" and "curvature_corner_margin" in ok and (ok["curvature_corner_margin"] > 0.0).any():
        bound = CURVED  # limits of blended patches, extrapolated
    left_out = f" (without {int(departed.sum())} levels with fallbacks)" if departed.any() else ""
    return verdict(
        "met" if error <= bound else "missed",
        error,
        f"{column} {error:.3g}, relative to the size{left_out}{_partly(own)}",
    )


def _at_centres(scheme: PlannedScheme, dataset: PlannedDataset, own: "pd.DataFrame") -> Verdict:
    """Judge the claim to match the samples at face centres: no more faces miss them than are noted as fallbacks."""

    def verdict(text: str, measured: float, reason: str) -> Verdict:
        return Verdict(scheme.spec, "matches centres", dataset.spec, text, measured, reason)

    obstacle = _obstacle(own, ("centres_missed", "fallbacks"))
    if obstacle:
        return verdict("not testable", nan, obstacle)
    ok = own[own["status"] == "ok"]
    missed, faces, noted = (int(ok[column].sum()) for column in ("centres_missed", "faces", "fallbacks"))
    if missed == faces:
        return verdict("not testable", nan, "every face has a fallback, and the claim ends there")
    kept = bool((ok["centres_missed"] <= ok["fallbacks"]).all())
    reason = f"{missed} of {faces} faces miss their samples, {noted} fallbacks are noted{_partly(own)}"
    return verdict("met" if kept else "missed", missed, reason)


def _obstacle(own: "pd.DataFrame", columns: tuple[str, ...]) -> str:
    """Return why columns cannot be judged on a dataset, or nothing."""
    absent = [column for column in columns if column not in own]
    if absent:
        return f"no measure gives {absent[0]}"
    ok = own[own["status"] == "ok"]
    if ok.empty:
        if own.empty:
            return "not computed yet"
        return f"no cell is ok: {own['reason'].iloc[0]}"
    if ok[list(columns)].isna().any(axis=None):
        return f"there is no {' or '.join(columns)} on this dataset"
    return ""


def _partly(own: "pd.DataFrame") -> str:
    bad = own[own["status"] != "ok"]
    if bad.empty:
        return ""
    levels = ", ".join(f"{level} {status}" for level, status in zip(bad["level"], bad["status"], strict=True))
    return f" (without level {levels})"


def _worst(ok: "pd.DataFrame", column: str) -> str:
    return f"level {ok['level'].iloc[int(ok[column].to_numpy().argmax())]}"
