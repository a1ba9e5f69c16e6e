"""The controller: states and inputs are inverse, what the network knows comes true, and nobody disturbs another."""

from dataclasses import fields, replace

import numpy as np
import pytest
import tiny_walker as tiny
import torch

from stylephase.features.store import for_gate
from stylephase.motion.root import root_of
from stylephase.runtime.controller import (
    DEMONSTRATION,
    RELEASE,
    Controller,
    ControllerSettings,
    State,
    input_of,
    start_state,
)
from stylephase.runtime.trajectory import Steering

ARRAYS = [field.name for field in fields(State) if field.name != "path"]


def steering(count: int, speed: float = 1.1, facing: float = 0.0) -> Steering:
    return Steering(np.tile([speed * np.sin(facing), speed * np.cos(facing)], (count, 1)), np.full(count, facing))


def assert_same(one: State, other: State, atol: float) -> None:
    for name in ARRAYS:
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), atol=atol, err_msg=name)
    np.testing.assert_allclose(one.path.positions, other.path.positions, atol=atol)
    np.testing.assert_allclose(one.path.directions, other.path.directions, atol=atol)


class Scaled(torch.nn.Module):
    """A network whose output is the same number everywhere."""

    def __init__(self, value: float):
        super().__init__()
        self.value = value

    def forward(self, x, p, code):
        return torch.full((len(x), tiny.BODY.layout.outputs), self.value)


class TestState:
    def test_the_input_of_a_state_of_the_data_is_the_datas(self):
        """At the origin and anywhere else: an input does not tell where in the world it was."""
        made = tiny.take().vectors
        state = tiny.start([0, 100, 300])
        np.testing.assert_allclose(input_of(state), made.x[[0, 100, 300]], atol=1e-9)
        np.testing.assert_array_equal(state.phases, made.p[[0, 100, 300]])
        np.testing.assert_allclose(
            input_of(tiny.turned(state, 2.0, np.array([3.0, -5.0]))), made.x[[0, 100, 300]], atol=1e-9
        )

    def test_its_rotations_are_those_of_the_joints_against_the_rest_pose(self):
        take, rows = tiny.take("DraggedLeft"), [10, 200]
        root = root_of(take.pose, take.clip.skeleton)
        level = np.swapaxes(root.matrices[rows], 1, 2)[:, None]
        expected = (level @ take.pose.rotations[rows] @ tiny.BODY.rest)[:, list(tiny.BODY.joints)]
        np.testing.assert_allclose(tiny.start(rows, "DraggedLeft").rotations, expected, atol=1e-9)

    def test_repeated_gives_each_character_several_times_in_a_row(self):
        state = tiny.start([0, 100])
        found = state.repeated(3)
        assert_same(found, tiny.start([0, 0, 0, 100, 100, 100]), atol=1e-12)


