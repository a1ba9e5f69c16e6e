"""What the viewer draws: capsules of the body, once, and the numbers of each frame as float32."""

from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.body import Body
from stylephase.features.layout import INPUT_SAMPLES
from stylephase.motion.skeleton import MIN_BONE
from stylephase.runtime.controller import State
from stylephase.runtime.trajectory import PAST

# Half widths of the capsules (m) by how far up the chain from a hand, a foot or the head a bone lies.
_ARM, _LEG, _TRUNK, _HEAD = (0.03, 0.036, 0.045, 0.05), (0.036, 0.042, 0.055, 0.08), 0.09, 0.09
_LIMBS = ("left hand", "right hand", "left foot", "right foot")


def body_shape(body: Body) -> dict[str, Any]:
    """Capsules as (parent, child, half width, side) by place in the vectors, and where the feet are.

    Sides are 0 for the middle, 1 for left, 2 for right. `feet` are (right, left), as the contacts are.
    """
    skeleton, place = body.skeleton, {joint: k for k, joint in enumerate(body.joints)}
    roles, thickness = skeleton.roles, dict[int, tuple[float, int]]()
    for ends, widths in ((roles.hands, _ARM), (roles.toes, _LEG)):
        for side, end in enumerate(ends, 1):
            chain = [j for j in skeleton.chain(end)[::-1] if j not in skeleton.chain(ends[2 - side])]
            for k, joint in enumerate(chain):
                thickness[joint] = widths[min(k, len(widths) - 1)], side
    capsules = [
        (place[skeleton.parents[joint]], place[joint], *thickness.get(joint, (_TRUNK, 0)))
        for joint in body.joints
        if skeleton.parents[joint] in place and np.linalg.norm(skeleton.offsets[joint]) > MIN_BONE
    ]
    feet = [place[toe] for toe in roles.toes[::-1]]
    return {"joints": len(body.joints), "capsules": capsules, "feet": feet, "head": _head(body), "limbs": _LIMBS}


def _head(body: Body) -> dict[str, float | int]:
    """The joint that carries the head, the one so called or else the last of the middle, and the head's half width."""
    skeleton, roles = body.skeleton, body.skeleton.roles
    limbs = {j for end in (*roles.hands, *roles.toes) for j in skeleton.chain(end)}
    middle = [k for k, joint in enumerate(body.joints) if joint not in limbs]
    named = [k for k in middle if "head" in skeleton.names[body.joints[k]].lower()]
    return {"joint": (named or middle or [0])[0 if named else -1], "radius": _HEAD}


def frame_numbers(state: State, speed: float) -> Float[ndarray, " values"]:
    """One frame of one character, as float32, in the order of `frame_layout`."""
    points = state.path.positions.shape[1]
    at = np.minimum(np.array(INPUT_SAMPLES) + PAST, points - 1)
    path = np.concatenate([state.path.positions[0, at], state.path.directions[0, at]], axis=1)
    parts = (state.positions[0].ravel(), path.ravel(), state.contacts[0], _dials(state.phases[0]), [speed])
    return np.concatenate(parts).astype(np.float32)


def _dials(phases: Float[ndarray, " gate_inputs"]) -> Float[ndarray, "8"]:
    """Phase vectors of the four limbs: all alike of a global phase (rad), of no length where there is no phase."""
    if len(phases) == 1:
        return np.tile([np.sin(phases[0]), np.cos(phases[0])], len(_LIMBS))
    return phases if len(phases) == 2 * len(_LIMBS) else np.zeros(2 * len(_LIMBS))


def frame_layout(joints: int) -> dict[str, tuple[int, int]]:
    """Where each part of a frame begins and ends: the joints' x, y, z; x, z and facing of the path; and so on."""
    sizes = {"positions": 3 * joints, "path": 4 * len(INPUT_SAMPLES), "contacts": 2, "phases": 8, "speed": 1}
    ends = np.cumsum(list(sizes.values())).tolist()
    return {name: (end - size, end) for (name, size), end in zip(sizes.items(), ends, strict=True)}
