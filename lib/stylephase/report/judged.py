"""The values behind the claims about training and rollouts, from the evaluations of one or more seeds.

Of several seeds the worst counts, so that a claim that holds does so for each of them.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from stylephase.errors import InputError

Evaluation = dict[str, Any]


def worst(values: Sequence[float], largest: bool = True) -> float:
    """The largest of some values, or the smallest where small is bad."""
    return float(max(values) if largest else min(values))


def error_ratio(results: Sequence[Evaluation], group: str, over: str, under: str) -> list[float]:
    """Per seed, one predictor's test error over another's."""
    errors = [result["groups"][group] for result in results]
    return [error[over]["mse"] / error[under]["mse"] for error in errors]


def one_step_values(results: Sequence[Evaluation], group: str) -> dict[str, float]:
    """Claims about one step ahead for one group of styles, such as `set2`."""
    rivals = {
        name: worst(error_ratio(results, group, "network", name)) for name in ("hold", "mean", "ridge", "untrained")
    }
    values = {f"ours-onestep-{name}-{group}": value for name, value in rivals.items()}
    return values | {
        f"ours-wrong-code-{group}": worst(error_ratio(results, group, "wrong code", "network"), largest=False)
    }


def rollout_values(results: Sequence[Evaluation]) -> dict[str, float | list[float]]:
    """Claims about the rollouts of all styles: measures are of those that stayed finite, counts of all.

    Raises InputError where none did.
    """
    walks = [result["rollouts"]["walks"] for result in results]
    finite = [[walk for walk in one if walk["finite"]] for one in walks]
    if not all(finite):
        raise InputError("a run has no rollout that stayed finite")

    def highest(value: Callable[[list[Evaluation]], float]) -> float:
        return worst([value(one) for one in finite])

    def fewest(of: Callable[[Evaluation], bool], group: str = "") -> float:
        return float(min(sum(of(walk) for walk in one if walk["style"].startswith(group)) for one in walks))

    ratios = [walk["speed_ratio"] for one in finite for walk in one]
    return {
        "ours-rollout-finite": fewest(lambda walk: walk["finite"]),
        "ours-rollout-bone-median": highest(lambda one: float(np.median([w["bones"]["median"] for w in one]))),
        "ours-rollout-bone-worst": highest(lambda one: max(w["bones"]["worst"] for w in one)),
        "ours-rollout-bone-drift": highest(lambda one: max(w["bones"]["drift"] for w in one)),
        "ours-rollout-bone-off": highest(lambda one: max(w["bones"]["off"] for w in one)),
        "ours-rollout-hips": highest(lambda one: max(abs(w["hips"] - w["data_hips"]) for w in one)),
        "ours-rollout-alternation": fewest(lambda walk: walk["alternate"]),
        "ours-rollout-alternation-set2": fewest(lambda walk: walk["alternate"], "set2-"),
        "ours-rollout-speed": [min(ratios), max(ratios)],
        "ours-rollout-style-set2": fewest(_right, "set2-"),
        "ours-rollout-style-all": fewest(_right),
        "ours-rollout-turns": worst([max(result["rollouts"]["turns"].values()) for result in results]),
    }


def stop_range(results: Sequence[Evaluation]) -> tuple[float, float]:
    """Lowest and highest speed (m/s) in the last seconds after being told to stop, of what stayed finite."""
    speeds = [speed for result in results for speed in result["rollouts"]["stops"].values() if speed is not None]
    return min(speeds), max(speeds)


def code_ratio(results: Sequence[Evaluation]) -> float:
    """Spread of style codes between styles over that within, of the worst seed."""
    return worst([result["codes"]["between"] / result["codes"]["within"] for result in results], largest=False)


def _right(walk: Evaluation) -> bool:
    return walk["nearest"] == walk["style"]
