"""Test errors of trained weights beside naive predictors, and the metrics of their rollouts."""

from pathlib import Path
from typing import Annotated

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.catalogue import load_catalogue
from stylephase.errors import InputError
from stylephase.evaluation.report import evaluate_bundle, table
from stylephase.evaluation.runs import keep_run
from stylephase.features.store import VectorStore
from stylephase.models.bundle import load_bundle


def evaluate(
    weights: Annotated[Path, typer.Option(help="Folder of trained weights, such as data/pretrained/bandai-namco.")],
    data: Annotated[str, typer.Option(help="The data set they are tested on, with the skeleton they know.")],
    seconds: Annotated[float, typer.Option(help="Length of the rollouts; 0 leaves them out.")] = 20.0,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the result in data/runs too, to be committed.")] = False,
    as_json: AsJson = False,
) -> None:
    """Test errors on unseen frames, per style, and whether rollouts walk, turn, keep their bones and show the style."""
    bundle = load_bundle(weights)
    if "phases" not in bundle.about:
        raise InputError("the weights do not say which phases they were trained with", weights)
    store = VectorStore(load_catalogue(data, bundle.styles), bundle.about["phases"])
    with tqdm(desc="rollouts", unit="frame", disable=None) as bar:
        result = evaluate_bundle(bundle, store, seconds=seconds, tick=bar.update)
    if keep:
        keep_run(weights, {"data": data, **result})
    emit({"weights": weights, "data": data, **result}, as_json=as_json, text=table(result))
