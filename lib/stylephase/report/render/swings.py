"""Principal directions drawn on a character: a hand's path, an arrow along it, a plane across it ([M22] Fig. 4)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float, UInt8
from numpy import ndarray

from stylephase.motion.clip import Pose
from stylephase.motion.root import hips_axes, hips_frame
from stylephase.motion.skeleton import Skeleton
from stylephase.report import palette
from stylephase.report.render.motion import Motion, facing_angles
from stylephase.report.render.scene import Character, add_label, add_lights, look, picture, reduced, stage, toward_eye

if TYPE_CHECKING:
    import pyvista

_ELEVATION = np.radians(14.0)
_FINER = 3
_HEIGHT, _WIDTH, _MIDDLE = 2.05, 1.7, 0.93
# An arrow reaches this many standard deviations of the movement each way, and at least so far (m).
_DEVIATIONS, _SHORTEST = 2.0, 0.09
_SHAFT, _TIP, _TIP_LENGTH, _PLANE = 0.010, 0.026, 0.075, 0.15
_LINE_WIDTH = 2.5
_LABEL_SIZE, _LABEL_PLACE = 11, (0.03, 0.93)


@dataclass(frozen=True)
class Swing:
    """How a joint moves against the hips, in the world of one frame: path and its middle (m), direction, colour."""

    path: Float[ndarray, "frames 3"]
    middle: Float[ndarray, " 3"]
    direction: Float[ndarray, " 3"]
    colour: str

    @property
    def reach(self) -> float:
        """Half the length of the arrow (m)."""
        return max(_DEVIATIONS * float(((self.path - self.middle) @ self.direction).std()), _SHORTEST)


def swings(
    pose: Pose,
    skeleton: Skeleton,
    joints: Sequence[int],
    directions: Float[ndarray, "joints 3"],
    colours: Sequence[str],
    *,
    frame: int,
) -> list[Swing]:
    """Swings of some joints, with their directions in the hips' frame, as the hips stand in a frame."""
    axes, hips = pose.rotations[frame, 0] @ hips_axes(skeleton), pose.positions[frame, 0]
    places = hips_frame(pose, skeleton, tuple(joints)) @ axes.T + hips
    return [
        Swing(places[:, k], places[:, k].mean(axis=0), axes @ direction, colour)
        for k, (direction, colour) in enumerate(zip(directions, colours, strict=True))
    ]


def swing_picture(
    motion: Motion, drawn: Sequence[Swing], *, frame: int, view: str = "three-quarter", scale: int = 190
) -> UInt8[ndarray, "height width 3"]:
    """The character in one frame with its label, and the swings around it; `scale` is in pixels per metre."""
    toward = toward_eye(view, elevation=_ELEVATION, facing=float(facing_angles(motion)[frame]))
    centre = motion.positions[frame, motion.skeleton.roles.hips] * [1.0, 0.0, 1.0] + [0.0, _MIDDLE, 0.0]
    with stage((round(_WIDTH * scale), round(_HEIGHT * scale)), finer=_FINER) as plotter:
        add_lights(plotter, toward)
        Character(plotter, motion, toward=toward).show(frame)
        for swing in drawn:
            _add(plotter, swing)
        add_label(plotter, motion.label, place=_LABEL_PLACE, size=_LABEL_SIZE * _FINER)
        look(plotter, centre, toward, height_shown=_HEIGHT)
        return reduced(picture(plotter), _FINER)


def _add(plotter: "pyvista.Plotter", swing: Swing) -> None:
    import pyvista

    start, length = swing.middle - swing.reach * swing.direction, 2 * swing.reach + _TIP_LENGTH
    arrow = pyvista.Arrow(
        start=start,
        direction=swing.direction,
        scale=length,
        tip_length=_TIP_LENGTH / length,
        tip_radius=_TIP / length,
        shaft_radius=_SHAFT / length,
    )
    plane = pyvista.Disc(center=swing.middle, inner=0.0, outer=_PLANE, normal=swing.direction, c_res=48)
    plotter.add_mesh(arrow, color=palette.HIGHLIGHT, ambient=0.4)
    plotter.add_mesh(plane, color=palette.HIGHLIGHT, opacity=0.22, lighting=False)
    if len(swing.path) > 1:
        path = pyvista.MultipleLines(points=swing.path)
        plotter.add_mesh(path, color=swing.colour, lighting=False, line_width=_LINE_WIDTH * _FINER)
