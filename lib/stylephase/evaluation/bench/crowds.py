"""How many characters a second a crowd of so many takes, each with a style and a path of its own."""

import time

import numpy as np
import torch

from stylephase.evaluation.bench.frames import bundle_at_hand, walking
from stylephase.evaluation.bench.rows import Row, interleaved, threads
from stylephase.evaluation.robustness import random_paths
from stylephase.runtime.controller import Controller, ControllerSettings
from stylephase.runtime.paths import FollowPaths

_SIZES = (1, 10, 100, 1000)
_ROUNDS, _EACH = 4, 4
# Frames a second that are needed to be live.
_LIVE = 60


def crowd_rows() -> list[Row]:
    """Whole ticks of crowds on one thread, by the processor's clock, against each character by itself."""
    bundle, rng = bundle_at_hand(), np.random.default_rng(0)
    codes = torch.stack(list(bundle.codes.values()))
    one, rivals = walking(bundle, codes[:1]), {}
    for size in _SIZES:
        controller = Controller(bundle, codes[np.arange(size) % len(codes)], ControllerSettings())
        plan, state = FollowPaths(random_paths(size, 20.0, rng), np.full(size, 6.0)), one.repeated(size)
        rivals[size] = lambda c=controller, p=plan, s=state: c.step(s, p(0, s))
    with threads(1):
        taken = interleaved(
            {str(size): run for size, run in rivals.items()}, rounds=_ROUNDS, each=_EACH, clock=time.process_time
        )
    rates = {size: size / taken[str(size)] for size in _SIZES}
    note = "reference: one character by itself"
    return [
        Row(
            f"characters a second, crowd of {size}",
            rate,
            rates[1],
            "1/s",
            note=f"{note}; {rate / _LIVE:.0f} live at once",
        )
        for size, rate in rates.items()
    ]
