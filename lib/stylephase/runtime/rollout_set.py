"""The data set `lpn-rollouts`: the released network walks at random in its styles, and is written as if captured.

It has the skeleton and the styles of the 2022 paper, but a network made it: as evidence about LPN-FiLM it is circular.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import torch
from tqdm import tqdm

from stylephase.data.layouts import published_entries
from stylephase.features.layout import FPS
from stylephase.files import write_text
from stylephase.models.bundle import Bundle
from stylephase.models.released import UNUSABLE, release_bundle
from stylephase.motion.bvh import write_bvh
from stylephase.runtime.controller import start_state
from stylephase.runtime.finish import finish
from stylephase.runtime.random_steering import Gait, RandomSteering
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import Rollout, Tick, quiet, roll_out, to_clip

_BACK, _SIDE = np.pi, np.pi / 2
# Names as in 100STYLE: forward walk and run, backward, sidewalk; standing and starting; changes between all of them.
# Speeds are a gain, which the network follows in part: a walk of Neutral comes out at 0.5 to 1 m/s, a run at 1.3 m/s.
GAITS = (
    Gait("FW", 25.0, (2.5, 5.5), turn=1.0),
    Gait("FR", 15.0, (6.0, 10.0)),
    Gait("BW", 15.0, (2.0, 5.0), (_BACK,), turn=0.5),
    Gait("SW", 15.0, (3.5, 5.5), (_SIDE, -_SIDE), turn=0.4),
    Gait("TR1", 10.0, (2.0, 6.0), turn=0.5, stops=0.4),
    Gait("TR2", 10.0, (2.0, 9.0), (0.0, 0.0, _BACK, _SIDE, -_SIDE), turn=1.0, stops=0.1),
)
# The first frames only settle; they are not written (s).
_WARM_UP = 3.0


def generate(
    folder: Path, *, styles: Sequence[str] | None = None, gaits: Sequence[Gait] = GAITS, seed: int = 0
) -> None:
    """Write the data set in the layout of 100STYLE, in some minutes; `styles` are all that walk if left out.

    The same seed writes the same bytes on one machine. On another the last bits differ, and with them after some
    seconds the steps. The tables come last: a folder that holds them is complete. Raises InputError where weights or
    skeleton are not at hand, or a file cannot be written.
    """
    bundle = release_bundle()
    chosen = tuple(style for style in bundle.styles if style not in UNUSABLE) if styles is None else tuple(styles)
    frames = sum(_frames(gait) for gait in gaits)
    with _one_thread(), tqdm(total=frames, desc="lpn-rollouts", unit="frame", disable=None) as bar:
        for gait in gaits:
            _write_takes(folder, bundle, chosen, gait, finished_walk(bundle, chosen, gait, seed=seed, tick=bar.update))
    write_text(folder / "Dataset_List.csv", _style_table(chosen))
    write_text(folder / "Frame_Cuts.csv", _cut_table(chosen, gaits))


def finished_walk(bundle: Bundle, styles: Sequence[str], gait: Gait, *, seed: int = 0, tick: Tick = quiet) -> Rollout:
    """All styles side by side in one gait, from the mean pose, with the warm-up: feet held, bones constant."""
    return finish(raw_walk(bundle, styles, gait, seed=seed, tick=tick), rig_of(bundle.body))


def raw_walk(
    bundle: Bundle,
    styles: Sequence[str],
    gait: Gait,
    *,
    seed: int = 0,
    grounded: bool = True,
    tick: Tick = quiet,
) -> Rollout:
    """The same as the network gives it."""
    codes, n = torch.stack([bundle.code(style) for style in styles]), bundle.normaliser
    x, p = (np.tile(mean, (len(styles), 1)) for mean in (n.x_mean, n.p_mean))
    start, frames = start_state(x, p, bundle.body.layout), _frames(gait)
    plan = RandomSteering(gait, styles, frames, seed)
    return roll_out(bundle, codes, start, frames, plan, tick=tick, grounded=grounded)


def _frames(gait: Gait) -> int:
    return int((gait.seconds + _WARM_UP) * FPS)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Run torch on one thread, so that sums are always made in the same order."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


def _write_takes(folder: Path, bundle: Bundle, styles: Sequence[str], gait: Gait, run: Rollout) -> None:
    for k, style in enumerate(styles):
        name = f"{style}_{gait.name}"
        clip = to_clip(run, k, bundle.body, name).frames(int(_WARM_UP * FPS), len(run))
        (folder / style).mkdir(parents=True, exist_ok=True)
        write_bvh(folder / style / f"{name}.bvh", clip)


def _style_table(styles: Sequence[str]) -> str:
    """Whether each style is symmetric and stochastic, as published of the style."""
    known = {entry.style: (entry.symmetric, entry.stochastic) for entry in published_entries()}
    flags = [[style, *("Yes" if flag else "No" for flag in known[style])] for style in styles]
    return _table([["Style Name", "Symmetric", "Stochastic"], *flags])


def _cut_table(styles: Sequence[str], gaits: Sequence[Gait]) -> str:
    """Every take counts whole; the table counts from 1 and its stop is not inside."""
    header = ["STYLE_NAME", *(f"{gait.name}_{end}" for gait in gaits for end in ("START", "STOP"))]
    cuts = [str(value) for gait in gaits for value in (1, int(gait.seconds * FPS) + 1)]
    return _table([header, *([style, *cuts] for style in styles)])


def _table(rows: Sequence[Sequence[str]]) -> str:
    return "".join(",".join(row) + "\n" for row in rows)
