"""The whole suite over one scheme."""

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Final

from testbed.conformance import claims, properties
from testbed.conformance.subject import Outcome, Status, Subject
from testbed.plugins.scheme import Scheme, Shape

#: What is checked, in the order it is printed.
CHECKS: Final[Mapping[str, Callable[[Subject], Outcome]]] = MappingProxyType(
    {
        "points": claims.interpolates_points,
        "normals": claims.interpolates_normals,
        "second-forms": claims.interpolates_second_forms,
        "centres": claims.interpolates_centres,
        "c0": claims.is_continuous,
        "g1": claims.is_tangent_continuous,
        "g2": claims.is_curvature_continuous,
        "planes": partial(claims.reproduces, shape=Shape.PLANES),
        "spheres": partial(claims.reproduces, shape=Shape.SPHERES),
        "quadrics": partial(claims.reproduces, shape=Shape.QUADRICS),
        "rigid-motion": properties.moves_with_the_data,
        "scale-down": partial(properties.scales_with_the_data, factor=1e-3),
        "scale-up": partial(properties.scales_with_the_data, factor=1e3),
        "vertex-labels": properties.ignores_vertex_labels,
        "first-corners": properties.ignores_first_corners,
        "face-order": properties.ignores_face_order,
        "orientation": properties.ignores_orientation,
        "locality": properties.is_local,
        "batches": properties.is_independent_of_batches,
        "statelessness": properties.is_stateless,
        "refusal": properties.refuses_what_it_cannot_take,
        "order": claims.converges,
    }
)


def check(scheme: Scheme) -> tuple[Outcome, ...]:
    """Run every check over a scheme.

    Any exception other than :class:`~testbed.errors.Refused` that the scheme raises is a failure of the check that met
    it, with the exception as the witness.
    """
    try:
        subject = Subject.of(scheme)
    except Exception as error:  # noqa: BLE001 - whatever a scheme raises is its failure, not the suite's
        return (Outcome("builds surfaces", Status.FAILED, f"{type(error).__name__}: {error}"),)
    return tuple(run(name, subject) for name in CHECKS)


def run(name: str, subject: Subject) -> Outcome:
    """Run one check of :data:`CHECKS`."""
    try:
        return CHECKS[name](subject)
    except Exception as error:  # noqa: BLE001 - as above
        return Outcome(name, Status.FAILED, f"{type(error).__name__}: {error}")
