"""Everything registered passes the suite, and the suite finds each defect that it is there to find."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from testbed.conformance.subject import Status, Subject
from testbed.conformance.suite import CHECKS, check, run
from testbed.errors import Refused
from testbed.geometry.bezier import BezierTriangles
from testbed.geometry.mesh import HermiteMesh
from testbed.geometry.surface import Surface
from testbed.plugins.boundary import BoundaryCurve
from testbed.plugins.scheme import Continuity, Data, Scheme, Shape
from testbed.registry import catalogue, scheme

#: Claims that are published, and do not hold as they stand; strict: one that comes to hold fails the test.
EXPECTED_FAILURES: dict[tuple[str, str], str] = {
    ("bicubic-interpolant", "order"): "conjectured to be six, and is four: nearly multiple roots",
}
#: And those that fail on some boundary curves, though on the default ones the suite cannot tell.
EXPECTED_ON_CURVES = {("zero-twist-bicubic", "order")} | set(EXPECTED_FAILURES)


#: Schemes that take any boundary curve.
ON_NETWORKS = [name for name, one in catalogue(Scheme).items() if "boundary" in one.__dataclass_fields__]  # type: ignore[type-abstract]


@cache
def subject(spec: str) -> Subject:
    return Subject.of(scheme(spec))


@pytest.mark.parametrize("name", CHECKS)
@pytest.mark.parametrize("spec", catalogue(Scheme))  # type: ignore[type-abstract]
def test_every_registered_scheme_has_the_property(spec: str, name: str, request: pytest.FixtureRequest) -> None:
    if (spec, name) in EXPECTED_FAILURES:
        request.applymarker(pytest.mark.xfail(reason=EXPECTED_FAILURES[spec, name], strict=True))
    outcome = run(name, subject(spec))
    assert outcome.status is not Status.FAILED, outcome.detail


@pytest.mark.parametrize("curve", catalogue(BoundaryCurve))  # type: ignore[type-abstract]
@pytest.mark.parametrize("spec", ON_NETWORKS)
def test_a_scheme_on_a_network_keeps_its_claims_on_every_boundary_curve(spec: str, curve: str) -> None:
    under_check = Subject.of(scheme(f"{spec}[boundary={curve}]"))
    failed = [name for name in CHECKS if run(name, under_check).status is Status.FAILED]
    assert set(failed) <= {name for one, name in EXPECTED_ON_CURVES if one == spec}


@pytest.mark.parametrize("spec", catalogue(Scheme))  # type: ignore[type-abstract]
def test_every_registered_scheme_accepts_most_of_the_meshes(spec: str) -> None:
    found = subject(spec)
    least = 1 if found.scheme.restricted else len(found.refused) + 1
    assert len(found.accepted) >= least, found.refused


@dataclass(frozen=True)
class Honest(Scheme):
    """Flat triangles, with every claim they can keep."""

    name = "honest"
    title = "Honest"
    reference = "nobody"
    needs = Data.POINTS
    matches = Data.POINTS
    continuity = Continuity.C0
    order: float | None = None  # type: ignore[misc]  # a field here, so that one class serves many claims
    reproduces = (Shape.PLANES,)

    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return mesh.corner_points().copy()

    def construct(self, mesh: HermiteMesh) -> Surface:
        return Surface.over_faces(mesh, BezierTriangles(self.net(mesh)))


@dataclass(frozen=True)
class OffTheVertex(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return super().net(mesh) + 1e-9


@dataclass(frozen=True)
class OneNan(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        net = super().net(mesh)
        net[-1, 0, 0] = np.nan
        return net


@dataclass(frozen=True)
class Torn(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        net = super().net(mesh)
        net[0] += 1e-6
        return net


@dataclass(frozen=True)
class ClaimsNormals(Honest):
    matches = Data.POINTS | Data.NORMALS


@dataclass(frozen=True)
class ClaimsTangentPlanes(Honest):
    continuity = Continuity.G1


@dataclass(frozen=True)
class ClaimsCurvature(Honest):
    continuity = Continuity.G2
    matches = Data.POINTS | Data.SECOND_FORMS


def curvature_continuous() -> Scheme:
    """A scheme with continuous tangent planes that claims curvature continuity."""
    smooth = next(one for one in catalogue(Scheme).values() if one.continuity is Continuity.G1)  # type: ignore[type-abstract]
    return dataclass(frozen=True)(type("ClaimsMore", (smooth,), {"continuity": Continuity.G2}))()


def matching_second_forms(name: str) -> Scheme:
    """A scheme on blended patches, whose curvature at a vertex depends on the direction, that claims to match it."""
    every = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS
    return dataclass(frozen=True)(type("ClaimsMore", (catalogue(Scheme)[name],), {"needs": every, "matches": every}))()  # type: ignore[type-abstract]


def claims_centres() -> Scheme:
    """A scheme on quadrilaterals that does not look at the samples at their centres and claims to match them."""
    zero_twist = catalogue(Scheme)["zero-twist-bicubic"]  # type: ignore[type-abstract]
    every = Data.POINTS | Data.NORMALS | Data.SECOND_FORMS | Data.CENTRES
    return dataclass(frozen=True)(type("ClaimsMore", (zero_twist,), {"needs": every, "matches": every}))()


@dataclass(frozen=True)
class ClaimsSpheres(Honest):
    reproduces = (Shape.SPHERES, Shape.QUADRICS)


@dataclass(frozen=True)
class LikesTheOrigin(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return super().net(mesh) * 1.001


@dataclass(frozen=True)
class HasALengthOfItsOwn(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        net = super().net(mesh)
        return np.asarray(np.where(np.abs(net).max(axis=(1, 2), keepdims=True) > 100.0, net + 1.0, net))


@dataclass(frozen=True)
class LooksAtLabels(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return super().net(mesh) + 1e-3 * (mesh.faces[:, :, None] == 0)


@dataclass(frozen=True)
class LooksAtTheFirstCorner(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        net = super().net(mesh)
        net[:, 0] += 1e-3
        return net


@dataclass(frozen=True)
class LooksAtTheFirstFace(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        net = super().net(mesh)
        net[0] += 1e-3
        return net


@dataclass(frozen=True)
class MovesAlongTheNormal(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return super().net(mesh) + 1e-3 * mesh.corner_normals()


@dataclass(frozen=True)
class LooksAtTheWholeMesh(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return super().net(mesh) + 1e-12 * mesh.points.sum()


_calls = itertools.count()


@dataclass(frozen=True)
class RemembersCalls(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return super().net(mesh) * (1.0 + 1e-15 * next(_calls))


@dataclass(frozen=True)
class RefusesAll(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        raise Refused(f"not today, nor {len(mesh.faces)} faces")


@dataclass(frozen=True)
class Crashes(Honest):
    def net(self, mesh: HermiteMesh) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        raise ZeroDivisionError("oops") if len(mesh.faces) else ValueError


def test_an_honest_scheme_passes() -> None:
    outcomes = {outcome.property: outcome for outcome in check(Honest(order=2.0))}
    assert len(outcomes) == len(CHECKS)
    assert all(outcome.status in (Status.PASSED, Status.NOT_CLAIMED) for outcome in outcomes.values()), outcomes
    assert outcomes["G1 on every edge"].status is Status.NOT_CLAIMED
    assert outcomes["claimed order of convergence"].status is Status.PASSED


@pytest.mark.parametrize(
    ("make", "defects"),
    [
        (OffTheVertex, {"points"}),
        (Torn, {"c0", "points"}),
        (ClaimsNormals, {"normals"}),
        (ClaimsTangentPlanes, {"g1"}),
        (ClaimsCurvature, {"g1", "second-forms"}),
        (curvature_continuous, {"g2"}),
        (lambda: matching_second_forms("nielson"), {"second-forms"}),
        (lambda: matching_second_forms("triangular-gregory"), {"second-forms"}),
        (claims_centres, {"centres"}),
        (ClaimsSpheres, {"spheres", "quadrics"}),
        (LikesTheOrigin, {"rigid-motion"}),
        (HasALengthOfItsOwn, {"scale-up"}),
        (LooksAtLabels, {"vertex-labels"}),
        (LooksAtTheFirstCorner, {"first-corners", "c0"}),
        (LooksAtTheFirstFace, {"face-order"}),
        (MovesAlongTheNormal, {"orientation"}),
        (LooksAtTheWholeMesh, {"locality"}),
        (RemembersCalls, {"statelessness"}),
        (lambda: Honest(order=3.0), {"order"}),
    ],
)
def test_the_suite_finds_the_defect_and_names_a_witness(make: Callable[[], Scheme], defects: set[str]) -> None:
    under_check = Subject.of(make())
    for defect in defects:
        outcome = run(defect, under_check)
        assert outcome.status is Status.FAILED, defect
        assert outcome.detail


def test_a_scheme_that_is_not_finite_is_refused_and_leaves_nothing_to_test() -> None:
    outcome = run("points", Subject.of(OneNan()))
    assert outcome.status is Status.NOT_TESTABLE


def test_a_scheme_that_refuses_all_is_not_testable() -> None:
    assert run("points", Subject.of(RefusesAll())).status is Status.NOT_TESTABLE
    assert run("statelessness", Subject.of(RefusesAll())).status is Status.NOT_TESTABLE


def test_a_scheme_that_crashes_fails_with_its_exception() -> None:
    (outcome,) = check(Crashes())
    assert outcome.status is Status.FAILED
    assert outcome.detail == "ZeroDivisionError: oops"


def test_data_that_are_needed_and_missing_have_to_be_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    under_check = Subject.of(scheme("shirman-sequin"))
    assert run("refusal", under_check).status is Status.PASSED
    monkeypatch.setattr("testbed.plugins.scheme.check_needs", lambda *_: None)
    monkeypatch.setattr(type(under_check.scheme), "construct", lambda _, mesh: Honest().construct(mesh))
    assert run("refusal", under_check).status is Status.FAILED
