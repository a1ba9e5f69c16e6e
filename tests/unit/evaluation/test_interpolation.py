"""Blends with known answers: even ones, switches, ones that stay with the first style, and none at all."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny
import torch

from stylephase.evaluation.interpolation import (
    SHARES,
    Blend,
    barycentric,
    blend_of,
    blended_codes,
    blended_gains,
    blends_of,
    clearance,
    disagreement,
    mean_over_pairs,
    space_of_walks,
    starts,
    triangle,
)
from stylephase.evaluation.style import StyleSpace, statistics
from stylephase.runtime.rollout import Rollout

RNG = np.random.default_rng(2)
FIRST, LAST = RNG.normal(size=(2, 40))
STILL = np.zeros(len(SHARES))


def made(along: np.ndarray, aside: float = 0.0) -> Blend:
    """A blend that has come so far at each share, and lies so far off the line in between."""
    across = np.linalg.qr(np.stack([LAST - FIRST, RNG.normal(size=40)], axis=1))[0][:, 1]
    places = FIRST + along[:, None] * (LAST - FIRST)
    places[1:-1] += aside * np.linalg.norm(LAST - FIRST) * across
    return blend_of(places, STILL, SHARES)


def test_an_even_blend():
    blend = made(SHARES)
    np.testing.assert_allclose(blend.along, SHARES, atol=1e-12)
    assert blend.off_line == pytest.approx(0, abs=1e-12) and blend.largest_step == pytest.approx(0.1)
    assert blend.monotonicity == pytest.approx(1) and blend.halfway == pytest.approx(0.5)
    assert blend.apart == pytest.approx(np.linalg.norm(LAST - FIRST))
    np.testing.assert_allclose(blend.aside, 0, atol=1e-9)


def test_a_switch_half_way():
    blend = made((SHARES > 0.5).astype(float))
    assert blend.off_line == pytest.approx(np.sqrt(2 * (0.1**2 + 0.2**2 + 0.3**2 + 0.4**2) + 0.25) / np.sqrt(11))
    assert blend.largest_step == pytest.approx(1) and blend.halfway == pytest.approx(0.55)


def test_a_blend_that_keeps_the_first_style_to_the_end():
    blend = made((SHARES == 1).astype(float))
    assert blend.halfway == pytest.approx(0.95) and blend.off_line > 0.5 and blend.largest_step == pytest.approx(1)


def test_a_blend_that_turns_back_is_not_monotonic():
    there_and_back = np.array([0, 0.5, 1, 0.5, 0, 0.5, 1, 0.5, 0, 0.5, 1])
    assert made(there_and_back).monotonicity == pytest.approx(1 / 5)


def test_places_off_the_line_are_told_and_change_nothing_along_it():
    blend = made(SHARES, aside=0.3)
    np.testing.assert_allclose(blend.aside, [0, *[0.3] * 9, 0], atol=1e-9)
    np.testing.assert_allclose(blend.along, SHARES, atol=1e-9)


def test_places_by_chance_are_no_blend():
    """The null: walks that have nothing to do with the share."""
    blends = [blend_of(np.random.default_rng(n).normal(size=(11, 40)), STILL, SHARES) for n in range(30)]
    assert np.mean([blend.monotonicity for blend in blends]) < 0.6
    assert np.mean([blend.off_line for blend in blends]) > 0.2


def test_slide_beyond_that_of_the_pure_styles():
    skate = 0.1 + 0.2 * SHARES
    assert replace(made(SHARES), skate=skate).more_skate == pytest.approx(0)
    skate[1:-1] += 0.05
    assert replace(made(SHARES), skate=skate).more_skate == pytest.approx(0.05)


def test_the_way_back_is_the_same_way():
    blend = replace(made(SHARES**3), skate=SHARES)
    back = blend.reversed()
    np.testing.assert_allclose(back.shares, SHARES, atol=1e-12)
    assert back.halfway == pytest.approx(1 - blend.halfway) and back.off_line == pytest.approx(blend.off_line)
    np.testing.assert_allclose(back.reversed().along, blend.along)


def test_codes_and_gains_are_mixed_pair_after_pair():
    bundle = tiny.bundle()
    codes = blended_codes(bundle, [("Plain", "Old"), ("Old", "Very old")])
    assert codes.shape == (22, 32)
    torch.testing.assert_close(
        codes[[0, 10, 11, 21]], torch.stack([bundle.code(s) for s in ("Plain", "Old", "Old", "Very old")])
    )
    torch.testing.assert_close(codes[5], (bundle.code("Plain") + bundle.code("Old")) / 2)
    gains = blended_gains({"Plain": 1.0, "Old": 3.0}, [("Plain", "Old")])
    np.testing.assert_allclose(gains, np.linspace(1, 3, 11))


def test_characters_start_from_either_end():
    styles = {name: tiny.style_vectors(name) for name in ("Plain", "Sleepwalk")}
    pair = [("Plain", "Sleepwalk")]
    one, other = (starts(styles, pair, tiny.BODY, last=last).positions for last in (False, True))
    assert one.shape[0] == 11 and np.ptp(one, axis=0).max() == 0 and np.abs(one[0] - other[0]).max() > 0.1


@pytest.fixture(scope="module")
def mixed() -> tuple[Rollout, StyleSpace]:
    """The walker's joints mixed evenly between two of its styles, and a space of their plain statistics."""
    joints = list(tiny.BODY.joints)
    takes = [tiny.take(name).pose for name in ("Plain", "Sleepwalk")]
    first, last = (pose.positions[:, joints] for pose in takes)
    positions = np.stack([(1 - share) * first + share * last for share in SHARES], axis=1)
    rotations = np.tile(np.eye(3), (*positions.shape[:3], 1, 1))
    flat = np.zeros(positions.shape[:2])
    run = Rollout(positions, rotations, np.zeros((*flat.shape, 2)), flat, np.ones((*flat.shape, 2)), flat[..., None])
    width = tiny.BODY.layout.pose
    return run, StyleSpace(("a",), np.zeros((1, width)), np.ones(width), np.eye(width))


