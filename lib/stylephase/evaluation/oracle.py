"""The authors' released network as a witness of phases: what it says of a movement, beside the movement itself.

The authors' labels were never released, but the network learnt them from 4 million frames: it predicts the phases of
the next frame, and which feet are in contact. Ours can be read from the same movement and compared.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy import ndarray

from stylephase.data.catalogue import Catalogue, cut_frames, load_clip
from stylephase.data.layouts import Entry
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.features.vectors import vectors
from stylephase.models.bundle import Bundle
from stylephase.models.released import UNUSABLE
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.contacts import ContactRule, slow_and_low
from stylephase.phase.source import Movement
from stylephase.phase.take import movement_of
from stylephase.runtime.controller import RELEASE, Controller, State, start_state
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import Tick, quiet

# The styles that a threshold may be chosen on; the others are reported.
TUNED_ON = ("Neutral", "Zombie", "Swimming", "PendulumHands", "Proud")
# The gain at which the release walks (m/s), the frames of a walk, and those of them that only settle.
_GAIN, FRAMES, SETTLE = 6.0, 960, 200
# A generated foot is never as still as a recorded one: the network's own velocity of a standing toe is 0.05 to
# 0.12 m/s.
# On the styles of TUNED_ON speeds of 0.15 to 0.3 m/s and heights from 2 cm up give the same phases within 0.003 cycles.
GENERATED_CONTACT = ContactRule(speed=0.3, height=0.02)
_CONTACT = 0.5


@dataclass(frozen=True)
class Witnessed:
    """A movement, and what the network says of each of its frames.

    `phases` are phase vectors of LeftHand, RightHand, LeftFoot, RightFoot, `contacts` those of the right and left foot.
    """

    name: str
    movement: Movement
    phases: Float[ndarray, "frames 8"]
    contacts: Bool[ndarray, "frames 2"]


def usable_styles(bundle: Bundle) -> tuple[str, ...]:
    """The released styles that walk when they are steered forward."""
    return tuple(style for style in bundle.styles if style not in UNUSABLE)


def walks(
    bundle: Bundle, styles: Sequence[str], *, frames: int = FRAMES, settle: int = SETTLE, tick: Tick = quiet
) -> tuple[Witnessed, ...]:
    """Each style walks straight ahead under the release's controller, from the mean pose with phases at zero.

    All styles walk side by side, `frames` frames of 60 a second, of which the first `settle` are left out.
    """
    count, n, body = len(styles), bundle.normaliser, bundle.body
    codes = torch.stack([bundle.code(style) for style in styles])
    controller, plan = Controller(bundle, codes, RELEASE), Steady(np.full(count, _GAIN))
    state = start_state(np.tile(n.x_mean, (count, 1)), np.zeros((count, 8)), body.layout)
    states = []
    for frame in range(frames):
        state = controller.step(state, plan(frame, state))
        states += [state] if frame >= settle else []
        tick(1)
    phases, contacts = (np.stack([getattr(s, name) for s in states], axis=1) for name in ("phases", "contacts"))
    return tuple(
        Witnessed(style, _movement(states, k, body, GENERATED_CONTACT), phases[k], contacts[k] > _CONTACT)
        for k, style in enumerate(styles)
    )


def _movement(states: Sequence[State], character: int, body: Body, rule: ContactRule) -> Movement:
    """The movement of one character, from positions, orientations and velocities that the network gave.

    Whether a toe is slow is read from its predicted velocity. Its predicted place slides: the controller takes 85 %
    of the root's step.
    """
    positions, velocities = (np.stack([getattr(s, k)[character] for s in states]) for k in ("positions", "velocities"))
    hips = np.stack([s.rotations[character, 0] for s in states])
    roles, place = body.skeleton.roles, body.joints.index
    relative = positions[:, [place(joint) for joint in roles.effectors]] - positions[:, :1]
    toes = [place(joint) for joint in roles.toes[::-1]]
    contacts = generated_contacts(positions[:, toes, 1], np.linalg.norm(velocities[:, toes], axis=-1), rule)
    return Movement(np.einsum("tji,tkj->tki", hips, relative), contacts, FPS)


def generated_contacts(
    heights: Float[ndarray, "frames feet"], speeds: Float[ndarray, "frames feet"], rule: ContactRule
) -> Bool[ndarray, "frames feet"]:
    """Contacts of feet whose heights (m) and speeds (m/s) are predicted, under the rule and filter of recorded ones."""
    return slow_and_low(speeds, heights, FPS, rule)


def recordings(bundle: Bundle, catalogue: Catalogue) -> tuple[Witnessed, ...]:
    """What the network says of recorded walks: each frame is shown to it as it was, only its phases are its own.

    Its phases begin at their mean and are fed back as its controller does ([M22] release 5.3).
    """
    return tuple(_recording(bundle, catalogue, entry) for entry in catalogue.without_idle().entries)


def _recording(bundle: Bundle, catalogue: Catalogue, entry: Entry) -> Witnessed:
    body, layout = bundle.body, bundle.layout
    clip = load_clip(entry, catalogue.dataset, fps=FPS, skeleton=body.skeleton)
    clip = clip.frames(*cut_frames(entry, catalogue.dataset, clip))
    pose = forward_kinematics(clip)
    movement = movement_of(pose, body.skeleton, FPS, catalogue.dataset.contact)
    silent = np.zeros((len(clip), layout.gate_inputs))
    shown = vectors(pose, body.skeleton, body.rest, FPS, silent, movement.contacts).x
    told = _told(Controller(bundle, bundle.code(entry.style)[None], RELEASE), shown, bundle.normaliser.p_mean)
    # A row speaks of the frame after the one that it was shown.
    later = Movement(movement.places[1:], movement.contacts[1:], FPS)
    return Witnessed(clip.name, later, told[:, layout.y_phases], told[:, layout.y_contacts] > _CONTACT)


def _told(controller: Controller, shown: Float[ndarray, "rows inputs"], start: Float[ndarray, "8"]) -> ndarray:
    """The network's outputs for one frame after the other, its phases fed back."""
    phases, layout, told = start.astype(float), controller.layout, []
    for x in shown:
        (y,) = controller.predict(x[None], phases[None])
        carried = phases + y[layout.y_phase_updates]
        phases = RELEASE.phase_share * y[layout.y_phases] + (1 - RELEASE.phase_share) * carried
        told.append(y)
    return np.stack(told)
