"""The controller: one frame after the other, from what the user wants to where the joints are ([M22] 4.4)."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray
from torch import Tensor

from stylephase.features.layout import FPS, LOCAL, OUTPUT_SAMPLES, VELOCITIES, Layout
from stylephase.models.bundle import Bundle
from stylephase.motion.root import Root
from stylephase.runtime.axes import from_axes, root_axes
from stylephase.runtime.trajectory import Steering, Trajectory, advance, from_samples, samples_of, steer, to_world

# From x and p in metres, and codes, to y in metres.
Predict = Callable[
    [Float[ndarray, "rows inputs"], Float[ndarray, "rows gate_inputs"], Float[ndarray, "rows values"]], ndarray
]


@dataclass(frozen=True)
class ControllerSettings:
    """How network and user share the control ([M22] release 5.2, 5.3).

    `root_share` of the predicted root step is taken and `path_share` of the predicted path; `position_bias`,
    `direction_bias` and `reach` shape how the future bends (trajectory.py); `pose_share` weighs the predicted joint
    positions against the last pose carried on by its velocity, `phase_share` the predicted phases against the last
    ones plus their update. `zeroes_first` sets the first element of each scale and shift of a FiLM code to zero.
    """

    root_share: float = 1.0
    path_share: float = 0.25
    position_bias: float = 0.75
    direction_bias: float = 1.25
    reach: float = 1.0
    pose_share: float = 0.5
    phase_share: float = 0.5
    zeroes_first: bool = False


# The release takes 85 % of the root step, by which its feet slide, and 85 % of the predicted path: with so much of its
# own path a character may drift from walking into running, and heeds the user late. Its 50 points to come are numbered
# as if they were 60, so the last is not wholly the user's.
RELEASE = ControllerSettings(root_share=0.85, path_share=0.85, reach=50 / 60)
# The authors' demonstration also loses the first element of each FiLM vector, as its loop begins with the second.
DEMONSTRATION = replace(RELEASE, zeroes_first=True)
_FILM_VECTORS = 4


@dataclass(frozen=True)
class State:
    """Some characters between two frames.

    `path` runs through the root, `positions` (m) and `velocities` (m/s) of the joints are in the world, `rotations`
    turn each joint from the rest pose; `phases` is what the gate sees: phase vectors, the global phase (rad), or the
    last velocities of the end effectors; `contacts` are the network's last (right, left).
    """

    path: Trajectory
    positions: Float[ndarray, "characters joints 3"]
    rotations: Float[ndarray, "characters joints 3 3"]
    velocities: Float[ndarray, "characters joints 3"]
    phases: Float[ndarray, "characters gate_inputs"]
    contacts: Float[ndarray, "characters 2"]

    def repeated(self, times: int) -> "State":
        """Each character `times` over, one copy after the other."""
        path = Trajectory(*(np.repeat(part, times, axis=0) for part in (self.path.positions, self.path.directions)))
        arrays = ("positions", "rotations", "velocities", "phases", "contacts")
        return replace(self, path=path, **{name: np.repeat(getattr(self, name), times, axis=0) for name in arrays})


def input_of(state: State) -> Float[ndarray, "characters inputs"]:
    """The network's input x (metres) for the present state."""
    root, axes = state.path.root, state.rotations
    pose = np.stack([state.positions, axes[..., 2], axes[..., 1], state.velocities], axis=2)
    pose[:, :, 0, ::2] -= root.positions[:, None]
    pose = pose.reshape(len(pose), -1, 3) @ root_axes(root).transpose(0, 2, 1)
    return np.concatenate([samples_of(state.path), pose.reshape(len(pose), -1)], axis=1)


def start_state(
    x: Float[ndarray, "characters inputs"], p: Float[ndarray, "characters gate_inputs"], layout: Layout
) -> State:
    """Characters at the origin, facing +z, in the state of some frames of data."""
    origin = Root(np.zeros((len(x), 2)), np.zeros(len(x)))
    joints = x[:, layout.x_pose].reshape(len(x), layout.joints, 4, 3)
    position, forward, up, velocity = (joints[:, :, k] for k in range(4))
    path = from_samples(x[:, layout.x_trajectory], origin)
    return State(path, position, from_axes(forward, up), velocity, p.astype(float), np.zeros((len(x), 2)))


