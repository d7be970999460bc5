"""Colours and markers: a scheme has the same on every plot and in every table, told apart without colour vision too."""

from dataclasses import dataclass
from typing import Final

#: Okabe and Ito's colours without the yellow, which is too light for lines on white.
COLOURS: Final = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#E69F00", "#56B4E9")
#: matplotlib's letter, and the outline within the square from -1 to 1, the second coordinate downwards.
MARKERS: Final = (
    ("o", "M-1,0A1,1 0 1 1 1,0A1,1 0 1 1 -1,0Z"),
    ("s", "M-.9,-.9H.9V.9H-.9Z"),
    ("^", "M0,-1L1,1H-1Z"),
    ("D", "M0,-1.15L1.15,0L0,1.15L-1.15,0Z"),
    ("v", "M0,1L1,-1H-1Z"),
    ("P", "M-.4,-1H.4V-.4H1V.4H.4V1H-.4V.4H-1V-.4H-.4Z"),
    ("X", "M-1,-.5L-.5,-1L0,-.5L.5,-1L1,-.5L.5,0L1,.5L.5,1L0,.5L-.5,1L-1,.5L-.5,0Z"),
    ("p", "M0,-1.1L1.05,-.34L.65,.89H-.65L-1.05,-.34Z"),
)


@dataclass(frozen=True)
class Style:
    """How a scheme is drawn: a colour, and a marker as a letter and as an SVG path."""

    colour: str
    marker: str
    outline: str


def style(position: int) -> Style:
    """Return the style of the scheme at a position of the plan; 56 differ."""
    # seven colours and eight markers: both change from scheme to scheme, and no pair comes back before all were used
    return Style(COLOURS[position % len(COLOURS)], *MARKERS[position % len(MARKERS)])
