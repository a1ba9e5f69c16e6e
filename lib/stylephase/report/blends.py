"""Pictures of blends for the notebooks: characters side by side along a blend, and how far each has come."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from stylephase.evaluation.interpolation import Blend
from stylephase.evaluation.rollouts import SETTLE
from stylephase.features.body import Body
from stylephase.motion.clip import forward_kinematics
from stylephase.phase.global_phase import touchdowns
from stylephase.report import palette, plots
from stylephase.report.render.motion import Motion
from stylephase.runtime.rollout import Rollout, to_clip

_RIGHT = 0


def along_motion(run: Rollout, characters: Sequence[int], body: Body, label: str) -> Motion:
    """One pose of each character as the frames of a motion: each where its right foot came down last."""
    poses = [_pose(run, character, body) for character in characters]
    return Motion(body.skeleton, np.stack(poses), label=label)


def _pose(run: Rollout, character: int, body: Body) -> Float[ndarray, "joints 3"]:
    downs = touchdowns(run.contacts[SETTLE:, character, _RIGHT] > 0.5, 60.0)
    frame = SETTLE + int(downs[-1]) if len(downs) else len(run) - 1
    positions = forward_kinematics(to_clip(run, character, body, "").frames(frame, frame + 1)).positions[0]
    ground = np.array([run.root_positions[frame, character, 0], 0.0, run.root_positions[frame, character, 1]])
    return positions - ground


def along_plot(blends: Mapping[str, Sequence[Blend]]) -> list[Axes]:
    """How far each pair's blend has come against the share of the second style, a panel for each model.

    A thin line is a pair, the thick one their median, the dashed one an even blend.
    """
    with plots.style():
        panels = list(Figure(figsize=(7.2, 3.0)).subplots(1, len(blends), sharey=True, squeeze=False)[0])
        for axes, (name, some) in zip(panels, blends.items(), strict=True):
            shares, along = some[0].shares, np.array([blend.along for blend in some])
            colour = palette.colour_of(name)
            axes.plot([0, 1], [0, 1], color=palette.HIGHLIGHT, linestyle="--", linewidth=1.0)
            axes.plot(shares, along.T, color=colour, linewidth=0.7, alpha=0.45)
            axes.plot(shares, np.median(along, axis=0), color=colour, linewidth=2.6)
            axes.set(xlabel="second style (share)", ylim=(-0.25, 1.3), title=name)
        panels[0].set_ylabel("way from first style to second (share)")
    return panels


def triangle_plot(asked: Float[ndarray, "points 3"], found: Float[ndarray, "points 3"], names: Sequence[str]) -> Axes:
    """Three-way blends in the triangle of their styles: a line from what was asked for to what came out."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, np.sqrt(0.75)]])
    with plots.style():
        axes = Figure(figsize=(5.4, 4.4)).subplots()
        axes.fill(*corners.T, facecolor="none", edgecolor=palette.QUIET, linewidth=0.8)
        for start, end in zip(asked @ corners, found @ corners, strict=True):
            axes.plot(*np.stack([start, end]).T, color=palette.QUIET, linewidth=1.2)
        axes.scatter(*(asked @ corners).T, s=42, facecolor="none", edgecolor=palette.INK, label="asked for", zorder=3)
        axes.scatter(*(found @ corners).T, s=18, color=palette.colour_of("lpn-film"), label="came out", zorder=4)
        for corner, name, below in zip(corners, names, (True, True, False), strict=True):
            place, align = (0, -14 if below else 10), "top" if below else "bottom"
            axes.annotate(
                name, tuple(corner), xytext=place, textcoords="offset points", ha="center", va=align, weight="bold"
            )
        axes.set_aspect("equal")
        axes.margins(0.15)
        axes.set_axis_off()
        axes.legend(loc="upper right")
    return axes
