"""The synthetic walker: feet that stand, legs that reach, phases and contacts that agree, styles that differ."""

from functools import cache

import numpy as np
import pytest

from stylephase.errors import InputError
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.synthetic import GAITS, STYLES, Truth, find_style, steady, walk
from stylephase.motion.synthetic.body import SHANK, SKELETON, THIGH, solve_leg

NAMES = [style.name for style in STYLES]
SITES = [SKELETON.index("RightToeSite"), SKELETON.index("LeftToeSite")]
WALKING = ("FW", "BW", "SW")
RUNNING = ("FR", "BR", "SR")


@cache
def take(name: str, gait: str) -> tuple[Clip, Truth]:
    return walk(find_style(name), gait, seconds=5.0)


@cache
def positions(name: str, gait: str) -> np.ndarray:
    return forward_kinematics(take(name, gait)[0]).positions


def speeds(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.diff(points, axis=0), axis=-1) * 60


def circular_distance(cycles: np.ndarray) -> np.ndarray:
    return np.abs((cycles + 0.5) % 1.0 - 0.5)


def steadily(name: str, **velocity: float) -> tuple[Clip, Truth]:
    return walk(find_style(name), "FW", plan=steady(8.0, **velocity))


def test_there_are_at_least_twelve_styles_and_their_names_are_distinct():
    assert len(set(NAMES)) == len(NAMES) >= 12


def test_unknown_style_and_gait_are_named_with_those_there_are():
    with pytest.raises(InputError, match="no synthetic style 'Plane'; there are Plain"):
        find_style("Plane")
    with pytest.raises(InputError, match="no gait 'XX'; there are BR"):
        walk(STYLES[0], "XX")


def test_the_body_has_the_layout_of_100style():
    """28 joints with the end sites, hips first, right before left, hands and toes found by their names."""
    assert len(SKELETON) == 28 and SKELETON.names[0] == "Hips"
    assert SKELETON.names.index("RightCollar") < SKELETON.names.index("LeftCollar")
    roles = SKELETON.roles
    assert [SKELETON.names[j] for j in roles.effectors] == ["LeftWristSite", "RightWristSite", "LeftToe", "RightToe"]
    assert [SKELETON.names[j] for j in roles.toe_sensors] == ["LeftToeSite", "RightToeSite"]


def test_leg_reaches_its_ankle_with_the_knee_in_front():
    rng = np.random.default_rng(1)
    hip = np.tile([0.0, 0.9, 0.0], (50, 1))
    ankle = np.stack([rng.uniform(-0.2, 0.2, 50), rng.uniform(0.2, 0.4, 50), rng.uniform(-0.3, 0.3, 50)], axis=1)
    forward = np.tile([0.0, 0.0, 1.0], (50, 1))
    thigh, shank = solve_leg(hip, ankle, forward)
    knee = hip + thigh @ [0.0, -THIGH, 0.0]
    assert np.allclose(knee + shank @ [0.0, -SHANK, 0.0], ankle, atol=1e-12)
    straight = hip + (ankle - hip) * THIGH / (THIGH + SHANK)
    assert (knee[:, 2] > straight[:, 2]).all()
    assert np.allclose(np.linalg.det(thigh), 1)


@pytest.mark.parametrize("gait", GAITS)
@pytest.mark.parametrize("name", NAMES)
def test_feet_stand_still_on_the_floor_while_in_contact_and_never_sink_into_it(name, gait):
    contacts, toes = take(name, gait)[1].contacts, positions(name, gait)[:, SITES]
    both = contacts[1:] & contacts[:-1]
    assert np.abs(toes[contacts][:, 1]).max() < 1e-3
    assert speeds(toes)[both].max() < 1e-3
    assert toes[..., 1].min() > -0.012


@pytest.mark.parametrize("gait", [gait for gait in GAITS if gait != "ID"])
@pytest.mark.parametrize("name", [style.name for style in STYLES if not style.drag])
def test_feet_clear_the_floor_in_the_swing(name, gait):
    """In the middle of every swing the foot is off the floor, or a contact could not be told from a swing."""
    truth, toes = take(name, gait)[1], positions(name, gait)[:, SITES]
    feet = truth.phase[:, [3, 2]]
    middle = (circular_distance(feet - 0.75) < 0.05) & ~truth.contacts
    assert toes[middle][:, 1].min() > 0.003


