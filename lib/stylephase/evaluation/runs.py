"""Trained runs in a folder, by their names: `<data set>-<preset>-<model>[-<variant>]-seed<number>`.

What was measured of a run (its evaluation and its learning curve) is kept in `data/runs/` too, without the weights, so
that the tables can be made again without hours of training.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.data.registry import DATA
from stylephase.errors import InputError
from stylephase.files import read_json, write_json
from stylephase.models.bundle import Bundle, is_bundle, load_bundle
from stylephase.models.zoo import PAPER_2022

KEPT = DATA / "runs"
_EVALUATION, _LOG = "evaluation.json", "log.json"


@dataclass(frozen=True)
class Run:
    """One evaluated run: its model and seed, and what its `variant` changes, "" for nothing."""

    folder: Path
    model: str
    variant: str
    seed: int

    @property
    def evaluation(self) -> dict[str, Any]:
        """What `stylephase evaluate` found."""
        return read_json(self.folder / _EVALUATION)

    @property
    def log(self) -> list[dict[str, Any]]:
        """Errors over the steps of the training."""
        return read_json(self.folder / _LOG)

    @property
    def input_rate(self) -> float:
        """Dropout of the input in training."""
        return float(self.evaluation["input_rate"])

    @property
    def parameters(self) -> int:
        """Numbers that were trained: of the network and, where it has one, of its style generator."""
        return int(self.evaluation["parameters"])

    @property
    def has_weights(self) -> bool:
        """Whether the trained weights are there, not only what was measured of them."""
        return is_bundle(self.folder)

    @property
    def file(self) -> Path:
        """The file that its numbers rest on."""
        return self.folder / _EVALUATION


def run_name(dataset: str, preset: str, run: str) -> str:
    """The name of a run's folder; `run` is `<model>[-<variant>]-seed<number>`, or a pattern of such names.

    A data set's name may hold a path (`own:FOLDER`), a folder's name may not.
    """
    return f"{dataset.replace(':', '-').replace('/', '-')}-{preset}-{run}"


def keep_run(folder: Path, result: dict[str, Any], kept: Path = KEPT) -> Path:
    """Keep what was measured of a run, its `result` and its learning curve, under the name of its folder."""
    place = kept / folder.resolve().name
    write_json(place / _LOG, read_json(folder / _LOG))
    write_json(place / _EVALUATION, result)
    return place


def find_runs(folder: Path, dataset: str, preset: str, *, kept: Path | None = KEPT, weights: bool = False) -> list[Run]:
    """All evaluated runs of the seven models on a data set with a preset, in the order of [M22] Table 2, then by seed.

    A run without `evaluation.json` is not there yet. Of runs that are not in the folder, what is `kept` counts; with
    `weights` only those count of which the weights are there.
    """
    models, stem = "|".join(PAPER_2022), re.escape(run_name(dataset, preset, ""))
    pattern = re.compile(rf"{stem}({models})(?:-([a-z0-9]+))?-seed(\d+)")
    places = [place for place in (kept, folder) if place is not None]
    folders = {path.parent.name: path.parent for place in places for path in place.glob(f"*/{_EVALUATION}")}
    matches = [(path, pattern.fullmatch(path.name)) for path in folders.values()]
    found = [Run(path, match[1], match[2] or "", int(match[3])) for path, match in matches if match]
    found, order = [run for run in found if run.has_weights or not weights], list(PAPER_2022)
    return sorted(found, key=lambda run: (order.index(run.model), run.variant, run.seed))


def by_model(runs: Sequence[Run]) -> dict[str, list[Run]]:
    """Runs without a variant, by model."""
    models = dict.fromkeys(run.model for run in runs if not run.variant)
    return {model: [run for run in runs if run.model == model and not run.variant] for model in models}


def error_table(
    runs: Sequence[Run], predictor: str = "network", parts: Sequence[str] = ("shared", "bll")
) -> Float[ndarray, "seeds styles"]:
    """The sum of some parts of a predictor's test error, for each run and each style that has test frames.

    By default what models can be compared by: the squared error of the outputs that all have, plus the error of bone
    lengths in metres ([M22] Eq. 5). Raises InputError where an evaluation lacks a part.
    """
    rows = []
    for run in runs:
        errors = run.evaluation["errors"]
        try:
            rows.append([sum(error[predictor][part] for part in parts) for error in errors.values()])
        except KeyError as missing:
            raise InputError(f"lacks {missing}; evaluate the run again", run.file) from missing
    return np.array(rows).reshape(len(rows), -1)


def common_styles(runs: Sequence[Run]) -> tuple[str, ...]:
    """The styles with test frames, which all runs must share; raises InputError where they differ."""
    styles = [tuple(run.evaluation["errors"]) for run in runs]
    for run, own in zip(runs, styles, strict=True):
        if own != styles[0]:
            raise InputError("was tested on other styles than the first run", run.file)
    return styles[0]


def with_style_network(runs: Path, name: str) -> Bundle | None:
    """The first whole run of a name in the folder of runs whose weights make codes of clips."""
    whole = (load_bundle(path.parent) for path in sorted(runs.glob(f"{name}-seed*/model.json")))
    return next((bundle for bundle in whole if bundle.makes_codes), None)
