"""Train a model on a data set."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.catalogue import check_styles, load_catalogue
from stylephase.data.registry import OWN
from stylephase.errors import InputError
from stylephase.features.captures import check_upright
from stylephase.features.store import VectorStore
from stylephase.files import read_json
from stylephase.models.bundle import Bundle, is_bundle, load_bundle
from stylephase.models.zoo import MODELS
from stylephase.models.zoo import model as find_model
from stylephase.training.checkpoint import LOG, check_folder, remove_checkpoint
from stylephase.training.loop import Trainer, identity_of
from stylephase.training.presets import Preset, preset_for
from stylephase.training.team import Team, find_team


def train(
    model: Annotated[str, typer.Option(help=", ".join(MODELS))],
    data: Annotated[str, typer.Option(help="A data set's name, or own:FOLDER.")],
    out: Annotated[Path, typer.Option(help="Folder for weights, log and checkpoints.")],
    preset: Annotated[str, typer.Option(help="quick, cpu or paper")] = "cpu",
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    styles: Annotated[str | None, typer.Option(help="Names of styles, with commas between; left out: all.")] = None,
    without: Annotated[str | None, typer.Option(help="Names of styles to leave out, with commas between.")] = None,
    input_dropout: Annotated[
        float | None, typer.Option(min=0.0, max=0.9, help="Dropout of the input in place of the preset's.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the run in the folder.")] = False,
    as_json: AsJson = False,
) -> None:
    """Train a model and write it to a folder, which must hold no run yet.

    With --resume an interrupted run in the folder goes on, and a finished one is left as it is. Started by torchrun,
    several processes share each batch.
    """
    find_model(model)
    how = preset_for(preset, model)
    if input_dropout is not None:
        how = replace(how, network=replace(how.network, input_rate=input_dropout))
        preset = f"{preset} with input dropout {input_dropout:g}"
    catalogue = load_catalogue(data, _chosen(data, styles, without))
    if data.startswith(OWN) and not is_bundle(out):
        check_upright(catalogue)
    store = VectorStore(catalogue, how.phases)
    check_folder(out, identity_of(store, model, how, preset, seed), resume=resume)
    with find_team() as team:
        if is_bundle(out):
            bundle = load_bundle(out)
            if team.leads:
                remove_checkpoint(out)
        else:
            bundle = _run(store, model, how, preset, seed, out, team)
    if not team.leads:
        return
    about, last = bundle.about, read_json(out / LOG)[-1]
    text = f"{out}: {about['steps']} steps in {about['seconds']:.0f} s, training error {last['mse']:.4f}"
    if last["validation_mse"] is not None:
        text += f", validation error {last['validation_mse']:.4f}"
    emit({"out": out, "about": about, "last": last}, as_json=as_json, text=text)


def _chosen(data: str, styles: str | None, without: str | None) -> list[str] | None:
    """The styles that are asked for, or None for all; raises InputError where none is left, or one is not known."""
    asked = None if styles is None else styles.split(",")
    if without is None:
        return asked
    known, left_out = load_catalogue(data, asked).styles, without.split(",")
    check_styles(left_out, known)
    if kept := [style for style in known if style not in left_out]:
        return kept
    raise InputError("--without leaves no style to learn")


def _run(store: VectorStore, model: str, how: Preset, preset: str, seed: int, out: Path, team: Team) -> Bundle:
    """Train from the start, or from the checkpoint in `out`, which `check_folder` has found to be of this run."""
    trainer = Trainer(store, model, how, preset, seed, team)
    trainer.resume(out)
    with tqdm(
        total=how.steps, initial=trainer.step, desc=model, unit="step", disable=None if team.leads else True
    ) as bar:
        return trainer.run(out, bar.update)
