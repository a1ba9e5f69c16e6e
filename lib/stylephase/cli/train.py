"""Train a model on a data set."""

from pathlib import Path
from typing import Annotated

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.catalogue import load_catalogue
from stylephase.errors import InputError
from stylephase.features.store import VectorStore
from stylephase.training.loop import Trainer
from stylephase.training.presets import preset as find_preset

_MODELS = ("lpn-film",)


def train(
    model: Annotated[str, typer.Option(help="lpn-film")],
    data: Annotated[str, typer.Option(help="A data set's name, or own:FOLDER.")],
    out: Annotated[Path, typer.Option(help="Folder for weights, log and checkpoints.")],
    preset: Annotated[str, typer.Option(help="quick, cpu or paper")] = "cpu",
    seed: Annotated[int, typer.Option(help="Seed of everything random.")] = 0,
    styles: Annotated[str | None, typer.Option(help="Names of styles, with commas between; left out: all.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the checkpoint in the folder.")] = False,
    as_json: AsJson = False,
) -> None:
    """Train a model and write it to a folder. With --resume a finished run is left as it is."""
    if model not in _MODELS:
        raise InputError(f"no model {model!r}; there are {', '.join(_MODELS)}")
    how = find_preset(preset)
    trainer = Trainer(VectorStore(load_catalogue(data, styles and styles.split(",")), how.phases), model, how, preset, seed)
    if resume:
        trainer.resume(out)
    with tqdm(total=how.steps, initial=trainer.step, desc=model, unit="step", disable=None) as bar:
        bundle = trainer.run(out, bar.update)
    last = trainer.log[-1]
    text = f"{out}: {bundle.about['steps']} steps in {trainer.seconds:.0f} s, validation error {last['validation_mse']:.4f}"
    emit({"out": out, "about": bundle.about, "last": last}, as_json=as_json, text=text)
