"""What is wrong with a walk, as numbers that grow with the fault, and how flat a learning curve has become."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.evaluation.runs import Run

# A walk at a speed within this factor of the data's keeps its speed.
_SPEED = (0.75, 1.25)
# The share of the training whose slope is looked at.
_LAST = 0.2

Walk = dict[str, Any]

# Each flaw of a walk by name, larger where it is worse; None where it cannot be said.
_FLAWS = {
    "does not stay finite": lambda walk: float(not walk["finite"]),
    "feet do not alternate": lambda walk: float(not walk["alternate"]),
    "bones vary (%, median)": lambda walk: walk["bones"]["median"],
    "bones vary (%, worst)": lambda walk: walk["bones"]["worst"],
    "speed off (log ratio)": lambda walk: None if walk["speed_ratio"] is None else _off(walk["speed_ratio"]),
    "hips off (m)": lambda walk: None if walk["hips"] is None else abs(walk["hips"] - walk["data_hips"]),
    "feet skate (m/s)": lambda walk: walk["skate"],
    "another style is nearer": lambda walk: float(walk["nearest"] != walk["style"]),
    "not sound": lambda walk: float(not sound(walk)),
}


def _off(speed_ratio: float) -> float:
    return float(abs(np.log(max(speed_ratio, 1e-3))))


def sound(walk: Walk) -> bool:
    """Whether a walk is finite, its feet alternate, it keeps its speed, and its own style is the nearest."""
    if not (walk["finite"] and walk["alternate"] and walk["nearest"] == walk["style"]):
        return False
    return _SPEED[0] <= walk["speed_ratio"] <= _SPEED[1]


def flaws(runs: Sequence[Run]) -> dict[str, Float[ndarray, "runs styles"]]:
    """Each flaw of the walks of some runs, by run and style; NaN where a walk did not stay finite."""
    walks = [run.evaluation["rollouts"]["walks"] for run in runs]
    table = {name: [[of(walk) for walk in one] for one in walks] for name, of in _FLAWS.items()}
    return {name: np.array(rows, dtype=float) for name, rows in table.items()}


def still_falling(log: Sequence[dict[str, Any]], key: str = "validation_mse") -> float:
    """The share by which an error changes over the last fifth of the training, by a line through its logarithm.

    Negative while it falls. NaN where the log has no such error, or fewer than two points in that fifth.
    """
    last = [point for point in log if point["step"] >= (1 - _LAST) * log[-1]["step"]]
    if len(last) < 2 or any(point[key] is None for point in last):
        return float("nan")
    steps, errors = (np.array([point[k] for point in last], dtype=float) for k in ("step", key))
    slope = np.polyfit(steps - steps.mean(), np.log(errors), 1)[0]
    return float(np.expm1(slope * _LAST * log[-1]["step"]))


def trade_off(runs: Sequence[Run]) -> dict[str, Float[ndarray, " runs"]]:
    """What input dropout costs and buys, run by run in the order of their rate.

    One-step error (shared outputs), the factor by which a wrong code multiplies it, and shares of walks whose own
    style is the nearest, that are sound, and the variation of their bones (%) and the skating of their feet (m/s).
    """
    ordered = sorted(runs, key=lambda run: (run.input_rate, run.seed))
    errors = [run.evaluation["errors"].values() for run in ordered]
    means = [{name: np.mean([e[name]["shared"] for e in one]) for name in ("network", "wrong code")} for one in errors]
    found = flaws(ordered)
    return {
        "rate": np.array([run.input_rate for run in ordered]),
        "seed": np.array([run.seed for run in ordered], dtype=float),
        "error": np.array([mean["network"] for mean in means]),
        "wrong code": np.array([mean["wrong code"] / mean["network"] for mean in means]),
        "recognised": 1 - found["another style is nearer"].mean(axis=1),
        "sound": 1 - found["not sound"].mean(axis=1),
        "bones": np.nanmedian(found["bones vary (%, median)"], axis=1),
        "skate": np.nanmean(found["feet skate (m/s)"], axis=1),
    }
