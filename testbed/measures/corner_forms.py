"""Second fundamental forms at the corners of patches, on blended patches as limits.

A blended patch is 0/0 at its corners. Along a straight line into a corner its second fundamental form is an analytic
function of the distance, with a limit that may depend on the direction: values at distances that are halved from one to
the next are extrapolated to none (Richardson, Romberg), along several directions.
"""

import numpy as np

from testbed.geometry.curvature import second_form_matrix
from testbed.geometry.domain import CORNERS
from testbed.geometry.patches import PatchBatch
from testbed.geometry.vectors import Float, as_float
from testbed.measures.sampling import chunks

#: Directions of the limits, between the two sides of the corner.
DIRECTIONS = np.array([0.125, 0.5, 0.875])
#: The largest distance from the corner, and how often it is halved. Nearer, rounding grows; farther away, what is left
#: of the extrapolation does. Both are 1e-9 of the curvature here, 1e-7 in triangles a hundred times longer than wide.
FARTHEST, HALVINGS = 1e-2, 4


def corner_forms(batch: PatchBatch) -> Float:
    """Second fundamental forms (P, sides, D, 3, 3) at the corners; D limits on blended patches, one value on others."""
    if batch.corner_margin == 0.0:
        return second_form_matrix(batch.jets(CORNERS[batch.sides], 2))[:, :, None]
    at = approaches(batch.sides, batch.corner_margin)
    result = np.empty((len(batch), batch.sides, len(DIRECTIONS), 3, 3))
    for some in chunks(len(batch), at[..., 0].size):
        values = second_form_matrix(batch.take(some).jets(at.reshape(-1, 2), 2))
        result[some] = extrapolated(np.moveaxis(values.reshape(-1, *at.shape[:-1], 3, 3), 1, 0))
    return result


def approaches(sides: int, margin: float) -> Float:
    """Points (HALVINGS + 1, sides, D, 2) towards each corner, the farthest first, none nearer than the margin."""
    corners = CORNERS[sides][:, None]
    forward, back = np.roll(corners, -1, axis=0) - corners, np.roll(corners, 1, axis=0) - corners
    towards = (1.0 - DIRECTIONS)[:, None] * forward + DIRECTIONS[:, None] * back
    distances = max(FARTHEST, 2.0 ** (HALVINGS + 1) * margin) * 0.5 ** np.arange(HALVINGS + 1)
    return as_float(corners + distances[:, None, None, None] * towards)


def extrapolated(values: Float) -> Float:
    """Limit (...) of values (n, ...) at distances each half of the one before; of order n."""
    for power in range(1, len(values)):
        values = values[1:] + (values[1:] - values[:-1]) / (2.0**power - 1.0)
    limit: Float = values[0]
    return limit
