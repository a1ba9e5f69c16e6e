"""Names for the parts of the vectors of Holden et al. 2017, whose PFNN was released: 342 values in, 311 out.

12 trajectory points, 10 frames apart from a second ago to 5/6 s ahead, and 31 joints. The input describes the
trajectory about the present root, and the pose of the frame before about that frame's root; the output the pose of
the present frame, the step of the root, and the future about the root after that step. Values come one kind at a
time, not joint by joint. Metres, and metres a frame.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Int
from numpy import ndarray

SAMPLES = tuple(range(-60, 60, 10))
FUTURE_SAMPLES = tuple(range(0, 60, 10))
JOINTS = 31
INPUTS, OUTPUTS = 342, 311
GAITS = ("stand", "walk", "jog", "crouch", "jump", "bump")
_POINTS, _FUTURE, _POSE = len(SAMPLES), len(FUTURE_SAMPLES), 3 * JOINTS

# Input. Places (x, then z, of all points), facings likewise, six gait labels at each point, then the joints, then the
# height of the ground at each point (to the right, beneath, to the left).
X_PLACES = slice(0, 2 * _POINTS)
X_FACINGS = slice(X_PLACES.stop, 4 * _POINTS)
X_GAITS = slice(X_FACINGS.stop, 10 * _POINTS)
X_POSITIONS = slice(X_GAITS.stop, X_GAITS.stop + _POSE)
X_VELOCITIES = slice(X_POSITIONS.stop, X_POSITIONS.stop + _POSE)
X_GROUND = slice(X_VELOCITIES.stop, INPUTS)

# Output. Step of the root (left, forward), its turn to the right (rad), change of phase (cycles), contacts of heel and
# toe (left, right), the future, then positions, velocities and rotations (as logarithms) of the joints.
Y_STEP = slice(0, 2)
Y_TURN, Y_PHASE = 2, 3
Y_CONTACTS = slice(4, 8)
Y_PLACES = slice(8, 8 + 2 * _FUTURE)
Y_FACINGS = slice(Y_PLACES.stop, 8 + 4 * _FUTURE)
Y_POSITIONS = slice(Y_FACINGS.stop, Y_FACINGS.stop + _POSE)
Y_VELOCITIES = slice(Y_POSITIONS.stop, Y_POSITIONS.stop + _POSE)
Y_ROTATIONS = slice(Y_VELOCITIES.stop, OUTPUTS)

# Joints of the 31 by role: hips, and toes (left, right).
HIPS, TOES = 0, (5, 10)
# Legs and arms, left and right.
_SIDES = ((slice(1, 6), slice(6, 11)), (slice(17, 24), slice(24, 31)))
# Columns of the contacts that are the toes' (right, left), the order of this library.
TOE_CONTACTS = (3, 1)

_X_LENGTHS = (X_PLACES, X_POSITIONS, X_VELOCITIES, X_GROUND)
_Y_LENGTHS = (Y_STEP, Y_PLACES, Y_POSITIONS, Y_VELOCITIES)


def x_lengths() -> Bool[ndarray, " inputs"]:
    """Which values of the input have a unit of length."""
    return _marked(INPUTS, _X_LENGTHS)


def y_lengths() -> Bool[ndarray, " outputs"]:
    """Which values of the output have a unit of length."""
    return _marked(OUTPUTS, _Y_LENGTHS)


def x_mirror() -> tuple[Int[ndarray, " inputs"], Float[ndarray, " inputs"]]:
    """Column and sign of each value of the input when left and right change places."""
    columns, signs = np.arange(INPUTS), np.ones(INPUTS)
    _sideways(signs, X_PLACES, X_FACINGS)
    _swap_joints(columns, signs, (X_POSITIONS, X_VELOCITIES), (-1, 1, 1))
    columns[X_GROUND] = columns[X_GROUND].reshape(3, -1)[::-1].ravel()
    return columns, signs


def y_mirror() -> tuple[Int[ndarray, " outputs"], Float[ndarray, " outputs"]]:
    """The same of the output; a rotation as logarithm keeps its part about the axis to the side."""
    columns, signs = np.arange(OUTPUTS), np.ones(OUTPUTS)
    signs[[Y_STEP.start, Y_TURN]] = -1
    columns[Y_CONTACTS] = columns[Y_CONTACTS].reshape(2, -1)[::-1].ravel()
    _sideways(signs, Y_PLACES, Y_FACINGS)
    _swap_joints(columns, signs, (Y_POSITIONS, Y_VELOCITIES), (-1, 1, 1))
    _swap_joints(columns, signs, (Y_ROTATIONS,), (1, -1, -1))
    return columns, signs


def _sideways(signs: Float[ndarray, " width"], *parts: slice) -> None:
    """Turn the sign of x in parts that hold all x, then all z."""
    for part in parts:
        signs[part].reshape(2, -1)[0] = -1


def _swap_joints(columns: ndarray, signs: ndarray, parts: Sequence[slice], turned: tuple[int, int, int]) -> None:
    joints = np.arange(JOINTS)
    for left, right in _SIDES:
        joints[left], joints[right] = np.arange(JOINTS)[right], np.arange(JOINTS)[left]
    for part in parts:
        columns[part] = columns[part].reshape(JOINTS, 3)[joints].ravel()
        signs[part] = np.tile(turned, JOINTS)


def _marked(width: int, parts: Sequence[slice]) -> Bool[ndarray, " width"]:
    marked = np.zeros(width, dtype=bool)
    for part in parts:
        marked[part] = True
    return marked
