"""Pictures of style transfer by Gram matrices beside a controller on the same path ([M18] 8.2)."""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from stylephase.features.body import Body
from stylephase.motion.skeleton import Skeleton
from stylephase.report import palette, plots
from stylephase.report.render.motion import Motion

_MARKERS = ("s", "o", "^", "D", "v")
_GRAM, _OURS = palette.SEQUENCE[1], palette.ADAPTERS["cp"]
_COLOURS = {
    "Gram, one clip": _GRAM,
    "ours": _OURS,
    "content unchanged": palette.SEQUENCE[2],
    "style clip (real)": palette.SEQUENCE[3],
}


def motion_of(joints: Float[ndarray, "frames joints 3"], body: Body, label: str) -> Motion:
    """Feature joints in the world as a motion; the end sites that are not among them go on in their bone's way."""
    skeleton, whole = body.skeleton, np.zeros((len(joints), len(body.skeleton), 3))
    whole[:, list(body.joints)] = joints
    for joint in range(len(skeleton)):
        if joint not in body.joints:
            whole[:, joint] = _site(whole, skeleton, joint)
    return Motion(skeleton, whole, label=label)


def _site(whole: Float[ndarray, "frames joints 3"], skeleton: Skeleton, site: int) -> Float[ndarray, "frames 3"]:
    """An end site in line with its parent's own bone, as far away as it is."""
    parent = skeleton.parents[site]
    bone = whole[:, parent] - whole[:, skeleton.parents[parent]]
    length = np.maximum(np.linalg.norm(bone, axis=1, keepdims=True), 1e-6)
    return whole[:, parent] + bone / length * np.linalg.norm(skeleton.offsets[site])


def distances_plot(distances: Mapping[str, Float[ndarray, " styles"]], styles: list[str]) -> Axes:
    """For every style how far each motion lies from real unseen motion; styles in the order of the first."""
    order = np.argsort(next(iter(distances.values())))
    with plots.style():
        axes = Figure(figsize=(7.2, 0.24 * len(styles) + 1.2)).subplots()
        for k, (name, values) in enumerate(distances.items()):
            colour, marker = _COLOURS.get(name, palette.QUIET), _MARKERS[k % len(_MARKERS)]
            axes.plot(values[order], range(len(styles)), marker, color=colour, markersize=6, label=name)
        axes.set_yticks(range(len(styles)), [styles[k] for k in order], fontsize=8)
        axes.set(xlabel="distance to real motion of the style (deviations within a style)", xlim=(0, None))
        axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=len(distances))
    return axes


def paths_plot(
    paths: Mapping[str, tuple[Float[ndarray, "frames 2"], Float[ndarray, "frames 2"]]], names: tuple[str, str]
) -> list[Axes]:
    """Ground paths seen from above, a panel for each pair: the one asked for, dashed, and the one walked."""
    with plots.style():
        panels = list(Figure(figsize=(7.2, 2.9)).subplots(1, len(paths), squeeze=False)[0])
        for axes, (title, pair) in zip(panels, paths.items(), strict=True):
            for path, name, colour, line in zip(pair, names, (_GRAM, _OURS), ("--", "-"), strict=True):
                # The character starts upwards and its left is at the left.
                axes.plot(-path[:, 0], path[:, 1], line, color=colour, label=name)
            axes.set(xlabel="to the right (m)")
            axes.set_title(title, fontsize=9)
            axes.set_aspect("equal", adjustable="datalim")
        panels[0].set_ylabel("ahead (m)")
        panels[0].figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return panels
