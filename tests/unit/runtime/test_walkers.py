"""Every network of both papers is driven alike: by a player, and by a drive."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny
import torch

from stylephase.errors import InputError
from stylephase.models.bundle import Start
from stylephase.models.released import RELEASE
from stylephase.models.released_pfnn import PFNN_RELEASE
from stylephase.models.zoo import MODELS
from stylephase.runtime import calibration
from stylephase.runtime.controller import input_of
from stylephase.runtime.graph import FastNetwork, to_onnx
from stylephase.runtime.plans import Steady
from stylephase.runtime.player import Player
from stylephase.runtime.rollout import to_clip
from stylephase.runtime.speeds import SpeedCurve
from stylephase.runtime.viewer.frames import frame_layout, frame_numbers
from stylephase.runtime.walkers import NetworkWalker, drive, load_any, walker_of

STRAIGHT = SpeedCurve(np.arange(0.25, 12.0, 0.25), np.arange(0.25, 12.0, 0.25))


@pytest.fixture(autouse=True)
def hasty(monkeypatch) -> None:
    monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.1)


def played(weights, styles, **given) -> Player:
    """A player that has gone ahead for some frames with another mixture than at first."""
    player = Player(weights, styles, curves=dict.fromkeys(styles, STRAIGHT), **given)
    player.hold({"w"})
    player.mix((0.0, 0.0))
    for _ in range(20):
        shown = player.step()
    layout = frame_layout(len(player.walker.body.joints))
    assert len(frame_numbers(shown, 1.0)) == layout["speed"][1]
    return player


@pytest.mark.parametrize("model", MODELS)
def test_every_model_of_the_zoo_steps_under_a_player_and_in_a_drive(model):
    """Untrained, a walk need not stay finite; a player then begins anew."""
    bundle = tiny.of_model(model)
    player = played(bundle, tiny.STYLES[:3])
    assert np.isfinite(player.state.positions).all()
    walker = walker_of(bundle)
    codes = walker.code({tiny.STYLES[0]: 1.0, tiny.STYLES[1]: 3.0}).expand(2, -1)
    run = drive(walker, codes, walker.start(codes), 4, Steady(np.ones(2)))
    assert run.positions.shape == (4, 2, len(bundle.body.joints), 3)
    with pytest.raises(InputError, match="no style"):
        walker.code({"Nobody": 1.0})


def test_a_walk_begins_where_the_network_walked_to_of_a_mixture_where_its_main_style_did():
    """Without such a start, and with a speed, it begins after some seconds from the mean frame of the data."""
    bundle, made = tiny.bundle(), tiny.take().vectors
    starts = {
        style: Start(*(torch.from_numpy(part[row]).float() for part in (made.x, made.p)))
        for style, row in zip(tiny.STYLES[:2], (40, 90), strict=True)
    }
    walker, without = NetworkWalker(replace(bundle, starts=starts)), NetworkWalker(bundle)
    first, second, third = tiny.STYLES[:3]
    codes = torch.stack([walker.code(m) for m in ({second: 1.0}, {first: 3.0, second: 1.0}, {third: 1.0})])
    found, warm = walker.start(codes), without.start(codes)
    np.testing.assert_allclose(input_of(found)[:2], made.x[[90, 40]], atol=1e-4)
    np.testing.assert_allclose(input_of(found)[2], input_of(warm)[2], atol=1e-9)
    np.testing.assert_allclose(input_of(walker.start(codes, 1.0)), input_of(warm), atol=1e-9)
    player = Player(walker.bundle, (second, second, second), curves={second: STRAIGHT})
    np.testing.assert_allclose(input_of(player.state)[0], made.x[90], atol=1e-4)


@pytest.mark.parametrize("quantised", [False, True])
def test_a_fast_network_takes_the_place_of_a_network_in_a_player(quantised):
    bundle = tiny.of_model("lpn-film")
    plain = played(bundle, tiny.STYLES[:3])
    fast = played(bundle, tiny.STYLES[:3], fast=FastNetwork(to_onnx(bundle, quantised=quantised)))
    assert np.abs(plain.state.positions - fast.state.positions).max() < (0.05 if quantised else 1e-3)


def test_the_authors_network_is_played(mirror, cache, monkeypatch):
    if not {"local-phases-release.tar.xz", "100style-excerpts.tar.xz"} <= {path.name for path in mirror.glob("*")}:
        pytest.skip("needs the release, which is not in the mirror")
    monkeypatch.setenv("STYLEPHASE_MIRROR", str(mirror))
    player = played(load_any(RELEASE), ("Zombie", "Old", "Neutral"))
    assert np.isfinite(player.state.positions).all() and player.state.phases.shape == (1, 8)


class TestHolden:
    @pytest.fixture
    def released(self, mirror, cache, monkeypatch):
        if not {"pfnn-release.npz", "pfnn-locomotion.tar.xz"} <= {path.name for path in mirror.glob("*")}:
            pytest.skip("needs Holden's release and takes: pfnn-*.* are not in the mirror")
        monkeypatch.setenv("STYLEPHASE_MIRROR", str(mirror))
        return load_any(PFNN_RELEASE)

    def test_it_is_played_and_walks_at_the_speed_asked_for(self, released):
        player = played(released, ("walk", "jog", "stand"), speed=1.2)
        before = player.state.path.root.positions
        for _ in range(240):
            shown = player.step()
        assert np.linalg.norm(player.state.path.root.positions - before) / 4 == pytest.approx(1.2, rel=0.15)
        lengths = [np.linalg.norm(shown.positions[0, a] - shown.positions[0, b]) for a, b in player.walker.body.bones]
        skeleton, joints = player.walker.body.skeleton, player.walker.body.joints
        true = [np.linalg.norm(skeleton.offsets[joints[b]]) for _, b in player.walker.body.bones]
        np.testing.assert_allclose(lengths, true, atol=1e-9)

    def test_characters_of_several_gaits_walk_side_by_side_and_leave_as_clips(self, released):
        walker = walker_of(released)
        codes = walker.code({"walk": 1.0}).repeat(2, 1)
        codes[1] = walker.code({"jog": 1.0})
        run = drive(walker, codes, walker.start(codes), 180, Steady(np.array([1.2, 2.5])))
        ways = np.linalg.norm(run.root_positions[-1] - run.root_positions[0], axis=1)
        assert run.finite.all() and ways[1] > 1.4 * ways[0] > 1.5
        assert len(to_clip(run, 0, walker.body, "walk")) == 180

    @pytest.mark.parametrize(("mixture", "says"), [({"fly": 1.0}, "no gait 'fly'"), ({"walk": -1.0}, "not below zero")])
    def test_what_is_no_mixture_of_gaits_is_refused(self, released, mixture, says):
        with pytest.raises(InputError, match=says):
            walker_of(released).code(mixture)
