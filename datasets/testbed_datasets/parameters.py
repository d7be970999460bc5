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


def within(dataset: str, **parameters: tuple[float, float, float]) -> None:
    """Raise SpecError unless every parameter, given with its least and its greatest value, is between these."""
    for parameter, (value, least, greatest) in parameters.items():
        if not least <= value <= greatest:
            raise SpecError(
                f"parameter {parameter} of {dataset} cannot be {value}: give a number from {least:g} to {greatest:g}"
            )
