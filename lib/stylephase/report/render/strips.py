"""Frames of a motion side by side: a strip for one motion, a grid for several."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float, Int, UInt8
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.motion.root import turn
from stylephase.report import palette
from stylephase.report.plots import style
from stylephase.report.render.motion import Motion, facing_angles
from stylephase.report.render.scene import Character, add_lights, look, picture, reduced, stage, toward_eye

_ELEVATION = np.radians(11.0)
# What is drawn beyond the joints (m): above the head joint, below the ground, and to each side.
_ABOVE, _BELOW, _BESIDE = 0.28, 0.10, 0.22
# Room (m) left at each side of a character, so that it does not touch the next.
_APART = 0.14
_DPI = 100
# Cells are drawn this much finer, put side by side and then averaged: smooth edges, also where limbs overlap.
_FINER = 3
_MARGIN = 12
_LABEL_POINTS, _NOTE_POINTS = 12.0, 9.0
# Room (pixels) for a line of captions, and how they look.
_CAPTION = 18
_CAPTIONED: dict[str, Any] = {"size": _NOTE_POINTS, "ha": "center", "va": "center"}


@dataclass(frozen=True)
class Layout:
    """How a strip looks.

    `view` is seen against the character's facing: side (from its right, so that it walks to the right), front or
    three-quarter. `spacing` (m) is the distance between two characters, by default the least at which they do not
    touch; with `travelled` it is the distance that they went. `scale` is in pixels per metre, `highlights` are joints
    to ring, `note` stands below each label in place of the time between two frames, and of `captions` one stands below
    each frame.
    """

    frames: int = 8
    view: str = "side"
    spacing: float | None = None
    travelled: bool = False
    scale: int = 120
    highlights: tuple[str, ...] = ()
    note: str | None = None
    captions: tuple[str, ...] = ()


def strip(motion: Motion, layout: Layout = Layout()) -> UInt8[ndarray, "height width 3"]:
    """A picture of evenly spaced frames, first to last, with the motion's label at the left."""
    return grid([motion], layout)


def grid(motions: Sequence[Motion], layout: Layout = Layout()) -> UInt8[ndarray, "height width 3"]:
    """A picture with one strip for each motion, at one scale, and the labels at the left.

    Time runs to the right. Each character is turned so that all face the same way, and stands beside the one before it;
    with `layout.travelled` it stands where it went and turns as it did.
    """
    if not motions or layout.frames < 1:
        raise InputError(f"expected a motion and a frame to draw, found {len(motions)} and {layout.frames}")
    if layout.captions and len(layout.captions) != layout.frames:
        raise InputError(f"expected a caption for each of {layout.frames} frames, found {len(layout.captions)}")
    toward = toward_eye(layout.view, elevation=_ELEVATION)
    chosen = [np.linspace(0, len(motion) - 1, layout.frames).round().astype(int) for motion in motions]
    standing = [on_the_spot(motion, keep_turning=layout.travelled) for motion in motions]
    rooms = [_room(motion, at, toward) for (motion, _), at in zip(standing, chosen, strict=True)]
    spacing = layout.spacing or max(rooms)
    rows, middles = [], []
    for (motion, track), at in zip(standing, chosen, strict=True):
        places = track[at] @ _axes(toward)[0] if layout.travelled else spacing * np.arange(len(at))
        row, middle = _row(motion, at, places, toward, layout)
        rows.append(row)
        middles.append(middle)
    notes = [
        _step(motion, at) if layout.note is None else layout.note for motion, at in zip(motions, chosen, strict=True)
    ]
    captions = [list(zip(middle, layout.captions, strict=False)) for middle in middles]
    return _labelled(rows, list(zip([motion.label for motion in motions], notes, strict=True)), captions)


def on_the_spot(motion: Motion, *, keep_turning: bool) -> tuple[Motion, Float[ndarray, "frames 3"]]:
    """The motion with the hips over the origin and facing +z, and the track (m) that was taken from it.

    With `keep_turning` the motion is turned once, by its mean facing, instead of frame by frame.
    """
    angles = facing_angles(motion)
    angles = np.full_like(angles, angles.mean()) if keep_turning else angles
    back = turn(-angles)
    turned = np.einsum("tij,tkj->tki", back, motion.positions)
    track = turned[:, motion.skeleton.roles.hips] * [1.0, 0.0, 1.0]
    path = motion.path
    if path is not None:
        flat = back[:, ::2, ::2]
        points, facings = (np.einsum("tij,tkj->tki", flat, path[..., part]) for part in (slice(0, 2), slice(2, 4)))
        path = np.concatenate([points - track[:, None, ::2], facings], axis=2)
    return replace(motion, positions=turned - track[:, None], path=path), track - track[0]


