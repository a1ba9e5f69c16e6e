"""Everything that is measured of trained weights, as plain values and as a table."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np

from stylephase.errors import InputError
from stylephase.evaluation.rollouts import judge_rollouts
from stylephase.evaluation.style import recognised, style_space
from stylephase.evaluation.test_error import mean_over, test_errors
from stylephase.features.store import StyleVectors, VectorStore, for_gate
from stylephase.models.bundle import Bundle
from stylephase.training.codes import clip_codes
from stylephase.training.sampler import Scaling

# Rollouts begin with three seconds that only settle, and last no longer than this (s).
_SHORTEST, _LONGEST = 5.0, 3600.0
_PREDICTORS = ("network", "dropout", "wrong code", "ridge", "hold", "mean", "untrained")


def groups_of(styles: tuple[str, ...]) -> dict[str, list[str]]:
    """Styles by the part of their name before a hyphen (`set1`, `set2`), where all have one; else all in one group.

    >>> groups_of(("set1-old", "set2-elderly", "set1-sad"))
    {'set1': ['set1-old', 'set1-sad'], 'set2': ['set2-elderly']}
    """
    prefixes = {style.partition("-")[0] for style in styles if "-" in style}
    named = all("-" in style for style in styles) and len(prefixes) > 1
    return (
        {p: [s for s in styles if s.startswith(f"{p}-")] for p in sorted(prefixes)} if named else {"all": list(styles)}
    )


def code_spread(bundle: Bundle, styles: list[StyleVectors]) -> dict[str, float] | None:
    """Deviation of style codes between styles and within a style: equal ones would show a dead generator.

    None for weights without one.
    """
    generator = bundle.network.generator
    if generator is None or not bundle.makes_codes:
        return None
    scaling = Scaling(bundle.normaliser, bundle.layout)
    groups = [clip_codes(generator, style, scaling).numpy() for style in styles]
    between = np.array([group.mean(axis=0) for group in groups]).var(axis=0).mean()
    within = np.mean([group.var(axis=0).mean() for group in groups])
    return {"between": float(np.sqrt(between)), "within": float(np.sqrt(within))}


def evaluate_bundle(
    bundle: Bundle, store: VectorStore, *, seconds: float, tick: Callable[[int], object]
) -> dict[str, Any]:
    """Test errors, code spread, and rollouts of some seconds, or none for 0.

    Raises InputError where the data have another skeleton, and for rollouts that are too short or too long.
    """
    if seconds != 0 and not _SHORTEST <= seconds <= _LONGEST:
        raise InputError(f"rollouts of {seconds:g} s; expected 0 for none, or {_SHORTEST:g} to {_LONGEST:g}")
    own, known = store.body.skeleton, bundle.body.skeleton
    if (own.names, own.parents) != (known.names, known.parents):
        raise InputError(f"the weights know another skeleton than {store.catalogue.dataset.name} has")
    styles = [for_gate(store.load(style), bundle.layout) for style in store.catalogue.styles]
    errors = test_errors(bundle, styles)
    groups = {name: mean_over(errors, members) for name, members in groups_of(store.catalogue.styles).items()}
    result: dict[str, Any] = {
        "about": bundle.about,
        "parameters": sum(parameter.numel() for parameter in bundle.network.parameters()),
        "input_rate": bundle.settings.input_rate,
        "errors": {style: {name: asdict(error) for name, error in one.items()} for style, one in errors.items()},
        "groups": {name: {rival: asdict(error) for rival, error in one.items()} for name, one in groups.items()},
        "codes": code_spread(bundle, styles),
    }
    if seconds > 0:
        space = style_space(styles, bundle.layout)
        judgement, _ = judge_rollouts(bundle, styles, space, seconds=seconds, tick=tick)
        right, clips = recognised(space, styles, bundle.layout, "test")
        result |= {"rollouts": judgement.to_json(), "recognised": {"right": right, "clips": clips}}
    return result


def table(result: dict[str, Any]) -> str:
    """The main numbers for reading."""
    lines = ["mean squared error of normalised outputs, and bone length error (mm), on test frames"]
    for name, errors in result["groups"].items():
        lines += [f"  {name}"]
        lines += [
            f"    {p:10} {errors[p]['mse']:8.4f} {1000 * errors[p]['bll']:8.2f}" for p in _PREDICTORS if p in errors
        ]
    if "rollouts" in result:
        lines += [
            "",
            f"{'rollout':20} speed  ratio  bones %  worst  off mm  hips cm  steps  skate  turn  stop  nearest",
        ]
        lines += [_walk_line(walk, result["rollouts"]) for walk in result["rollouts"]["walks"]]
    return "\n".join(lines)


def _walk_line(walk: dict[str, Any], rollouts: dict[str, Any]) -> str:
    if not walk["finite"]:
        return f"{walk['style']:20} did not stay finite"
    bones, hips, ratio = walk["bones"], 100 * (walk["hips"] - walk["data_hips"]), walk["speed_ratio"]
    steps = f"{walk['steps']['count']:3d}{' ' if walk['alternate'] else '!'}"
    turn, stop = rollouts["turns"][walk["style"]], rollouts["stops"][walk["style"]]
    return (
        f"{walk['style']:20} {walk['speed']:5.2f}  {ratio:5.2f}  {bones['median']:7.2f}  {bones['worst']:5.2f}"
        f"  {bones['off']:6.1f}  {hips:7.1f}  {steps:>5}  {walk['skate']:5.2f}  {turn:4.1f}"
        f"  {'-' if stop is None else format(stop, '4.2f'):>4}  {walk['nearest']}"
    )