@pytest.mark.parametrize("gait", GAITS)
@pytest.mark.parametrize("name", NAMES)
def test_nothing_jumps(name, gait):
    """Accelerations stay near those of recorded people: at the feet 55 m/s2 walking and 100 running."""
    acceleration = np.linalg.norm(np.diff(positions(name, gait), 2, axis=0), axis=-1) * 3600
    assert np.isfinite(acceleration).all()
    assert acceleration.max() < (85 if gait in (*WALKING, "ID") else 135)
    assert acceleration[:, 0].max() < 20


@pytest.mark.parametrize("name", NAMES)
def test_knees_bend_forwards_and_are_never_straight(name):
    """A knee's local rotation is a bend about x alone, backwards, between 8 and 150 degrees."""
    for gait in ("FW", "BR", "SR"):
        for side in ("Left", "Right"):
            w, x, y, z = take(name, gait)[0].rotations[:, SKELETON.index(f"{side}Knee")].T
            bend = np.degrees(2 * np.arctan2(x, w))
            assert np.abs([y, z]).max() < 1e-6
            assert bend.min() > 8 and bend.max() < 150


@pytest.mark.parametrize("name", NAMES)
def test_walking_keeps_a_foot_on_the_floor_and_running_does_not(name):
    flying = {}
    for gait in ("FW", "FR"):
        truth = take(name, gait)[1]
        flying[gait] = (~truth.contacts[slice(*truth.cut)].any(axis=1)).mean()
    assert flying["FR"] > 0.1
    assert flying["FW"] < 0.1 or find_style(name).hop


@pytest.mark.parametrize("name", NAMES)
def test_speeds_and_directions_are_those_of_the_gait(name):
    """Forward, back and to both sides against the facing; running is faster than walking."""
    style, along = find_style(name), {}
    for gait in (*WALKING, *RUNNING):
        clip, truth = take(name, gait)
        cut = slice(*truth.cut)
        pose = forward_kinematics(clip)
        axes = pose.rotations[cut, 0]
        velocity = np.gradient(pose.positions[cut, 0], 1 / 60, axis=0)
        along[gait] = np.einsum("tji,tj->ti", axes, velocity)[:, [2, 0]]
    assert 0.7 * style.speed < along["FW"][:, 0].mean() < 1.3 * style.speed
    assert along["FR"][:, 0].mean() > 1.4 * along["FW"][:, 0].mean()
    assert along["BW"][:, 0].mean() < -0.4 * style.speed and along["BR"][:, 0].mean() < along["BW"][:, 0].mean()
    for gait in ("SW", "SR"):
        assert along[gait][:, 1].max() > 0.25 * style.speed and along[gait][:, 1].min() < -0.25 * style.speed


@pytest.mark.parametrize("name", [style.name for style in STYLES if not style.hop])
def test_feet_do_not_cross_going_sideways(name):
    """The left toe stays to the left of the right one by some centimetres, whichever foot leads."""
    for gait in ("SW", "SR"):
        clip, truth = take(name, gait)
        pose = forward_kinematics(clip)
        apart = pose.positions[:, SITES[1]] - pose.positions[:, SITES[0]]
        across = np.einsum("ti,ti->t", pose.rotations[:, 0, :, 0], apart)[slice(*truth.cut)]
        assert across.min() > 0.02


def test_transitions_hold_a_moment_of_standing_between_walk_and_run():
    """Both feet are down and the phases rest, although the style is one of the quicker ones."""
    _, truth = walk(find_style("Plain"), "TR1", seconds=12.0)
    resting = truth.contacts.all(axis=1) & (truth.frequency[:, 2:] == 0).all(axis=1)
    assert resting[slice(*truth.cut)].sum() > 20


def test_a_turn_of_ninety_degrees_faces_ninety_degrees_further():
    clip, _ = walk(find_style("Plain"), "FW", plan=steady(4.0, forward=1.2, turn=np.pi / 8))
    forward = forward_kinematics(clip).rotations[:, 0, :, 2]
    facing = np.unwrap(np.arctan2(forward[:, 0], forward[:, 2]))
    assert facing[200:].mean() - facing[:40].mean() == pytest.approx(np.pi / 2 * (220 - 20) / 240, abs=0.1)


