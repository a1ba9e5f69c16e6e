"""The card of some weights: data, licence, training, and what their evaluation measured."""

from pathlib import Path
from typing import Any

from stylephase.files import read_json, write_text
from stylephase.models.bundle import Bundle

CARD, _EVALUATION = "README.md", "evaluation.json"


def write_card(folder: Path, bundle: Bundle, weights: Path) -> Path:
    """Write the card beside the weights, with the measures of `evaluation.json` where the trained run has them."""
    measured = weights / _EVALUATION
    lines = [*_origin(bundle), *(_measures(read_json(measured)) if measured.exists() else ["Not evaluated."])]
    write_text(folder / CARD, "\n".join(lines) + "\n")
    return folder / CARD


def _origin(bundle: Bundle) -> list[str]:
    about, styles = bundle.about, ", ".join(bundle.styles)
    return [
        f"# {bundle.model} on {about.get('data')}",
        "",
        f"* Data: `{about.get('data')}`, {about.get('origin')}; {str(about.get('credit')).rstrip('.')}.",
        f"* Licence: that of the data, {about.get('licence')}.",
        f"* Training: preset `{about.get('preset')}`, seed {about.get('seed')}, {about.get('steps')} steps, "
        f"phases `{about.get('phases')}`.",
        "* Contents: what runs a character. Weights and codes are in half precision, and the network that makes codes "
        "of clips is left out.",
        f"* Starts: {len(bundle.starts)} styles have a moment of their walk to begin at, to which this network walked.",
        f"* Styles: {styles}.",
        "",
    ]


def _measures(result: dict[str, Any]) -> list[str]:
    """One row for each group of styles, then one for each walk."""
    lines = ["On test frames, before halving: mean squared error of normalised outputs, and bone length error.", ""]
    lines += ["| styles | error | hold the pose | wrong code | bones, mm |", "|---|---|---|---|---|"]
    for name, errors in result["groups"].items():
        mse = [f"{errors[rival]['mse']:.3f}" if rival in errors else "" for rival in ("network", "hold", "wrong code")]
        lines += [f"| {name} | {' | '.join(mse)} | {1000 * errors['network']['bll']:.2f} |"]
    walks = result.get("rollouts", {}).get("walks", [])
    if walks:
        lines += ["", "Walks of twenty seconds:", "", *_short_of(walks), ""]
        lines += ["| style | m/s | ratio | alternate | nearest |", "|---|---|---|---|---|"]
    for walk in (walk for walk in walks if walk["finite"]):
        cells = f"{walk['speed']:.2f} | {walk['speed_ratio']:.2f} | {'yes' if walk['alternate'] else 'no'}"
        lines += [f"| {walk['style']} | {cells} | {walk['nearest']} |"]
    return lines


def _short_of(walks: list[dict[str, Any]]) -> list[str]:
    """Which styles fall short in which way; a list of names for each."""
    whole = [walk for walk in walks if walk["finite"]]
    short = {
        "do not walk on": [walk["style"] for walk in walks if not walk["finite"] or not walk["alternate"]],
        "walk at another speed than their data, by more than a quarter": [
            walk["style"] for walk in whole if not 0.75 <= walk["speed_ratio"] <= 1.25
        ],
        "are nearer to another style": [walk["style"] for walk in whole if walk["nearest"] != walk["style"]],
    }
    return [
        f"* {len(names)} of {len(walks)} {how}{': ' if names else ''}{', '.join(names)}" for how, names in short.items()
    ]