class TestStep:
    def test_a_network_that_knows_the_take_makes_it_again(self):
        """Positions come half from the network and half from carrying on, the root wholly; both agree in the data."""
        take, first = tiny.take("DraggedLeft"), 120
        bundle = tiny.knowing(take.vectors.y[first : first + 90])
        controller = Controller(bundle, tiny.codes(1), ControllerSettings())
        state, root = tiny.start([first], "DraggedLeft"), root_of(take.pose, take.clip.skeleton)
        state = tiny.turned(state, root.angles[first], root.positions[first])
        for frame in range(first + 1, first + 91):
            state = controller.step(state, steering(1))
            joints = list(tiny.BODY.joints)
            np.testing.assert_allclose(state.positions[0], take.pose.positions[frame, joints], atol=1e-6)
            np.testing.assert_allclose(
                state.rotations[0], (take.pose.rotations[frame] @ tiny.BODY.rest)[joints], atol=1e-6
            )
            np.testing.assert_allclose(state.path.root.positions[0], root.positions[frame], atol=1e-6)
            np.testing.assert_array_equal(state.contacts[0] > 0.5, take.contacts[frame])
        np.testing.assert_allclose(state.phases[0], take.vectors.p[first + 90], atol=1e-6)
        np.testing.assert_allclose(
            state.velocities[0], np.diff(take.pose.positions, axis=0)[first + 89, joints] * 60, atol=1e-5
        )

    @pytest.mark.parametrize(("settings", "share"), [(ControllerSettings(), 1.0), (RELEASE, 0.85)])
    def test_the_release_takes_85_percent_of_the_step(self, settings, share):
        y = tiny.take().vectors.y[[200]]
        state = Controller(tiny.knowing(y), tiny.codes(1), settings).step(tiny.start([200]), steering(1))
        np.testing.assert_allclose(state.path.root.positions[0], share * y[0, :2], atol=1e-9)
        assert np.linalg.norm(y[0, :2]) * 60 == pytest.approx(tiny.SPEED, abs=0.3)

    def test_positions_are_half_the_networks_and_half_carried_on(self):
        y = tiny.take().vectors.y[[200]].copy()
        joints = y[:, tiny.BODY.layout.y_pose].reshape(1, -1, 4, 3)
        joints[:, :, 0] += 0.1
        state = Controller(tiny.knowing(y), tiny.codes(1), ControllerSettings()).step(tiny.start([200]), steering(1))
        np.testing.assert_allclose(state.positions[0], joints[0, :, 0] - 0.05, atol=1e-6)

    def test_phases_are_half_the_networks_and_half_the_last_with_their_update(self):
        layout, y = tiny.BODY.layout, tiny.take().vectors.y[[200]].copy()
        y[:, layout.y_phases] = 2.0
        y[:, layout.y_phase_updates] = 0.1
        before = tiny.start([200])
        for share in (0.5, 0.2):
            how = ControllerSettings(phase_share=share)
            after = Controller(tiny.knowing(y), tiny.codes(1), how).step(before, steering(1))
            np.testing.assert_allclose(after.phases, share * 2 + (1 - share) * (before.phases + 0.1), atol=1e-9)

    @pytest.mark.parametrize("model", ["pfnn-film", "mann-film"])
    def test_other_gates_see_the_global_phase_or_the_velocities_of_hands_and_feet(self, model):
        """The phase moves on by its predicted update, past a whole turn; velocities are those of the last pose."""
        bundle = tiny.of_model(model)
        made, seen = for_gate(tiny.style_vectors(), bundle.layout), []
        state = start_state(made.x[[200]], made.p[[200]], bundle.layout)
        y = made.y[[200]].copy()
        y[:, bundle.layout.y_phase_updates] = 6.0

        def fast(x, p, code):
            seen.append(p)
            return y

        after = Controller(bundle, tiny.codes(1), ControllerSettings(), fast).step(state, steering(1))
        np.testing.assert_allclose(seen[0], made.p[[200]], atol=1e-6)
        moved = (made.p[[200]] + 6.0) % (2 * np.pi) if model == "pfnn-film" else made.p[[200]]
        np.testing.assert_allclose(after.phases, moved, atol=1e-6)

    def test_axes_that_are_none_come_out_as_rotations(self):
        """An untrained network's forward and up are neither of unit length nor at right angles."""
        controller, state = Controller(tiny.bundle(), tiny.codes(2), ControllerSettings()), tiny.start([0, 100])
        for _ in range(3):
            state = controller.step(state, steering(2))
        product = np.swapaxes(state.rotations, -1, -2) @ state.rotations
        np.testing.assert_allclose(product, np.broadcast_to(np.eye(3), product.shape), atol=1e-9)
        np.testing.assert_allclose(np.linalg.det(state.rotations), 1.0, atol=1e-9)

    def test_turning_the_world_turns_everything(self):
        controller, here = Controller(tiny.bundle(), tiny.codes(2), ControllerSettings()), tiny.start([0, 100])
        angle, shift = 2.2, np.array([10.0, -3.0])
        there = tiny.turned(here, angle, shift)
        for _ in range(10):
            here = controller.step(here, steering(2, 1.4, 0.6))
            there = controller.step(there, steering(2, 1.4, 0.6 + angle))
        assert_same(there, tiny.turned(here, angle, shift), atol=1e-4)

    def test_characters_do_not_influence_one_another(self):
        codes, rows, speeds = tiny.codes(3), [0, 100, 300], (0.5, 1.0, 2.0)
        wanted = [steering(1, speed, speed) for speed in speeds]
        together = Steering(*(np.concatenate([getattr(w, k) for w in wanted]) for k in ("velocity", "facing")))
        controller, state = Controller(tiny.bundle(), codes, ControllerSettings()), tiny.start(rows)
        for _ in range(20):
            state = controller.step(state, together)
        for k, row in enumerate(rows):
            controller, alone = Controller(tiny.bundle(), codes[k : k + 1], ControllerSettings()), tiny.start([row])
            for _ in range(20):
                alone = controller.step(alone, wanted[k])
            np.testing.assert_allclose(state.positions[k], alone.positions[0], atol=1e-5)
            np.testing.assert_allclose(state.path.positions[k], alone.path.positions[0], atol=1e-5)

    def test_the_code_matters(self):
        state = Controller(tiny.bundle(), tiny.codes(2), ControllerSettings()).step(tiny.start([0, 0]), steering(2))
        assert np.abs(state.positions[0] - state.positions[1]).max() > 1e-3

    def test_nothing_that_was_given_is_changed(self, frozen):
        state = tiny.start([50])
        path = replace(state.path, positions=frozen(state.path.positions), directions=frozen(state.path.directions))
        given = replace(state, path=path, **{name: frozen(getattr(state, name)) for name in ARRAYS})
        Controller(tiny.bundle(), tiny.codes(1), ControllerSettings()).step(given, steering(1))

    @pytest.mark.parametrize("value", [float("inf"), float("nan"), 1e30])
    def test_a_network_that_explodes_is_no_error(self, value):
        """Whoever asked judges what came out."""
        controller = Controller(tiny.bundle("Plain", network=Scaled(value)), tiny.codes(1), ControllerSettings())
        state = tiny.start([50])
        for _ in range(30):
            state = controller.step(state, steering(1))
        assert not (np.isfinite(state.positions).all() and np.abs(state.positions).max() < 1e20)

    def test_the_network_is_run_without_dropout(self):
        """It may come from training."""
        bundle = tiny.bundle()
        bundle.network.train()
        controller = Controller(bundle, tiny.codes(1), ControllerSettings())
        x, p = tiny.take().vectors.x[:1], tiny.take().vectors.p[:1]
        np.testing.assert_array_equal(controller.predict(x, p), controller.predict(x, p))
        assert not bundle.network.synthesis.training


def test_the_demonstration_loses_the_first_element_of_each_film_vector():
    bundle, codes = tiny.bundle(), tiny.codes(2)
    units = codes.shape[1] // 4
    lost = Controller(bundle, codes, DEMONSTRATION).codes
    changed = (lost != codes).any(dim=0).nonzero().flatten().tolist()
    assert changed == [0, units, 2 * units, 3 * units] and not lost[:, changed].any()
    assert Controller(bundle, codes, RELEASE).codes is codes
