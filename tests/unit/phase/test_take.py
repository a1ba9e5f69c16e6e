"""Phases of whole takes: against the walker's truth, in a mirror, on real motion, and on takes with little in them."""

import tarfile
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stylephase.data.registry import MIDDLE_CONTACT, dataset
from stylephase.motion.bvh import read_bvh
from stylephase.motion.clip import Clip, resample
from stylephase.motion.synthetic import STYLES, Truth, find_style, steady, walk
from stylephase.phase.circular import distance
from stylephase.phase.global_phase import touchdowns
from stylephase.phase.local import variant
from stylephase.phase.take import TakePhases, take_phases

WALKER = dataset("synthetic")
RULE = WALKER.contact
NAMES = [style.name for style in STYLES]
STEADY = slice(60, -60)


@cache
def walked(name: str) -> tuple[Clip, Truth]:
    """Eight seconds straight ahead at the style's own speed."""
    style = find_style(name)
    return walk(style, "FW", plan=steady(8.0, forward=style.speed))


@cache
def found(name: str, variant_name: str = "adaptive") -> TakePhases:
    return take_phases(walked(name)[0], RULE, variant(variant_name), contact_free=WALKER.contact_free_feet(name, "FW"))


def errors(name: str, variant_name: str = "adaptive") -> np.ndarray:
    """Circular errors (cycles) of the four effectors."""
    return distance(found(name, variant_name).local.phase, walked(name)[1].phase)[STEADY]


@pytest.mark.parametrize("name", NAMES)
def test_feet_have_the_true_phase(name):
    """Cycles of 36 to 130 frames; the raised foot of the hopper is read from its movement."""
    assert np.median(errors(name)[:, 2:], axis=0).max() <= 0.01
    assert np.percentile(errors(name)[:, 2:], 90) <= 0.02


@pytest.mark.parametrize("name", NAMES)
def test_hands_have_the_true_phase(name):
    """The sleepwalker's arms hardly swing: what little they do is led by the trunk."""
    assert np.median(errors(name)[:, :2], axis=0).max() <= (0.025 if name == "Sleepwalk" else 0.02)


@pytest.mark.parametrize("name", ["Plain", "StoopedOver", "OffbeatArms", "QuickShuffle"])
def test_phases_follow_a_change_of_speed(name):
    """A take with speeds from 85 to 120 % and curves to both sides."""
    clip, truth = walk(find_style(name), "FW", seconds=12.0)
    own = take_phases(clip, RULE, variant("adaptive"))
    off = distance(own.local.phase, truth.phase)[slice(truth.cut[0] + 30, truth.cut[1] - 30)]
    assert np.median(off, axis=0).max() <= 0.02 and np.percentile(off, 90) <= 0.05


def test_contacts_are_the_true_ones():
    """F1 over all styles, frame by frame: the toes rest exactly, and the rule of the walker is strict."""
    true = np.concatenate([walked(name)[1].contacts for name in NAMES])
    own = np.concatenate([found(name).contacts for name in NAMES])
    assert 2 * (own & true).sum() / (own.sum() + true.sum()) >= 0.98


def test_arms_with_a_period_of_their_own_keep_it():
    frequency = np.median(found("OffbeatArms").local.frequency[STEADY], axis=0)
    arms, feet = 1 / find_style("OffbeatArms").arm_period, walked("OffbeatArms")[1].frequency[:, 2:].mean()
    assert np.allclose(frequency[:2], arms, rtol=0.03)
    assert np.allclose(frequency[2:], feet, rtol=0.1) and arms > 1.3 * feet


def test_hands_that_hardly_move_have_a_small_magnitude():
    quiet, plain = (np.median(found(name).local.magnitude, axis=0) for name in ("PocketHands", "Plain"))
    assert (quiet[:2] < 0.15 * plain[:2]).all() and (quiet[2:] > 0.7 * plain[2:]).all()


def test_a_foot_that_never_touches_the_floor_is_read_from_its_movement():
    """Also where nobody has marked it: a hybrid takes contacts only from feet that have some."""
    clip, _ = walked("HopOnRight")
    by_itself = take_phases(clip, RULE, variant("adaptive"))
    assert by_itself.sourcing.by_contact == (False, True) == found("HopOnRight").sourcing.by_contact
    forced = take_phases(clip, RULE, variant("adaptive"), sources="contact-based")
    assert forced.sourcing.by_contact == (True, True) and (forced.local.magnitude[:, 2] == 0).all()
    assert np.median(by_itself.local.magnitude[:, 2]) > 0.3


def test_without_contacts_feet_have_the_same_cycle():
    """Read from movement, a foot's phase is shifted against that from contacts, by the same amount throughout."""
    free = take_phases(walked("Plain")[0], RULE, variant("adaptive"), sources="contact-free")
    shift = 2 * np.pi * (free.local.phase - found("Plain").local.phase)[STEADY, 2:]
    assert free.sourcing.by_contact == (False, False)
    assert (np.abs(np.exp(1j * shift).mean(axis=0)) > 0.98).all()