@pytest.mark.parametrize("name", NAMES)
def test_idle_stands(name):
    """Feet, and the path, stay where they are; nobody is like a statue."""
    truth, points = take(name, "ID")[1], positions(name, "ID")
    hop = find_style(name).hop
    assert truth.contacts[:, 0].all() and (truth.contacts[:, 1].all() or hop)
    assert np.ptp(points[:, 0], axis=0).max() < 0.1
    assert np.ptp(points[:, 0], axis=0).max() > 0.0005
    assert (truth.frequency[:, 2:] == 0).all() and np.isnan(truth.global_phase).all()


@pytest.mark.parametrize("gait", ["FW", "BW", "SR", "FR"])
@pytest.mark.parametrize("name", NAMES)
def test_foot_phases_are_a_quarter_in_the_middle_of_each_contact(name, gait):
    truth = take(name, gait)[1]
    for column, foot in ((0, 3), (1, 2)):
        edges = np.diff(truth.contacts[:, column].astype(int), prepend=0, append=0)
        on, off = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        inside = (on > truth.cut[0]) & (off < truth.cut[1])
        middles = ((on + off - 1) // 2)[inside]
        assert len(middles) >= 1 or (find_style(name).hop and column == 1)
        # A contact's ends fall between frames, which for the quickest steps is a large part of the cycle.
        frame = truth.frequency[middles, foot] / 60
        assert (circular_distance(truth.phase[middles, foot] - 0.25) < 0.02 + 1.2 * frame).all()


@pytest.mark.parametrize("name", NAMES)
def test_phases_increase_at_the_stated_frequency(name):
    for gait in GAITS:
        truth = take(name, gait)[1]
        assert ((truth.phase >= 0) & (truth.phase < 1)).all()
        steps = np.diff(truth.phase, axis=0) % 1.0
        steps = np.where(steps > 0.5, steps - 1, steps) * 60
        assert np.allclose(steps, (truth.frequency[1:] + truth.frequency[:-1]) / 2, atol=0.05)
        assert truth.frequency[:, 2:].min() >= -1e-9


@pytest.mark.parametrize("name", [style.name for style in STYLES if style.symmetric])
def test_feet_of_a_symmetric_style_are_half_a_cycle_apart(name):
    for gait in (*WALKING, *RUNNING):
        truth = take(name, gait)[1]
        apart = (truth.phase[:, 2] - truth.phase[:, 3])[slice(*truth.cut)]
        assert circular_distance(apart - 0.5).max() < 0.04


def test_a_dragged_leg_carries_less_and_does_not_come_half_a_cycle_later():
    truth = steadily("DraggedLeft", forward=0.65)[1]
    right, left = truth.contacts.mean(axis=0)
    assert left < 0.7 * right
    right, left = (np.flatnonzero(np.diff(truth.contacts[:, k].astype(int)) == 1) for k in (0, 1))
    after = np.array([left[left > frame][0] - frame for frame in right[:-1]]) / np.diff(right)
    assert (after > 0.52).all()


@pytest.mark.parametrize("name", NAMES)
def test_hand_phases_follow_the_hands(name):
    """The sine of a hand's phase is high where the hand is in front of the hips."""
    clip, truth = take(name, "FW")
    cut, pose = slice(*truth.cut), forward_kinematics(clip)
    local = np.einsum("tji,tkj->tki", pose.rotations[:, 0], pose.positions - pose.positions[:, :1])[cut]
    for column, hand in enumerate(SKELETON.roles.hands):
        sine = np.sin(2 * np.pi * truth.phase[cut, column])
        assert np.corrcoef(sine, local[:, hand, 2])[0, 1] > 0.8


def test_arms_with_a_beat_of_their_own_keep_it_at_every_speed():
    """The strongest frequency of the hand's swing is the declared one, while that of the feet changes."""
    period, feet = find_style("OffbeatArms").arm_period, []
    for speed in (0.7, 1.3):
        clip, truth = steadily("OffbeatArms", forward=speed)
        pose = forward_kinematics(clip)
        swing = (pose.positions[:, SKELETON.roles.hands[0]] - pose.positions[:, 0])[:, 2]
        spectrum = np.abs(np.fft.rfft((swing - swing.mean()) * np.hanning(len(swing)), 4096))
        assert np.argmax(spectrum) * 60 / 4096 == pytest.approx(1 / period, abs=0.05)
        assert np.allclose(truth.frequency[:, :2], 1 / period)
        feet.append(np.median(truth.frequency[:, 2]))
    assert feet[1] > 1.15 * feet[0]


def test_the_hopper_never_sets_down_the_left_foot():
    for gait in GAITS:
        contacts, toes = take("HopOnRight", gait)[1].contacts, positions("HopOnRight", gait)[:, SITES]
        assert not contacts[:, 1].any() and toes[:, 1, 1].min() > 0.1
        assert contacts[:, 0].any() and (gait == "ID" or not contacts[:, 0].all())


def test_hands_in_pockets_hardly_move_against_the_hips():
    spread = {}
    for name in ("Plain", "PocketHands"):
        pose = forward_kinematics(steadily(name, forward=1.1)[0])
        local = np.einsum(
            "tji,tj->ti", pose.rotations[:, 0], pose.positions[:, SKELETON.roles.hands[0]] - pose.positions[:, 0]
        )
        spread[name] = local.std(axis=0).max()
    assert spread["PocketHands"] < 0.03 < 0.1 < spread["Plain"]


def test_looks_behind_come_at_random_and_differ_with_the_seed():
    """Only the stochastic style turns its head far, at times that the seed decides."""
    looks = []
    for name, seed in (("GlancingBack", 0), ("GlancingBack", 1), ("Plain", 0)):
        clip, _ = walk(find_style(name), "FW", seconds=12.0, seed=seed, plan=steady(12.0, forward=1.1))
        rotations = forward_kinematics(clip).rotations
        ahead = np.einsum("ti,ti->t", rotations[:, 0, :, 2], rotations[:, SKELETON.index("Head"), :, 2])
        looks.append(ahead < 0.5)
    assert looks[0].any() and looks[1].any() and not looks[2].any()
    assert (looks[0] != looks[1]).any()


@pytest.mark.parametrize(
    ("name", "low", "high"), [("SlowProcession", 115, 140), ("StoopedOver", 85, 105), ("QuickShuffle", 30, 42)]
)
def test_cycles_are_as_long_as_the_style_says(name, low, high):
    truth = steadily(name, forward=find_style(name).speed)[1]
    assert low <= 60 / np.median(truth.frequency[:, 3]) <= high


def test_global_phase_is_zero_at_right_and_pi_at_left_touchdowns():
    truth = take("Plain", "FW")[1]
    for column, value in ((0, 0.0), (1, 0.5)):
        on = np.flatnonzero(np.diff(truth.contacts[:, column].astype(int)) == 1) + 1
        shown = on[np.isfinite(truth.global_phase[on])]
        assert len(shown) >= 4
        assert (circular_distance(truth.global_phase[shown] / (2 * np.pi) - value) < 0.03).all()
    assert np.isfinite(truth.global_phase[slice(*truth.cut)]).mean() > 0.95
    assert np.isnan(take("HopOnRight", "FW")[1].global_phase).all()


@pytest.mark.parametrize("name", [style.name for style in STYLES if style.symmetric and style.arm_period is None])
def test_symmetric_styles_look_the_same_in_a_mirror(name):
    """Straight ahead, joints on the left have the mean and spread of their partners on the right, mirrored."""
    clip, truth = steadily(name, forward=find_style(name).speed)
    pose = forward_kinematics(clip)
    whole = round(60 / np.median(truth.frequency[:, 3]))
    frames = slice(0, len(clip) // whole * whole)
    local = (pose.positions - pose.positions[:, :1])[frames]
    swapped = local[:, SKELETON.mirrored] * [-1.0, 1.0, 1.0]
    limit = 0.03 if not find_style(name).stochastic else 0.08
    assert np.abs(local.mean(axis=0) - swapped.mean(axis=0)).max() < limit
    assert np.abs(local.std(axis=0) - swapped.std(axis=0)).max() < limit


def test_styles_differ_more_than_seeds_do():
    """Mean posture tells the styles apart: each is nearer to itself under another seed than to any other style."""

    def posture(name, seed):
        style = find_style(name)
        clip, _ = walk(style, "FW", seed=seed, plan=steady(3.0, forward=style.speed))
        pose = forward_kinematics(clip)
        local = pose.positions - pose.positions[:, :1] * [1, 0, 1]
        return np.concatenate([local.mean(axis=0).ravel(), local.std(axis=0).ravel()])

    first, second = (np.array([posture(name, seed) for name in NAMES]) for seed in (0, 1))
    distance = np.linalg.norm(first[:, None] - second[None], axis=-1)
    assert (distance.argmin(axis=1) == np.arange(len(NAMES))).all()
