"""Checks of dataset parameters, one sentence each."""

import math

from testbed.errors import SpecError


def positive(dataset: str, **parameters: float) -> None:
    """Raise SpecError unless every parameter is a positive finite number."""
    for parameter, value in parameters.items():
        if not (math.isfinite(value) and value > 0.0):
            raise SpecError(f"parameter {parameter} of {dataset} cannot be {value}: give a positive number")


def finite(dataset: str, **parameters: float) -> None:
    """Raise SpecError unless every parameter is a finite number."""
    for parameter, value in parameters.items():
        if not math.isfinite(value):
            raise SpecError(f"parameter {parameter} of {dataset} cannot be {value}: give a finite number")