def test_a_window_of_one_cycle_mends_the_phase_of_slow_styles():
    """Plateaus of a second and more look flat in a window of one second."""
    for name in ("StoopedOver", "SlowProcession"):
        share = {how: (errors(name, how)[:, 2:] > 0.15).mean() for how in ("release", "adaptive")}
        assert share["release"] > 0.2 and share["adaptive"] == 0


def test_magnitudes_do_not_depend_on_the_length_of_the_cycle_but_through_speed():
    """The same walk at half the speed has half the magnitude."""
    clip, _ = walked("Plain")
    slow = take_phases(replace(clip, fps=30.0), replace(RULE, speed=RULE.speed / 2), variant("adaptive"))
    halves = np.median(slow.local.magnitude, axis=0) / np.median(found("Plain").local.magnitude, axis=0)
    assert np.allclose(halves, 0.5, atol=0.02)


def test_the_global_phase_is_the_true_one():
    true, own = walked("Plain")[1].global_phase, found("Plain").global_phase
    known = np.isfinite(true)
    assert np.median(distance(own[known], true[known], 2 * np.pi)) / (2 * np.pi) < 0.01


def test_a_mirrored_take_swaps_left_and_right():
    """Positions x to -x and joints swapped give the same numbers with left and right exchanged."""
    clip, _ = walked("DraggedLeft")
    partner = clip.skeleton.mirrored
    rotations = clip.rotations[:, partner] * [1.0, 1.0, -1.0, -1.0]
    skeleton = replace(clip.skeleton, offsets=clip.skeleton.offsets[partner] * [-1.0, 1.0, 1.0])
    mirrored = replace(clip, skeleton=skeleton, rotations=rotations, root_positions=clip.root_positions * [-1, 1, 1])
    own, other = found("DraggedLeft"), take_phases(mirrored, RULE, variant("adaptive"))
    assert np.array_equal(other.contacts, own.contacts[:, ::-1])
    assert np.allclose(other.local.magnitude, own.local.magnitude[:, [1, 0, 3, 2]], atol=1e-6)
    assert distance(other.local.phase, own.local.phase[:, [1, 0, 3, 2]]).max() < 1e-6
    assert np.allclose(other.sourcing.directions, own.sourcing.directions[[1, 0, 3, 2]] * [-1, 1, 1], atol=1e-9)


@pytest.mark.parametrize("fps", [24.0, 30.0, 120.0, 240.0])
def test_the_frame_rate_hardly_matters(fps):
    """The same motion at another rate has the same phases at the same times."""
    clip, truth = walked("Plain")
    other = take_phases(resample(clip, fps), RULE, variant("adaptive"))
    assert other.fps == fps
    at = np.round(np.arange(len(other.contacts)) * 60 / fps).astype(int)
    inner = (at > 60) & (at < len(truth.phase) - 60)
    # Frames of 24 a second lie up to half a frame of 60 from the one they are compared with.
    assert np.median(distance(other.local.phase[inner], truth.phase[at[inner]]), axis=0).max() < 0.03
    assert np.median(other.local.magnitude) == pytest.approx(np.median(found("Plain").local.magnitude), rel=0.15)


def test_arrays_have_the_names_and_shapes_of_the_contract():
    shapes = {name: values.shape for name, values in found("Plain").arrays().items()}
    frames = len(walked("Plain")[0])
    assert shapes == {
        "vectors": (frames, 8),
        "phase": (frames, 4),
        "magnitude": (frames, 4),
        "frequency": (frames, 4),
        "contacts": (frames, 2),
        "global_phase": (frames,),
        "fps": (),
    }


def still(clip: Clip) -> Clip:
    return replace(
        clip,
        rotations=np.repeat(clip.rotations[:1], len(clip), axis=0),
        root_positions=np.repeat(clip.root_positions[:1], len(clip), axis=0),
    )


def one_leg(clip: Clip) -> Clip:
    """Stands, and once a second lifts the right foot for half a second."""
    lift = np.maximum(np.sin(2 * np.pi * np.arange(len(clip)) / clip.fps), 0)
    rotations = still(clip).rotations.copy()
    knee = Rotation.from_quat(rotations[:, clip.skeleton.index("RightKnee")], scalar_first=True)
    bent = Rotation.from_rotvec(lift[:, None] * [0.8, 0.0, 0.0]) * knee
    rotations[:, clip.skeleton.index("RightKnee")] = bent.as_quat(scalar_first=True)
    return replace(still(clip), rotations=rotations)


@pytest.mark.parametrize("variant_name", ["release", "paper", "adaptive"])
@pytest.mark.parametrize("fps", [24.0, 240.0])
@pytest.mark.parametrize("frames", [1, 2, 3, 5, 20])
def test_clips_shorter_than_a_window_have_finite_phases(frames, fps, variant_name):
    short = replace(walked("Plain")[0].frames(0, frames), fps=fps)
    assert_defined(take_phases(short, RULE, variant(variant_name)), frames)


