"""Where a picture is seen from: an orthographic view, so that lengths compare across the picture."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from testbed.errors import SpecError
from testbed.geometry.vectors import Float, cross, norm, unit

#: Azimuth and elevation in degrees of pictures that name none.
VIEW = (-60.0, 25.0)
#: What of the picture's width stays free around the surface.
MARGIN = 0.06


@dataclass(frozen=True)
class Camera:
    """An orthographic camera.

    Parameters
    ----------
    axes
        Three rows: to the right, upwards and towards the viewer, unit vectors.
    centre
        The point in the middle of the picture.
    width
        Length that the picture's width shows; pictures are square.
    """

    axes: tuple[tuple[float, float, float], ...]
    centre: tuple[float, float, float]
    width: float

    @classmethod
    def around(cls, points: Float, azimuth: float = VIEW[0], elevation: float = VIEW[1]) -> Self:
        """Look at points (N, 3) from a direction in degrees, z upwards; all of them are in the picture.

        Raises
        ------
        SpecError
            An angle is no finite number.
        """
        if not np.isfinite([azimuth, elevation]).all():
            raise SpecError(f"a view from {azimuth:g} and {elevation:g} degrees does not exist: give two angles")
        a, e = np.radians([azimuth, elevation])
        towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        axes = np.stack([right, cross(towards, right), towards])
        seen = points @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        centre = 0.5 * (low + high) @ axes
        width = float((high - low)[:2].max()) / (1.0 - 2.0 * MARGIN)
        rows = tuple((float(x), float(y), float(z)) for x, y, z in axes)
        return cls(rows, (float(centre[0]), float(centre[1]), float(centre[2])), width or 1.0)

    @property
    def towards(self) -> Float:
        """Unit vector from the surface to the viewer, (3,)."""
        return np.array(self.axes[2])

    def screen(self, points: Float, size: int) -> Float:
        """Pixel coordinates to the right, downwards, and depth towards the viewer in pixels, (N, 3) of (N, 3)."""
        seen = (points - np.array(self.centre)) @ np.array(self.axes).T * (size / self.width)
        return np.stack([0.5 * size + seen[:, 0], 0.5 * size - seen[:, 1], seen[:, 2]], axis=-1)


def turned(points: Float) -> tuple[float, float]:
    """Return azimuth and elevation from which a flat set of points (N, 3) shows most of itself; else the usual view."""
    offsets = points - points.mean(axis=0)
    size, axes = np.linalg.eigh(offsets.T @ offsets)
    if size[0] > 0.05 * size[1]:
        return VIEW
    across = unit(axes[:, 0] * (np.sign(axes[2, 0]) or 1.0))
    tilted = unit(across + 0.9 * np.array([0.35, -0.6, 0.0]))
    return float(np.degrees(np.arctan2(tilted[1], tilted[0]))), float(np.degrees(np.arcsin(tilted[2] / norm(tilted))))