def _first_zeroed(codes: Float[Tensor, "characters values"]) -> Float[Tensor, "characters values"]:
    """FiLM codes whose scales and shifts have lost their first elements."""
    parts = codes.reshape(len(codes), _FILM_VECTORS, -1).clone()
    parts[:, :, 0] = 0
    return parts.reshape(codes.shape)


class Controller:
    """Drives any number of characters with one network, each with a style code of its own.

    `fast` takes the place of the bundle's network, such as the same as an ONNX graph (graph.py).
    """

    def __init__(
        self,
        bundle: Bundle,
        codes: Float[Tensor, "characters values"],
        settings: ControllerSettings,
        fast: Predict | None = None,
    ):
        codes = _first_zeroed(codes) if settings.zeroes_first else codes
        self.layout, self.settings, self.codes, self.fast = bundle.layout, settings, codes, fast
        self.network = bundle.network.synthesis.eval()
        n = bundle.normaliser
        self.scales = {"x": (n.x_mean, n.x_std), "p": (n.p_mean, n.p_std), "y": (n.y_mean, n.y_std)}

    def predict(self, x: Float[ndarray, "characters inputs"], p: Float[ndarray, "characters gate_inputs"]) -> ndarray:
        """The network's outputs y for inputs in metres."""
        if self.fast is not None:
            return self.fast(x, p, self.codes.numpy()).astype(float)
        scaled = [
            torch.from_numpy((v - self.scales[k][0]) / self.scales[k][1]).float() for k, v in (("x", x), ("p", p))
        ]
        with torch.inference_mode():
            y = self.network(*scaled, self.codes).double().numpy()
        return y * self.scales["y"][1] + self.scales["y"][0]

    # What turns infinite stays so, for the caller to judge.
    @np.errstate(over="ignore", invalid="ignore")
    def step(self, state: State, steering: Steering) -> State:
        """The next frame.

        The axes are made a rotation before they are fed back ([M22] release 5.3): fed back as they are, they drift
        from unit length and the released network walks faster and with shorter steps.
        """
        how = self.settings
        bias = {"position_bias": how.position_bias, "direction_bias": how.direction_bias, "reach": how.reach}
        state = replace(state, path=steer(state.path, steering, **bias))
        path, root = state.path, state.path.root
        x = input_of(state)
        p = x[:, self.layout.x_velocities] if self.layout.gate == VELOCITIES else state.phases
        y = self.predict(x, p)
        predicted = to_world(y[:, self.layout.y_trajectory].reshape(len(y), len(OUTPUT_SAMPLES), 4), root)
        joints = y[:, self.layout.y_pose].reshape(len(y), -1, 3) @ root_axes(root)
        position, forward, up, velocity = joints.reshape(len(y), -1, 4, 3).transpose(2, 0, 1, 3)
        position[..., ::2] += root.positions[:, None]
        carried = state.positions + velocity / FPS
        return replace(
            state,
            path=advance(path, predicted, how.root_share, how.path_share),
            positions=carried + how.pose_share * (position - carried),
            rotations=from_axes(forward, up),
            velocities=velocity,
            phases=next_phases(p, y, self.layout, how.phase_share),
            contacts=y[:, self.layout.y_contacts],
        )


def next_phases(
    p: Float[ndarray, "characters gate_inputs"], y: Float[ndarray, "characters outputs"], layout: Layout, share: float
) -> Float[ndarray, "characters gate_inputs"]:
    """The gate's next phases: the global one moves on by its update ([M18] 5.1); of local ones `share` is predicted.

    Velocities stay, since the next frame's are in its pose.
    """
    if layout.gate == VELOCITIES:
        return p
    moved = p + y[:, layout.y_phase_updates]
    return share * y[:, layout.y_phases] + (1 - share) * moved if layout.gate == LOCAL else moved % (2 * np.pi)