@pytest.mark.parametrize("fps", [24.0, 60.0, 240.0])
def test_a_clip_without_movement_has_contacts_and_no_magnitude(fps):
    phases = take_phases(replace(still(walked("Plain")[0]), fps=fps), RULE, variant("release"))
    assert_defined(phases, 480)
    assert (phases.local.magnitude < 1e-9).all() and (phases.global_phase == 0).all()


def test_only_the_foot_that_moves_has_a_phase():
    stand, _ = walk(find_style("Plain"), "ID", seconds=8.0)
    phases = take_phases(one_leg(stand), RULE, variant("adaptive"))
    assert_defined(phases, len(stand))
    assert phases.contacts[:, 1].all() and 0.4 < phases.contacts[:, 0].mean() < 0.7
    assert (phases.local.magnitude[:, :3] < 1e-6).all() and np.median(phases.local.magnitude[:, 3]) > 0.5
    assert np.median(phases.local.frequency[:, 3]) == pytest.approx(1, abs=0.1)
    assert np.ptp(np.diff(np.unwrap(phases.global_phase[STEADY]))) < 0.02


def assert_defined(phases: TakePhases, frames: int) -> None:
    for name, values in phases.arrays().items():
        assert np.isfinite(values).all(), name
        assert name == "fps" or len(values) == frames
    assert ((phases.local.phase >= 0) & (phases.local.phase < 1)).all()
    assert (phases.local.magnitude >= 0).all()


@pytest.fixture(scope="module")
def real_walk(mirror, tmp_path_factory) -> TakePhases:
    """A recorded walk of Bandai-Namco, 30 frames a second brought to 60."""
    folder = tmp_path_factory.mktemp("real")
    wanted = "dataset-2_walk_normal_001.bvh"
    with tarfile.open(mirror / "bandai-namco-locomotion.tar.xz") as archive:
        for member in archive:
            if member.name.endswith(wanted):
                archive.extract(member, folder, filter="data")
                break
    clip = resample(read_bvh(next(folder.rglob(wanted)), metres_per_unit=0.01), 60.0)
    return take_phases(clip, dataset("bandai-namco").contact, variant("adaptive"))


def test_feet_of_a_recorded_walk_are_half_a_cycle_apart(real_walk):
    phase = real_walk.local.phase
    apart = distance(phase[:, 2] - 0.5, phase[:, 3])
    assert np.median(apart) <= 0.05 and np.percentile(apart, 90) <= 0.10


def test_steps_of_a_recorded_walk_alternate(real_walk):
    right, left = (touchdowns(real_walk.contacts[:, foot], 60.0) for foot in (0, 1))
    feet = np.repeat([0, 1], [len(right), len(left)])[np.argsort(np.concatenate([right, left]))]
    assert len(feet) >= 4 and np.mean(feet[1:] != feet[:-1]) >= 0.98


def test_phases_of_a_recorded_walk_run_forwards(real_walk):
    steps = np.diff(real_walk.local.phase, axis=0)
    assert (((steps + 0.5) % 1.0 - 0.5) < 0).mean(axis=0).max() <= 0.02


def test_the_middle_contact_rule_lies_between_those_of_the_data_sets():
    rules = [dataset(name).contact for name in ("100style", "bandai-namco")]
    assert min(r.speed for r in rules) <= MIDDLE_CONTACT.speed <= max(r.speed for r in rules)
    assert min(r.height for r in rules) <= MIDDLE_CONTACT.height <= max(r.height for r in rules)


def sloping(clip: Clip, rise: float) -> Clip:
    """The same motion, carried up by a share of the way walked forward."""
    path = clip.root_positions.copy()
    path[:, 1] += rise * (path[:, 2] - path[0, 2])
    return replace(clip, root_positions=path)


@pytest.mark.parametrize("rise", [0.01, 0.02, 0.1])
def test_on_a_slope_feet_keep_their_cycle(rise):
    """A level floor runs away from them: contacts of a few steps are no source, and the movement is."""
    clip, truth = walked("Plain")
    found_there = take_phases(sloping(clip, rise), MIDDLE_CONTACT, variant("adaptive"))
    assert found_there.sourcing.by_contact == (False, False)
    assert np.allclose(found_there.local.frequency[STEADY, 2:], truth.frequency[STEADY, 2:], rtol=0.1)
    assert (np.mod(np.diff(found_there.local.phase, axis=0), 1.0) < 0.5).all()


def test_a_stop_in_the_middle_holds_the_phase():
    """Walk, stand, walk: contacts stay the source, and in the stand nothing flickers."""
    clip, _ = walked("Plain")
    parts = [np.arange(240), np.full(300, 239), np.arange(240, 480)]
    frames = np.concatenate(parts)
    stopped = replace(clip, rotations=clip.rotations[frames], root_positions=clip.root_positions[frames])
    take = take_phases(stopped, RULE, variant("adaptive"))
    assert take.sourcing.by_contact == (True, True)
    standing = take.local.phase[330:450]
    assert (np.abs(standing - standing[0]) < 0.05).all() and (take.local.magnitude[330:450] < 0.05).all()
