"""What schemes claim to match at the vertices is judged on every dataset, from a real run."""

from pathlib import Path

import pandas as pd
import pytest

from testbed.harness.plan import make_plan
from testbed.harness.results import read_results
from testbed.harness.run import run


@pytest.fixture(scope="module")
def claims(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    directory: Path = tmp_path_factory.mktemp("claims")
    schemes = ["flat", "pn-triangle", "cubic-interpolant"]
    run(make_plan(schemes, ["octahedron", "torus[phase=0]", "mesh", "plane"], "0"), directory)
    return read_results(directory).claims


@pytest.fixture(scope="module")
def centre_verdicts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[str, str]]:
    directory: Path = tmp_path_factory.mktemp("centres")
    datasets = ["quad-torus", "quad-torus[twist=1]", "quad-graph"]
    run(make_plan(["bicubic-interpolant"], datasets, "0", ["interpolation", "fallbacks", "size"]), directory)
    claims = read_results(directory).claims
    chosen = claims[claims["claim"] == "matches centres"]
    return {row["dataset"]: (row["verdict"], row["reason"]) for _, row in chosen.iterrows()}


def test_samples_at_centres_are_matched_where_no_fallback_is_noted(
    centre_verdicts: dict[str, tuple[str, str]],
) -> None:
    assert centre_verdicts["quad-graph"] == ("met", "0 of 12 faces miss their samples, 0 fallbacks are noted")
    assert centre_verdicts["quad-torus[twist=1]"][0] == "met"
    assert centre_verdicts["quad-torus"] == ("not testable", "every face has a fallback, and the claim ends there")


@pytest.fixture(scope="module")
def verdicts(claims: pd.DataFrame) -> dict[tuple[str, str, str], str]:
    return {(row["scheme"], row["claim"], row["dataset"]): row["verdict"] for _, row in claims.iterrows()}


def test_what_is_matched_is_met(verdicts: dict[tuple[str, str, str], str]) -> None:
    for dataset in ("octahedron", "torus[phase=0.0]", "mesh", "plane"):
        assert verdicts["flat", "matches points", dataset] == "met"
        assert verdicts["pn-triangle", "matches normals", dataset] == "met"
    assert verdicts["cubic-interpolant", "matches second forms", "octahedron"] == "met"


def test_a_claim_that_ends_at_a_fallback_is_not_judged_there(verdicts: dict[tuple[str, str, str], str]) -> None:
    """Twenty diagonals of the published torus have no geometric Hermite curve."""
    assert verdicts["cubic-interpolant", "matches second forms", "torus[phase=0.0]"] == "not testable"
    assert verdicts["cubic-interpolant", "matches normals", "torus[phase=0.0]"] == "met"


def test_the_reason_says_that_every_level_has_fallbacks(claims: pd.DataFrame) -> None:
    chosen = (claims["scheme"] == "cubic-interpolant") & (claims["claim"] == "matches second forms")
    (reason,) = claims.loc[chosen & (claims["dataset"] == "torus[phase=0.0]"), "reason"]
    assert "every level has fallbacks" in reason


def test_a_refused_scheme_has_matched_nothing(verdicts: dict[tuple[str, str, str], str]) -> None:
    assert verdicts["cubic-interpolant", "matches points", "mesh"] == "not testable"


def test_what_is_not_claimed_is_not_judged(verdicts: dict[tuple[str, str, str], str]) -> None:
    assert ("flat", "matches normals", "octahedron") not in verdicts


def test_a_plane_is_nothing_to_boast_of(verdicts: dict[tuple[str, str, str], str]) -> None:
    found = {claim: verdict for (_, claim, dataset), verdict in verdicts.items() if dataset == "plane"}
    assert "exceeded" not in found.values()
    assert found["reproduces planes"] == "met"
    assert not [claim for claim in found if claim.startswith("order")]
    assert "reproduces quadrics" not in found
