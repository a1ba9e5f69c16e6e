"""Tables and pictures of rollouts for the notebooks."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from stylephase.data.catalogue import cut_frames, load_clip, usable
from stylephase.features.body import Body
from stylephase.features.clips import WALKS
from stylephase.features.layout import FPS
from stylephase.features.store import VectorStore
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.contacts import foot_contacts
from stylephase.report.render.motion import Motion
from stylephase.runtime.rollout import Rollout, to_clip

# Words of styles that a strip should show first: the ones whose posture a reader knows.
_TELLING = (
    "old",
    "elderly",
    "proud",
    "tired",
    "giant",
    "exhausted",
    "zombie",
    "march",
    "crouched",
    "neutral",
    "normal",
)

_HEADS = (
    "style",
    "speed m/s",
    "of the data's",
    "bones %, median",
    "worst",
    "drift mm",
    "hips cm",
    "steps",
    "skate m/s",
    "turn off by °",
    "after stop m/s",
    "nearest style",
)


def interval(values: Sequence[float]) -> tuple[float, float, float]:
    """Mean, least and most."""
    return float(np.mean(values)), float(np.min(values)), float(np.max(values))


def pick(styles: Sequence[str], most: int = 5) -> list[str]:
    """Some styles for a picture: telling names first, then the rest in order."""
    telling = [style for word in _TELLING for style in styles if word in style.lower()]
    return list(dict.fromkeys([*telling, *styles]))[:most]


def walking_motion(run: Rollout, character: int, body: Body, label: str) -> Motion:
    """A rollout's character as it leaves the program: constant bones, rotations by the network."""
    clip = to_clip(run, character, body, label)
    return Motion(clip.skeleton, forward_kinematics(clip).positions, run.contacts[:, character] > 0.5, label=label)


def data_walk(store: VectorStore, style: str, label: str) -> Motion:
    """The first forward walk of a style in the data that is long enough (any take where no walk is named)."""
    catalogue, body = store.catalogue, store.body
    entries = sorted(catalogue.of(style), key=lambda entry: entry.gait not in WALKS)
    for entry in entries:
        clip = load_clip(entry, catalogue.dataset, fps=FPS, skeleton=body.skeleton)
        clip = clip.frames(*cut_frames(entry, catalogue.dataset, clip))
        if usable(len(clip)):
            break
    positions = forward_kinematics(clip).positions
    sensors = positions[:, list(body.skeleton.roles.toe_sensors[::-1])]
    return Motion(body.skeleton, positions, foot_contacts(sensors, FPS, catalogue.dataset.contact), label=label)


def summary(result: dict[str, Any]) -> str:
    """A Markdown table of the rollouts of one run."""
    rollouts = result["rollouts"]
    lines = ["| " + " | ".join(_HEADS) + " |", "|---" * len(_HEADS) + "|"]
    for walk in rollouts["walks"]:
        turn, stop = rollouts["turns"][walk["style"]], rollouts["stops"][walk["style"]]
        lines.append("| " + " | ".join([walk["style"], *_cells(walk, turn, stop)]) + " |")
    return "\n".join(lines)


def _cells(walk: dict[str, Any], turn: float, stop: float | None) -> list[str]:
    """A style's row of the summary; empty after a word where the character did not stay finite."""
    if not walk["finite"]:
        return ["not finite", *[""] * (len(_HEADS) - 2)]
    bones = walk["bones"]
    return [
        f"{walk['speed']:.2f}",
        f"{walk['speed_ratio']:.2f}",
        f"{bones['median']:.2f}",
        f"{bones['worst']:.2f}",
        f"{bones['drift']:.1f}",
        f"{100 * (walk['hips'] - walk['data_hips']):+.1f}",
        f"{walk['steps']['count']}{'' if walk['alternate'] else ' !'}",
        f"{walk['skate']:.2f}",
        f"{turn:.1f}",
        "" if stop is None else f"{stop:.2f}",
        "the right one" if walk["nearest"] == walk["style"] else walk["nearest"],
    ]