def _axes(toward: Float[ndarray, " 3"]) -> Float[ndarray, "2 3"]:
    """The picture's right and up in the world."""
    right = np.cross([0.0, 1.0, 0.0], toward)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(toward, right)])


def _room(motion: Motion, at: Int[ndarray, " shown"], toward: Float[ndarray, " 3"]) -> float:
    """Room (m) that each character needs so that none touches the next."""
    across = motion.positions[at] @ _axes(toward)[0]
    return float((across[:-1].max(axis=1) - across[1:].min(axis=1)).max(initial=np.ptp(across[0]))) + 2 * _APART


def _row(
    motion: Motion,
    at: Int[ndarray, " shown"],
    places: Float[ndarray, " shown"],
    toward: Float[ndarray, " 3"],
    layout: Layout,
) -> tuple[UInt8[ndarray, "height width 3"], Float[ndarray, " shown"]]:
    """The frames `at`, each drawn with its hips at `places` (m from the row's start), and where those are (pixels)."""
    extent = motion.positions[at] @ _axes(toward).T
    low, high = min(float(extent[..., 1].min()), 0.0) - _BELOW, float(extent[..., 1].max()) + _ABOVE
    size = round((2 * np.abs(extent[..., 0]).max() + 2 * _BESIDE) * layout.scale), round((high - low) * layout.scale)
    starts = np.round((places - places.min()) * layout.scale).astype(int) * _FINER
    width, height = size[0] * _FINER, size[1] * _FINER
    row = np.full((height, int(starts.max()) + width, 3), 255, dtype=np.uint8)
    with stage(size, finer=_FINER) as plotter:
        add_lights(plotter, toward)
        character = Character(plotter, motion, toward=toward, highlights=layout.highlights)
        look(plotter, (low + high) / 2 * _axes(toward)[1], toward, height_shown=size[1] / layout.scale)
        for start, frame in zip(starts, at, strict=True):
            character.show(int(frame))
            cell, part = picture(plotter), row[:, start : start + width]
            part[:] = np.where((cell < 255).any(axis=2, keepdims=True), cell, part)
    return reduced(row, _FINER), (starts + width / 2) / _FINER


def _step(motion: Motion, at: Int[ndarray, " shown"]) -> str:
    if len(at) < 2:
        return ""
    return f"every {(at[-1] - at[0]) / (len(at) - 1) / motion.fps:.2f} s"


def _labelled(
    rows: list[UInt8[ndarray, "height width 3"]],
    labels: list[tuple[str, str]],
    captions: list[list[tuple[float, str]]],
) -> UInt8[ndarray, "total_height total_width 3"]:
    """The rows one below the other, each with a label and a note at its left and captions at places (pixels) below."""
    below = [_CAPTION * bool(each) for each in captions]
    height, width = sum(map(len, rows)) + sum(below), max(row.shape[1] for row in rows)
    aside = _MARGIN + max(_text_width(label, note) for label, note in labels)
    with style():
        figure = Figure(figsize=((aside + width) / _DPI, height / _DPI), dpi=_DPI)
        canvas, top = FigureCanvasAgg(figure), height
        for row, (label, note), each, room in zip(rows, labels, captions, below, strict=True):
            figure.figimage(row, xo=aside, yo=top - len(row), origin="upper")
            _write(figure, _MARGIN / (aside + width), (top - len(row) / 2) / height, label, note)
            top -= len(row) + room
            for x, caption in each:
                figure.text((aside + x) / (aside + width), (top + room / 2) / height, caption, **_CAPTIONED)
        canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _text_width(label: str, note: str) -> int:
    """Pixels that label and note take."""
    with style():
        figure = Figure(dpi=_DPI)
        renderer = FigureCanvasAgg(figure).get_renderer()
        texts = _write(figure, 0.0, 0.0, label, note)
        return int(max(text.get_window_extent(renderer).width for text in texts)) + _MARGIN


def _write(figure: Figure, x: float, y: float, label: str, note: str) -> tuple[Text, Text]:
    """A label above a note, at a place given as shares of the figure."""
    return (
        figure.text(x, y, label, size=_LABEL_POINTS, va="bottom", weight="bold"),
        figure.text(x, y, note, size=_NOTE_POINTS, va="top", color=palette.QUIET),
    )
