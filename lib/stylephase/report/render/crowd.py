"""A crowd in one picture: many characters in rows, each in a pose of its own ([M22] Fig. 1)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import UInt8
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.report.render.motion import Motion
from stylephase.report.render.scene import Character, add_lights, look, picture, reduced, stage, toward_eye
from stylephase.report.render.strips import on_the_spot

_ELEVATION = np.radians(24.0)
_FINER = 2
_ABOVE = 0.9


def crowd(
    motions: Sequence[Motion],
    *,
    columns: int = 20,
    spacing: tuple[float, float] = (1.25, 3.7),
    width: int = 1400,
    view: str = "three-quarter",
) -> UInt8[ndarray, "height width 3"]:
    """The last frame of each motion, `columns` side by side, `spacing` (m) between columns and rows; all face the eye.

    Raises InputError where there is no motion.
    """
    if not motions:
        raise InputError("no motion to show")
    rows = -(-len(motions) // columns)
    toward = toward_eye(view, elevation=_ELEVATION)
    right = np.cross([0.0, 1.0, 0.0], toward)
    right /= np.linalg.norm(right)
    back = -np.array([toward[0], 0.0, toward[2]]) / np.hypot(toward[0], toward[2])
    across, high = (columns + 1) * spacing[0], (rows - 1) * spacing[1] * np.sin(_ELEVATION) + 2.5
    size = (width, round(width * high / across))
    with stage(size, finer=_FINER) as plotter:
        add_lights(plotter, toward)
        for k, motion in enumerate(motions):
            row, column = divmod(k, columns)
            # Each second row stands in the gaps of the first, so that nobody hides behind another.
            aside = column - (columns - 1) / 2 + 0.5 * (row % 2) - 0.25 * (rows > 1)
            place = aside * spacing[0] * right + ((rows - 1) / 2 - row) * spacing[1] * back
            still = on_the_spot(motion, keep_turning=False)[0].frames(len(motion) - 1, len(motion))
            Character(plotter, replace(still, positions=still.positions + place, path=None), toward=toward)
        look(plotter, np.array([0.0, _ABOVE, 0.0]), toward, distance=60.0, height_shown=high)
        plotter.camera.clipping_range = (1.0, 150.0)
        return reduced(picture(plotter), _FINER)
