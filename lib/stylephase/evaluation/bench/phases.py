"""How fast phases are read: the closed form against general solvers, and the whole of 100STYLE.

Times are those of the processor, not of the clock, so that another program beside this one counts little; rivals take
turns.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.evaluation.bench.rows import Row, interleaved, threads
from stylephase.evaluation.evolution import evolve
from stylephase.evaluation.fits import STARTS, curve_fits, windows_of
from stylephase.features.layout import FPS
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.contacts import ContactRule
from stylephase.motion.synthetic import find_style, steady, walk
from stylephase.phase.local import PhaseVariant, variant
from stylephase.phase.sinusoid import fit_sinusoids
from stylephase.phase.source import Movement, prepared, sourcing
from stylephase.phase.take import movement_of, movement_phases

# Frames of the training set of [M22] and its 95 styles, about so many with their mirrors left out.
_FRAMES, _EFFECTORS = 4_000_000, 4
# Styles of the walker that are read, for so long each (s), as long as a take of 100STYLE.
_STYLES, _SECONDS = ("Plain", "OffbeatArms", "StoopedOver"), 60.0
_CONTACT = ContactRule(speed=0.03, height=0.02)
# Windows that the slow references fit, and rounds of which the median counts.
_SLOW, _ROUNDS = 60, 3
_RATE = "windows/s of one core"


def takes() -> tuple[Movement, ...]:
    """Movements of the walker."""
    return tuple(_take(name) for name in _STYLES)


def _take(name: str) -> Movement:
    style = find_style(name)
    clip, _ = walk(style, "FW", plan=steady(_SECONDS, forward=style.speed))
    return movement_of(forward_kinematics(clip), clip.skeleton, FPS, _CONTACT)


def fit_rows(signal: Float[ndarray, " frames"], fps: float = FPS, *, slow: int = _SLOW) -> list[Row]:
    """Windows fitted a second without neighbours: ours against SciPy's solver and the evolutionary search."""
    few = windows_of(signal, np.linspace(0, len(signal) - 1, slow).astype(int), fps)
    short = signal[: 4 * slow]
    work = {
        "ours": (len(signal), partial(fit_sinusoids, signal, fps, rounds=0)),
        "bounded curve_fit, one start": (slow, partial(curve_fits, few, STARTS[:1])),
        "bounded curve_fit, two starts": (slow, partial(curve_fits, few, STARTS)),
        "evolutionary search": (len(short), lambda: evolve(short, fps, np.random.default_rng(0), coupled=False)),
    }
    seconds = interleaved({name: run for name, (_, run) in work.items()}, rounds=_ROUNDS, each=1)
    rates = {name: count / max(seconds[name], 1e-9) for name, (count, _) in work.items()}
    ours, bounds = rates.pop("ours"), (150.0, 300.0, None)
    return [
        Row(f"sinusoids fitted, {name}", ours, rate, _RATE, least=60_000.0, ratio_least=bound)
        for (name, rate), bound in zip(rates.items(), bounds, strict=True)
    ]


def whole_rows(movements: Sequence[Movement]) -> list[Row]:
    """Minutes of one core for all phases of 100STYLE, by what some takes need; the search for one coupled fit only."""
    frames = sum(len(movement.places) for movement in movements)
    source = _source(movements[0], variant("release"))[: 4 * _SLOW]
    work: dict[str, Callable[[], object]] = {
        name: partial(_read, movements, variant(name)) for name in ("release", "adaptive")
    }
    work["search"] = lambda: evolve(source, FPS, np.random.default_rng(0))
    seconds = interleaved(work, rounds=_ROUNDS, each=1)
    search = seconds["search"] / len(source) * _FRAMES * _EFFECTORS / 60
    note = "reference: one coupled fit by the search; extrapolated from the walker's takes; two cores halve it"
    minutes = {name: seconds[name] / frames * _FRAMES / 60 for name in ("release", "adaptive")}
    return [
        Row(f"phases of 100STYLE, {name}", own, search, "min of one core", most=bound, note=note)
        for (name, own), bound in zip(minutes.items(), (12.0, None), strict=True)
    ]


def _read(movements: Sequence[Movement], how: PhaseVariant) -> None:
    for movement in movements:
        movement_phases(movement, sourcing([movement]), how)


def _source(movement: Movement, how: PhaseVariant) -> Float[ndarray, " frames"]:
    """The prepared source function of the left foot."""
    return prepared(sourcing([movement]).functions(movement), movement.fps, how.normalise_seconds)[:, 2]


def phase_rows() -> list[Row]:
    """All rows about phases, on the walker and one thread."""
    movements = takes()
    signal = np.concatenate([_source(movement, variant("release")) for movement in movements])
    with threads(1):
        return fit_rows(signal) + whole_rows(movements)
