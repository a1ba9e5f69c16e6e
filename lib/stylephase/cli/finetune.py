"""Teach trained FiLM weights a new style from BVH files."""

import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.errors import InputError
from stylephase.evaluation.predictors import predict_network
from stylephase.evaluation.test_error import error_of
from stylephase.features.captures import captured_vectors
from stylephase.features.store import StyleVectors, for_gate
from stylephase.files import write_json
from stylephase.models.bundle import Bundle, check_new_style, load_bundle, save_bundle
from stylephase.training.checkpoint import LOG
from stylephase.training.finetune import FineTuning, fine_tune, with_new_codes
from stylephase.training.losses import bone_lengths


def finetune(
    base: Annotated[Path, typer.Option(help="Folder of trained FiLM weights.")],
    bvh: Annotated[list[Path], typer.Option(help="Files of the new style, on the weights' skeleton.")],
    style: Annotated[str, typer.Option(help="Name of the new style.")],
    out: Annotated[Path, typer.Option(help="Folder for the weights that know one style more.")],
    more: Annotated[list[Path] | None, typer.Argument(metavar="[FILE]...", help="More files after --bvh.")] = None,
    steps: Annotated[int, typer.Option(min=1, help="Steps of the fine-tuning.")] = FineTuning.steps,
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything random.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Fine-tune the style network alone on a new style; the motion network and the codes of other styles stay."""
    check_new_style(style, out)
    weights, files = load_bundle(base), [*bvh, *(more or ())]
    phases, data = (str(weights.about.get(key, "")) for key in ("phases", "data"))
    if not phases:
        raise InputError("the weights do not say which phases they were trained with", base)
    vectors = captured_vectors(files, style, weights.body, phases, data)
    before, begun = with_new_codes(weights, [vectors]), time.monotonic()
    # Before the first step, so that a folder that cannot be written costs no training.
    write_json(out / LOG, [])
    with tqdm(total=steps, desc=style, unit="step", disable=None) as bar:
        tuned = fine_tune(weights, [vectors], FineTuning(steps=steps), seed=seed, tick=bar.update)
    learned = {"style": style, "frames": len(vectors.x), "files": len(files), "steps": steps, "seed": seed}
    about = weights.about | {"fine_tuned": [*weights.about.get("fine_tuned", []), learned]}
    write_json(out / LOG, [{"step": n, "mse": mse, "bll": bll} for n, (mse, bll) in enumerate(tuned.errors)])
    save_bundle(out, replace(tuned.bundle, about=about))
    _tell(out, learned | {"base": base, "seconds": time.monotonic() - begun}, before, tuned.bundle, vectors, as_json)


def _tell(
    out: Path, learned: dict[str, Any], before: Bundle, after: Bundle, vectors: StyleVectors, as_json: bool
) -> None:
    """Print the errors with the code before and after, on frames that did not train where there are any."""
    part = "test" if len(vectors.rows("test")) else "train"
    seen, lengths = for_gate(vectors, after.layout), bone_lengths(after.body)
    errors = [error_of(predict_network(b, vectors.style), seen, b, lengths, part) for b in (before, after)]
    result = {"out": out} | learned | {"styles": list(after.styles), "part": part}
    result |= {name: asdict(error) for name, error in zip(("before", "after"), errors, strict=True)}
    text = f"{out}: {vectors.style} learned from {learned['frames']} frames in {learned['seconds']:.0f} s; "
    text += f"error on {part} frames {errors[0].mse:.4f} before, {errors[1].mse:.4f} after"
    emit(result, as_json=as_json, text=text)
