"""What is told of a BVH file: walks are recognised under any names and units, and what is wrong has a reason."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tiny_adapters as adapters
import tiny_walker as tiny

from stylephase.evaluation.inspection import HEADS, Inspection, fitting_weights, inspect_clip, inspect_files, rows_of
from stylephase.models.bundle import save_bundle
from stylephase.motion.bvh import write_bvh
from stylephase.motion.clip import Clip
from stylephase.motion.rotations import from_matrix, to_matrix
from stylephase.motion.synthetic import find_style, steady, walk

# How others call the joints of the walker; sides are added by `named`.
FAMILIES = {
    "xsens": ("{side}Shoulder", "{side}Elbow", "{side}Wrist", "{side}Hip", "{side}Knee", "{side}Ankle", "{side}Toe"),
    "mixamo": tuple(
        f"mixamorig:{{side}}{bone}" for bone in ("Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
    ),
    "cmu": ("{s}humerus", "{s}radius", "{s}hand", "{s}femur", "{s}tibia", "{s}foot", "{s}toes"),
    "blender": ("upper_arm.{S}", "forearm.{S}", "hand.{S}", "thigh.{S}", "shin.{S}", "foot.{S}", "toe.{S}"),
    "unreal": ("upperarm_{s}", "lowerarm_{s}", "hand_{s}", "thigh_{s}", "calf_{s}", "foot_{s}", "ball_{s}"),
    "smpl": ("{S}_Shoulder", "{S}_Elbow", "{S}_Hand", "{S}_Hip", "{S}_Knee", "{S}_Ankle", "{S}_Foot"),
}


def named(clip: Clip, family: str) -> Clip:
    renamed = {}
    for side in ("Left", "Right"):
        forms = {"side": side, "s": side[0].lower(), "S": side[0]}
        for own, other in zip(FAMILIES["xsens"], FAMILIES[family], strict=True):
            renamed[own.format(**forms)] = other.format(**forms)
    names = tuple(renamed.get(name, name) for name in clip.skeleton.names)
    return replace(clip, skeleton=replace(clip.skeleton, names=names))


@pytest.fixture(scope="module")
def ahead() -> Clip:
    clip, truth = walk(find_style("Plain"), "FW", plan=steady(6.0, forward=1.1))
    return clip.frames(*truth.cut)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(("unit", "word"), [(1.0, "metre"), (0.01, "centimetre"), (0.0254, "inch")])
def test_a_walk_is_recognised_under_any_names_and_units(ahead, tmp_path, family, unit, word):
    write_bvh(tmp_path / "walk.bvh", named(ahead, family), metres_per_unit=unit)
    (take,) = inspect_files([(tmp_path / "walk.bvh", "mine")]).takes
    assert take.usable and take.unit == word and take.walk and take.effectors and take.clarity
    assert take.walk.gait == "walks ahead" and take.walk.speed == pytest.approx(1.1, rel=0.1)
    assert take.walk.alternation == 1.0 and take.walk.steps > 8
    assert min(take.clarity.values()) > 0.8 and take.remarks == ()
    foot = FAMILIES[family][-1].format(side="Left", s="l", S="L")
    assert take.effectors["LeftFoot"] == foot


@pytest.mark.parametrize(("forward", "left", "gait"), [(-0.8, 0.0, "backwards"), (0.0, 0.7, "sideways")])
def test_the_way_is_told_from_where_the_hips_face(forward, left, gait):
    clip, truth = walk(find_style("Plain"), "BW" if left == 0 else "SW", plan=steady(6.0, forward=forward, left=left))
    take = found_in(clip.frames(*truth.cut))
    assert take.walk and take.walk.gait == f"walks {gait}"
    assert np.sign(take.walk.towards) == np.sign(left) or left == 0


def found_in(clip: Clip) -> Inspection:
    return inspect_clip(clip, Path("take.bvh"), "mine", 0.01)


def test_standing_is_no_walk():
    clip, truth = walk(find_style("Plain"), "ID", seconds=4.0)
    take = found_in(clip.frames(*truth.cut))
    assert not take.usable and "nobody walks" in take.faults[0]


def test_a_body_that_glides_without_a_step_is_of_no_use(ahead):
    statue = replace(ahead, rotations=np.repeat(ahead.rotations[:1], len(ahead), axis=0))
    take = inspect_clip(statue, Path("statue.bvh"), "mine", 0.01)
    assert not take.usable and "no whole cycle" in take.faults[0]


def test_a_short_take_says_how_many_frames_it_needs(ahead):
    take = found_in(ahead.frames(0, 50))
    assert take.faults == ("lasts 50 frames at 60 a second; a take needs 70",)


def test_a_file_with_another_axis_up_says_which(ahead):
    """Turned as a program with z up exports it."""
    turned = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    rotations = ahead.rotations.copy()
    rotations[:, 0] = from_matrix(turned @ to_matrix(ahead.rotations[:, 0]))
    lying = replace(ahead, rotations=rotations, root_positions=ahead.root_positions @ turned.T)
    assert found_in(lying).faults == ("its up axis seems to be z; export it with y up",)


def test_stuck_arms_have_no_clear_phase_while_feet_have(ahead):
    """Arms that hang still have no phase; the null for the clarity of arms that swing."""
    rotations = ahead.rotations.copy()
    arms = [j for j, name in enumerate(ahead.skeleton.names) if name.endswith(("Collar", "Shoulder", "Elbow", "Wrist"))]
    rotations[:, arms] = from_matrix(to_matrix(rotations[:1, arms]))
    noise = 0.02 * np.random.default_rng(0).normal(size=rotations[:, arms].shape)
    rotations[:, arms] += noise
    rotations /= np.linalg.norm(rotations, axis=-1, keepdims=True)
    take = found_in(replace(ahead, rotations=rotations))
    assert take.usable and take.clarity
    assert min(take.clarity["LeftFoot"], take.clarity["RightFoot"]) > 0.8
    assert max(take.clarity["LeftHand"], take.clarity["RightHand"]) < 0.6


def test_sliding_feet_and_a_coarse_rate_are_remarked(ahead):
    moved = ahead.root_positions + np.linspace(0, 0.25 * len(ahead) / 60, len(ahead))[:, None] * [0, 0, 1.0]
    take = found_in(replace(ahead, root_positions=moved))
    assert take.usable and any("slide" in remark for remark in take.remarks)
    coarse = replace(ahead, fps=30.0, rotations=ahead.rotations[::2], root_positions=ahead.root_positions[::2])
    assert any("15 Hz" in remark for remark in found_in(coarse).remarks)


def test_time_in_which_nobody_gets_on_is_remarked(ahead):
    waiting = np.repeat([0, *range(len(ahead))], [90, *[1] * len(ahead)])
    take = found_in(replace(ahead, rotations=ahead.rotations[waiting], root_positions=ahead.root_positions[waiting]))
    assert take.usable and any("nobody gets on" in remark for remark in take.remarks)


def test_a_jump_is_remarked_with_the_frames_that_are_of_use(ahead):
    """A frame of zeros at the end, as some exporters leave it."""
    rotations, places = ahead.rotations.copy(), ahead.root_positions.copy()
    rotations[-1], places[-1] = [1.0, 0, 0, 0], 0.0
    take = found_in(replace(ahead, rotations=rotations, root_positions=places))
    assert take.usable and take.stretch == (0, len(ahead) - 1)
    assert f"the body jumps: cut the file to frames 0 to {len(ahead) - 2} of {len(ahead)}" in take.remarks
    assert found_in(ahead).stretch == (0, len(ahead))


def test_files_that_cannot_be_read_or_have_another_skeleton_are_listed_among_the_others(ahead, tmp_path):
    write_bvh(tmp_path / "a.bvh", ahead)
    (tmp_path / "b.bvh").write_text("HIERARCHY\nROOT Hips\n{\n")
    write_bvh(tmp_path / "c.bvh", named(ahead, "mixamo"))
    report = inspect_files([(tmp_path / f"{name}.bvh", "mine") for name in "abc"])
    assert [take.usable for take in report.takes] == [True, False, False]
    assert report.takes[1].faults[0].startswith("line 3:") and "joints differ" in report.takes[2].faults[0]
    rows = rows_of(report.takes)
    assert len(rows) == 3 and all(len(row) == len(HEADS) for row in rows)


def test_the_skeleton_that_most_files_have_counts_not_that_of_the_first(ahead, tmp_path):
    write_bvh(tmp_path / "a.bvh", named(ahead, "mixamo"))
    for name in "bc":
        write_bvh(tmp_path / f"{name}.bvh", ahead)
    report = inspect_files([(tmp_path / f"{name}.bvh", "mine") for name in "abc"])
    assert [take.usable for take in report.takes] == [False, True, True]
    assert "joints differ from those of b.bvh" in report.takes[0].faults[0]
    assert report.skeleton is not None and report.skeleton.names == ahead.skeleton.names


def test_weights_are_offered_to_the_skeleton_that_they_know_if_they_can_learn(tmp_path, ahead):
    save_bundle(tmp_path / "whole", tiny.bundle())
    save_bundle(tmp_path / "to-run", tiny.bundle(), to_run=True)
    save_bundle(tmp_path / "no-style-network", tiny.of_model("lpn-onehot"))
    save_bundle(tmp_path / "adapters", adapters.base(), to_run=True)
    found = fitting_weights(ahead.skeleton, tmp_path)
    assert {path.name: command for path, command in found.items()} == {"adapters": "fewshot", "whole": "finetune"}
    assert fitting_weights(named(ahead, "mixamo").skeleton, tmp_path) == {}
