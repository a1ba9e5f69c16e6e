"""The synthetic data set as files, laid out like 100STYLE."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from stylephase.files import write_arrays, write_text
from stylephase.motion.bvh import write_bvh
from stylephase.motion.synthetic.path import GAITS
from stylephase.motion.synthetic.styles import STYLES, WalkStyle, find_style
from stylephase.motion.synthetic.take import Truth, walk

# 100STYLE has columns for three takes of transitions; the walker makes one.
_COLUMNS = (*GAITS, "TR2", "TR3")
# Standing still is told in less time.
_SHORTER = {"ID": 0.5}


def generate(folder: Path, *, seed: int = 0, styles: Sequence[str] | None = None, seconds: float = 12.0) -> None:
    """Write the data set: `<Style>/<Style>_<gait>.bvh`, `Frame_Cuts.csv` and `Dataset_List.csv`.

    Beside each BVH lies `<Style>_<gait>.truth.npz` with the fields of `Truth`. `styles` are names, all of them if
    left out; `seconds` is the length of a cut (half of it standing idle). The same seed writes the same bytes, and a
    style's files do not depend on which other styles are written. The tables come last: a folder that holds them is
    complete. Raises InputError for an unknown style or where a file cannot be written.
    """
    chosen = STYLES if styles is None else tuple(find_style(name) for name in styles)
    cuts = {style.name: _write_style(folder / style.name, style, seed, seconds) for style in chosen}
    write_text(folder / "Dataset_List.csv", _dataset_list(chosen))
    write_text(folder / "Frame_Cuts.csv", _frame_cuts(cuts))


def _write_style(folder: Path, style: WalkStyle, seed: int, seconds: float) -> dict[str, tuple[int, int]]:
    cuts = {}
    for gait in GAITS:
        clip, truth = walk(style, gait, seconds=seconds * _SHORTER.get(gait, 1.0), seed=seed)
        write_bvh(folder / f"{clip.name}.bvh", clip)
        _write_truth(folder / f"{clip.name}.truth.npz", truth)
        cuts[gait] = truth.cut
    return cuts


def _write_truth(path: Path, truth: Truth) -> None:
    write_arrays(path, **{name: np.asarray(value) for name, value in vars(truth).items()})


def _frame_cuts(cuts: dict[str, dict[str, tuple[int, int]]]) -> str:
    """First frame of each take's cut, counted from 1, and the one after its last; N/A where there is no take."""
    header = ["STYLE_NAME", *(f"{gait}_{end}" for gait in _COLUMNS for end in ("START", "STOP"))]
    rows = [[name, *_cells(cut.get(gait) for gait in _COLUMNS)] for name, cut in cuts.items()]
    return "".join(",".join(row) + "\n" for row in [header, *rows])


def _cells(cuts: Iterable[tuple[int, int] | None]) -> list[str]:
    return [cell for cut in cuts for cell in (("N/A", "N/A") if cut is None else (str(cut[0] + 1), str(cut[1] + 1)))]


def _dataset_list(styles: Iterable[WalkStyle]) -> str:
    rows = [("Style Name", "Description", "Stochastic", "Symmetric", "Notes")]
    yes = {True: "Yes", False: "No"}
    rows += [(s.name, f'"{s.description}"', yes[s.stochastic], yes[s.symmetric], "generated") for s in styles]
    return "".join(",".join(row) + "\n" for row in rows)
