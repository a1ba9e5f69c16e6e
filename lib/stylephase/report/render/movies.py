"""Movies: one or several characters, each in a panel of its own, on a ground that stays in the world."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import imageio_ffmpeg
import numpy as np
from jaxtyping import UInt8
from numpy import ndarray
from PIL import Image
from scipy.ndimage import gaussian_filter1d
from tqdm import tqdm

from stylephase.errors import InputError
from stylephase.files import replacing
from stylephase.report.render.motion import Motion, facing_angles
from stylephase.report.render.scene import (
    Character,
    add_ground,
    add_label,
    add_lights,
    look,
    picture,
    reduced,
    stage,
    toward_eye,
)

if TYPE_CHECKING:
    import pyvista

_ELEVATION = np.radians(14.0)
_DISTANCE = 5.4
_FOLLOW_SECONDS = 0.5
_TARGET_HEIGHT = 0.92
_LABEL_SIZE, _LABEL_PLACE = 10, (0.02, 0.98)
_FINER = 2
_LINE_WIDTH = 1.2


def movie(
    path: str | Path,
    motions: Motion | Sequence[Motion],
    *,
    fps: int = 30,
    size: tuple[int, int] = (640, 480),
    view: str = "three-quarter",
    highlights: Sequence[str] = (),
    progress: bool = False,
) -> int:
    """Write an mp4 or a gif, chosen by the name's suffix, and return its number of frames.

    Each motion has a panel of `size` (pixels, multiples of 16), from left to right, with its label. A camera follows
    the hips smoothly and keeps its direction, which `view` gives against the mean facing; the ground with a line at
    every metre stays in the world, so that sliding feet are seen. The longest motion sets the length, the others hold
    their last frame. `progress` shows a bar. Raises InputError on a bad name, size or frame rate; no file is left then.
    """
    motions = [motions] if isinstance(motions, Motion) else list(motions)
    _check(path, motions, size)
    shown = [_at_rate(motion, fps) for motion in motions]
    count = max(len(motion) for motion in shown)
    with replacing(path) as temporary, ExitStack() as stack:
        panels = [_Panel(stack.enter_context(stage(size, finer=_FINER)), each, view, highlights) for each in shown]
        write = stack.enter_context(_WRITERS[temporary.suffix](temporary, (size[0] * len(shown), size[1]), fps))
        for frame in tqdm(range(count), desc=Path(path).name, unit="frame", disable=not progress):
            write(np.concatenate([panel.at(frame) for panel in panels], axis=1))
    return count


@contextmanager
def _mp4(path: Path, size: tuple[int, int], fps: int) -> Iterator[Callable[[ndarray], None]]:
    writer = imageio_ffmpeg.write_frames(path, size, fps=fps, codec="libx264", quality=6)
    writer.send(None)
    with closing(writer):
        yield lambda pixels: writer.send(np.ascontiguousarray(pixels))


@contextmanager
def _gif(path: Path, size: tuple[int, int], fps: int) -> Iterator[Callable[[ndarray], None]]:
    """Frames are kept with 256 colours each and written at the end."""
    frames: list[Image.Image] = []
    yield lambda pixels: frames.append(Image.fromarray(pixels).quantize(256, dither=Image.Dither.NONE))
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=1000 / fps, loop=0)


_WRITERS = {".mp4": _mp4, ".gif": _gif}


def _check(path: str | Path, motions: list[Motion], size: tuple[int, int]) -> None:
    if Path(path).suffix not in _WRITERS:
        raise InputError(f"a movie's name should end in {' or '.join(_WRITERS)}", path)
    if not motions:
        raise InputError("no motion to show", path)
    if any(length <= 0 or length % 16 for length in size):
        raise InputError(f"width and height should be multiples of 16, not {size[0]} x {size[1]}", path)


def _at_rate(motion: Motion, fps: int) -> Motion:
    """Every so many frames of the motion. The rates should divide, since frames are left out and never made up."""
    step = round(motion.fps / fps)
    if step < 1 or not np.isclose(motion.fps, step * fps, rtol=1e-3):
        raise InputError(
            f"a movie of {fps} frames a second cannot be taken from motion at {motion.fps:g}", motion.label
        )
    every = slice(None, None, step)
    return replace(
        motion,
        positions=motion.positions[every],
        contacts=None if motion.contacts is None else motion.contacts[every],
        path=None if motion.path is None else motion.path[every],
        fps=float(fps),
    )


class _Panel:
    """One motion on a stage of its own, with ground and camera."""

    def __init__(self, plotter: "pyvista.Plotter", motion: Motion, view: str, highlights: Sequence[str]):
        hips = motion.positions[:, motion.skeleton.roles.hips]
        facing = float(facing_angles(motion).mean())
        self._plotter, self._last = plotter, len(motion) - 1
        self._toward = toward_eye(view, elevation=_ELEVATION, facing=facing)
        self._targets = gaussian_filter1d(hips, _FOLLOW_SECONDS * motion.fps, axis=0, mode="nearest")
        self._targets[:, 1] = _TARGET_HEIGHT * hips[:, 1].mean()
        add_lights(plotter, self._toward)
        add_ground(plotter, hips[:, [0, 2]], line_width=_LINE_WIDTH * _FINER)
        self._character = Character(plotter, motion, toward=self._toward, highlights=highlights)
        if motion.label:
            text = add_label(plotter, motion.label, place=_LABEL_PLACE, size=_LABEL_SIZE * _FINER)
            # Hung from its top, so that it fits however low the panel is and however many lines it has.
            text.prop.SetVerticalJustificationToTop()

    def at(self, frame: int) -> UInt8[ndarray, "height width 3"]:
        """The picture of a frame, or of the last one where the motion has ended."""
        frame = min(frame, self._last)
        self._character.show(frame)
        look(self._plotter, self._targets[frame], self._toward, distance=_DISTANCE)
        return reduced(picture(self._plotter), _FINER)
