"""The walks of one trained run in every style, measured joint by joint beside the recorded walks."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.evaluation.collars import CollarJoints, Collars, collar_joints, collars_of
from stylephase.evaluation.hands import Hands, half_ratios, hands_of, least_spread, stuck_below
from stylephase.evaluation.limbs import hand_paths
from stylephase.evaluation.predictors import predict_network
from stylephase.evaluation.runs import Run
from stylephase.evaluation.stretches import Stretch, free_walks, generated, recorded, walks_from
from stylephase.evaluation.test_error import test_rows
from stylephase.features.body import Body
from stylephase.features.store import StyleVectors, VectorStore, for_gate
from stylephase.models.bundle import Bundle, load_bundle
from stylephase.runtime.rollout import Rollout

# Hands are free of the steps where less than this share of their movement follows from the global phase, and where
# they move at all (m).
_FREE, _MOVES = 0.5, 0.05


@dataclass(frozen=True)
class Recorded:
    """All styles of a data set with their recorded walks."""

    store: VectorStore
    styles: tuple[StyleVectors, ...]

    @cached_property
    def body(self) -> Body:
        """The body of the data set."""
        return self.store.body

    @cached_property
    def walks(self) -> dict[str, list[Stretch]]:
        """Recorded walks of each style."""
        return {style.style: recorded(style, self.body.layout) for style in self.styles}

    @cached_property
    def hands(self) -> dict[str, Hands]:
        """Hands of each style."""
        return {style: hands_of(walks, self.body.layout) for style, walks in self.walks.items()}

    @cached_property
    def paths(self) -> dict[str, list[Float[ndarray, "frames 2 3"]]]:
        """Paths of the hands in each recorded walk."""
        return {style: [hand_paths(w.poses, self.body.layout) for w in walks] for style, walks in self.walks.items()}

    @cached_property
    def stuck_below(self) -> float:
        """The amplitude ratio below which a hand is stuck, from the halves of recorded walks."""
        return stuck_below(np.stack([half_ratios(paths) for paths in self.paths.values()]))

    @cached_property
    def free(self) -> tuple[str, ...]:
        """Styles without a global phase: their hands move, but not with the steps. The freest comes first."""
        found = {s: h.tied for s, h in self.hands.items() if h.tied < _FREE and h.spread.min() > _MOVES}
        return tuple(sorted(found, key=lambda style: found[style]))

    @cached_property
    def collar_joints(self) -> CollarJoints:
        """The joints of the collar bones."""
        return collar_joints(self.body)

    @cached_property
    def collars(self) -> dict[str, Collars]:
        """Collar bones of each style."""
        return {style: self.collars_in(walks) for style, walks in self.walks.items()}

    def collars_in(self, walks: Sequence[Stretch]) -> Collars:
        """Collar bones over some stretches of motion."""
        return collars_of(np.concatenate([walk.poses for walk in walks]), self.collar_joints)

    def style(self, name: str) -> StyleVectors:
        """The vectors of one style; raises InputError where it is not among them."""
        for style in self.styles:
            if style.style == name:
                return style
        raise InputError(f"no recorded walks of {name}")


@dataclass(frozen=True)
class Walked:
    """One run's free walk in every style; `walks` holds those that stayed finite."""

    bundle: Bundle
    gains: dict[str, float]
    rollout: Rollout
    data: Recorded

    @cached_property
    def walks(self) -> dict[str, Stretch]:
        """Walks after the settling frames, by style."""
        found = {s.style: generated(self.rollout, k) for k, s in enumerate(self.data.styles)}
        return {style: walk for style, walk in found.items() if walk is not None}

    @cached_property
    def hands(self) -> dict[str, Hands]:
        """Hands of each style, the share of their power being that about the recorded hands' strongest frequency."""
        layout, data = self.data.body.layout, self.data.hands
        return {style: hands_of([walk], layout, data[style].peak) for style, walk in self.walks.items()}

    @cached_property
    def collars(self) -> dict[str, Collars]:
        """Collar bones of each style."""
        return {style: self.data.collars_in([walk]) for style, walk in self.walks.items()}

    def against_least(self, style: str) -> Float[ndarray, "2"]:
        """The spread of each hand over that in the recorded walk in which it moves least."""
        return self.hands[style].spread / np.maximum(least_spread(self.data.paths[style]), 1e-9)

    def stuck(self, style: str) -> int:
        """How many hands are stuck: below the threshold even of the recorded walk in which the hand moves least."""
        return int((self.against_least(style) < self.data.stuck_below).sum())

    def again(self, style: str, starts: int, seconds: float = 20.0) -> list[Stretch | None]:
        """Walks of one style from several frames of its data; None for one that does not stay finite."""
        vectors = for_gate(self.data.style(style), self.bundle.layout)
        run = walks_from(self.bundle, vectors, self.gains[style], starts, seconds)
        return [generated(run, k) for k in range(starts)]

    def step_error(self, style: str) -> float:
        """Mean distance (m) of the hands from where they are, one step ahead on test frames; NaN without any."""
        vectors, layout = for_gate(self.data.style(style), self.bundle.layout), self.bundle.layout
        rows = test_rows(vectors)
        if not len(rows):
            return float("nan")
        predicted = predict_network(self.bundle, style)(vectors.x[rows].astype(float), vectors.p[rows].astype(float))
        places = [
            y[:, layout.y_pose].reshape(len(y), -1, 4, 3)[:, list(layout.effectors[:2]), 0]
            for y in (predicted, vectors.y[rows])
        ]
        return float(np.linalg.norm(places[0] - places[1], axis=-1).mean())


def walk_all(run: Run, data: Recorded, seconds: float = 20.0) -> Walked:
    """Let every style of a run walk straight on for some seconds, at the gain that its evaluation found."""
    bundle = load_bundle(run.folder)
    gains = {walk["style"]: float(walk["gain"]) for walk in run.evaluation["rollouts"]["walks"]}
    styles = [for_gate(style, bundle.layout) for style in data.styles]
    rollout = free_walks(bundle, styles, [gains[style.style] for style in styles], seconds)
    return Walked(bundle, gains, rollout, data)


def recordings(store: VectorStore, styles: Sequence[str]) -> Recorded:
    """The recorded walks of some styles."""
    return Recorded(store, tuple(store.load(style) for style in styles))