def test_a_mixed_walk_is_found_to_be_mixed(mixed):
    run, space = mixed
    blend = blends_of([run, run], tiny.BODY, space, settle=60)[0]
    assert blend is not None and blend.monotonicity > 0.99 and blend.off_line < 0.1 and blend.largest_step < 0.2
    assert (blend.skate > 0).all()


def test_a_character_that_broke_off_has_no_blend(mixed):
    run, space = mixed
    broken = run.positions.copy()
    broken[-1, 4] = np.inf
    assert blends_of([run, replace(run, positions=broken)], tiny.BODY, space, settle=60) == [None]


def test_walks_of_their_own_make_a_space_too(mixed):
    run, _ = mixed
    space = space_of_walks(run, [f"{share:.1f}" for share in SHARES], settle=0)
    assert space.styles[0] == "0.0" and len(space.centres) == 11
    blend = blends_of([run], tiny.BODY, space, settle=60)[0]
    assert blend is not None and blend.monotonicity > 0.95


def test_blends_that_depend_on_their_start_disagree():
    assert disagreement([made(SHARES)], [made(SHARES)]) == pytest.approx(0, abs=1e-12)
    assert disagreement([made(SHARES > 0.9)], [made(SHARES > 0.1)]) == pytest.approx(8 / 11)


def test_the_triangle_has_its_corners_and_sums_to_one():
    shares = triangle(4)
    assert len(shares) == 15 and np.allclose(shares.sum(axis=1), 1) and shares.min() == 0
    assert {(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)} <= {tuple(point) for point in shares.tolist()}


def test_barycentric_shares_are_found_again_from_any_height_above_the_plane():
    corners, shares = RNG.normal(size=(3, 40)), triangle(5)
    up = np.linalg.qr(np.concatenate([corners[:2] - corners[2], RNG.normal(size=(1, 40))]).T)[0][:, 2]
    np.testing.assert_allclose(barycentric(shares @ corners + 7 * up, corners), shares, atol=1e-9)


def test_the_interval_over_pairs_holds_what_differs_between_styles():
    """A value that hangs on one style only is less sure than one that is different noise in each pair."""
    names = [f"style{n}" for n in range(8)]
    pairs = [(a, b) for k, a in enumerate(names) for b in names[k + 1 :]]
    shared = np.array([float("style3" in pair) for pair in pairs])
    spread = np.random.default_rng(0).permutation(shared)
    mean, low, high = mean_over_pairs(shared, pairs)
    assert mean == pytest.approx(7 / 28) and low == 0 and high > 0.4
    _, low_other, high_other = mean_over_pairs(spread, pairs)
    assert high_other - low_other < high - low
    assert mean_over_pairs(np.ones(28), pairs) == (1, 1, 1)


def test_hands_off_the_trunk():
    """Arms that hang at the sides are a hand's breadth off and more; a hand put into the belly has none left."""
    joints = list(tiny.BODY.joints)
    positions = tiny.take("Plain").pose.positions[:60, joints][:, None]
    flat = np.zeros((60, 1, 2))
    run = Rollout(positions, np.tile(np.eye(3), (*positions.shape[:3], 1, 1)), flat, flat[..., 0], flat, flat)
    free = clearance(run, tiny.BODY)
    assert free.shape == (60, 1) and free.min() > 0.15
    hand = joints.index(tiny.BODY.skeleton.roles.hands[0])
    inside = positions.copy()
    inside[:, :, hand] = positions[:, :, 0] + [0, 0.1, 0.02]
    assert clearance(replace(run, positions=inside), tiny.BODY).max() < 0.05


def test_the_space_is_the_one_of_the_statistics(mixed):
    _, space = mixed
    poses = np.random.default_rng(0).normal(size=(100, tiny.BODY.layout.pose))
    np.testing.assert_allclose(space.place(poses), statistics(poses))
