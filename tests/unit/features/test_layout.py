"""The vectors' layout: the released widths and places for 100STYLE, the same order for any skeleton."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stylephase.features.layout import (
    CLIP_FRAMES,
    INPUT_SAMPLES,
    OUTPUT_SAMPLES,
    Layout,
    feature_joints,
    layout_of,
)

WIDTHS = {"100style": (25, 348, 342), "bandai-namco": (21, 300, 294)}


@pytest.mark.parametrize("origin", WIDTHS)
def test_widths_follow_from_the_joints(skeletons, origin):
    """25 joints give the paper's numbers: 348 values in, 342 out, and a style clip of 240 frames with 300 values."""
    layout = layout_of(skeletons[origin])
    assert (layout.joints, layout.inputs, layout.outputs) == WIDTHS[origin]
    assert (layout.gate_inputs, layout.pose, CLIP_FRAMES) == (8, 12 * layout.joints, 240)


def test_slices_are_those_of_the_release(skeletons):
    layout = layout_of(skeletons["100style"])
    assert (layout.x_trajectory, layout.x_pose) == (slice(0, 48), slice(48, 348))
    assert (layout.y_trajectory, layout.y_pose) == (slice(0, 24), slice(24, 324))
    assert (layout.y_phases, layout.y_phase_updates) == (slice(324, 332), slice(332, 340))
    assert layout.y_contacts == slice(340, 342)
    assert INPUT_SAMPLES == (-60, -50, -40, -30, -20, -10, 0, 12, 24, 36, 48, 60)
    assert OUTPUT_SAMPLES == (0, 12, 24, 36, 48, 60)


def test_the_joints_are_those_of_the_release_in_its_order(skeletons):
    """Head and toe end sites are left out, the hands' are kept."""
    skeleton = skeletons["100style"]
    names = [skeleton.names[j] for j in feature_joints(skeleton)]
    assert names == [
        *("Hips", "Chest", "Chest2", "Chest3", "Chest4", "Neck", "Head"),
        *("RightCollar", "RightShoulder", "RightElbow", "RightWrist", "RightWristSite"),
        *("LeftCollar", "LeftShoulder", "LeftElbow", "LeftWrist", "LeftWristSite"),
        *("RightHip", "RightKnee", "RightAnkle", "RightToe", "LeftHip", "LeftKnee", "LeftAnkle", "LeftToe"),
    ]


@pytest.mark.parametrize("origin", ["100style", "bandai-namco", "cmu", "mixamo", "poser"])
def test_a_vector_has_no_gap_and_mirroring_it_twice_is_no_change(skeletons, origin):
    layout = layout_of(skeletons[origin])
    x = (layout.x_trajectory, layout.x_pose)
    y = (layout.y_trajectory, layout.y_pose, layout.y_phases, layout.y_phase_updates, layout.y_contacts)
    for parts, width in ((x, layout.inputs), (y, layout.outputs)):
        assert parts[0].start == 0 and parts[-1].stop == width
        assert all(before.stop == after.start for before, after in pairwise(parts))
    for (source, sign, _), width in (
        (layout.mirror_x, layout.inputs),
        (layout.mirror_y, layout.outputs),
        (layout.mirror_p, layout.gate_inputs),
    ):
        values = np.random.default_rng(0).normal(size=width)
        once = values[source] * sign
        assert np.abs(once - values).max() > 0.1
        np.testing.assert_array_equal(once[source] * sign, values)


def test_a_mirrored_value_stays_in_its_part_and_comes_from_the_partner(skeletons):
    """Numbers of elements as documented: joint 11 is RightWristSite, 16 LeftWristSite, 20 and 24 the toes."""
    layout = layout_of(skeletons["100style"])
    source, sign, _ = layout.mirror_x
    assert [source[48 + 12 * 16 + k] for k in range(12)] == [48 + 12 * 11 + k for k in range(12)]
    assert list(sign[48 + 12 * 16 :][:12]) == [-1, 1, 1] * 4
    assert list(source[:48]) == list(range(48)) and list(sign[:4]) == [-1, 1, -1, 1]
    source, sign, _ = layout.mirror_y
    assert source[24 + 12 * 24] == 24 + 12 * 20 and list(sign[24:27]) == [-1, 1, 1]
    # Left before right, hands before feet, sine before cosine: each pair moves as a whole, without a sign.
    assert list(source[324:332]) == [326, 327, 324, 325, 330, 331, 328, 329]
    assert list(source[332:342]) == [334, 335, 332, 333, 338, 339, 336, 337, 341, 340]
    assert set(sign[324:]) == {1.0}


@settings(max_examples=20)
@given(st.integers(1, 60), st.randoms(use_true_random=False))
def test_any_number_of_joints_and_any_pairs_give_an_involution(joints, random):
    order = list(range(joints))
    random.shuffle(order)
    partner = dict(zip(order[::2], order[1::2], strict=False))
    partner |= {b: a for a, b in partner.items()}
    layout = Layout(joints, tuple(partner.get(j, j) for j in range(joints)))
    for (source, sign, _), width in ((layout.mirror_x, 48 + 12 * joints), (layout.mirror_y, 42 + 12 * joints)):
        np.testing.assert_array_equal(source[source], np.arange(width))
        np.testing.assert_array_equal(sign * sign[source], np.ones(width))


@pytest.mark.parametrize(("gate", "width", "outputs"), [("local", 8, 342), ("velocities", 12, 326), ("global", 1, 327)])
def test_a_gate_decides_its_input_and_what_of_it_is_predicted(skeletons, gate, width, outputs):
    """Table 2 of [M22] follows from these widths."""
    layout = layout_of(skeletons["100style"]).with_gate(gate)
    assert (layout.inputs, layout.gate_inputs, layout.outputs) == (348, width, outputs)
    assert len(layout.y_shared) == 326 and layout.y_shared[-2:] == [outputs - 2, outputs - 1]
    for mirror, size in ((layout.mirror_p, width), (layout.mirror_y, outputs)):
        np.testing.assert_array_equal(mirror.source[mirror.source], np.arange(size))
        np.testing.assert_array_equal(mirror.sign * mirror.sign[mirror.source], np.ones(size))


def test_velocities_mirror_as_in_the_pose_and_the_global_phase_by_half_a_cycle(skeletons):
    layout = layout_of(skeletons["100style"]).with_gate("velocities")
    x = np.random.default_rng(0).normal(size=layout.inputs)
    mirrored = x[layout.mirror_x.source] * layout.mirror_x.sign
    p = x[layout.x_velocities]
    np.testing.assert_array_equal(mirrored[layout.x_velocities], p[layout.mirror_p.source] * layout.mirror_p.sign)
    assert layout.with_gate("global").mirror_p.shift == np.pi
    assert layout.mirror_x.shift == layout.mirror_y.shift == layout.mirror_p.shift == 0
