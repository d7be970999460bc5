"""The centre of a cubic triangle that makes it quadratic where its boundary is (Farin 1983)."""

from testbed.geometry.nets import side_indices
from testbed.geometry.vectors import Float


def quadratic_precision_centre(net: Float) -> Float:
    """P111 = (sum of the six edge points) / 4 - (sum of the corners) / 6 of cubic nets (F, 10, 3), (F, 3).

    A net raised from a quadratic triangle has this centre. The centre of the nets given is not read.
    """
    sides = side_indices(3)
    centre: Float = net[:, sides[:, 1:3].ravel()].sum(axis=1) / 4.0 - net[:, sides[:, 0]].sum(axis=1) / 6.0
    return centre
