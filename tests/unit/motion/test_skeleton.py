"""Roles and mirror pairs are found on any skeleton, by names and tree alone."""

from dataclasses import replace

import numpy as np
import pytest

from stylephase.errors import InputError
from stylephase.motion.skeleton import Skeleton, find_roles, roles_from_effectors

# Left side only; the right one is its mirror image.
ROLES = {
    "100style": {"hands": "LeftWristSite", "toes": "LeftToe", "toe_sensors": "LeftToeSite", "thighs": "LeftHip"},
    "bandai-namco": {"hands": "Hand_L", "toes": "Toes_L", "toe_sensors": "Toes_L", "thighs": "UpperLeg_L"},
    "cmu": {"hands": "LeftHand", "toes": "LeftToeBase", "toe_sensors": "LeftToeBase", "thighs": "LeftUpLeg"},
    "mixamo": {
        "hands": "mixamorig:LeftHand",
        "toes": "mixamorig:LeftToeBase",
        "toe_sensors": "mixamorig:LeftToeBase",
        "thighs": "mixamorig:LeftUpLeg",
    },
    "poser": {"hands": "lHandSite", "toes": "lFoot", "toe_sensors": "lFootSite", "thighs": "lThigh"},
}


def other_side(name: str) -> str:
    for left, right in (("Left", "Right"), ("_L", "_R"), ("l", "r")):
        if left in name and (left != "l" or name.startswith("l")):
            return name.replace(left, right, 1)
    return name


@pytest.mark.parametrize("origin", ROLES)
def test_roles_are_found(skeletons, origin):
    skeleton = skeletons[origin]
    for role, left in ROLES[origin].items():
        found = tuple(skeleton.names[j] for j in getattr(skeleton.roles, role))
        assert found == (left, other_side(left)), role
    assert skeleton.roles.hips == 0
    assert skeleton.roles.effectors == (*skeleton.roles.hands, *skeleton.roles.toes)


@pytest.mark.parametrize("origin", ROLES)
def test_mirror_pairs_swap_sides_and_leave_the_middle(skeletons, origin):
    """Mirroring twice is no change, and a pair hangs on a pair, so the mirrored tree is the same tree."""
    skeleton = skeletons[origin]
    partner = skeleton.mirrored
    np.testing.assert_array_equal(partner[partner], np.arange(len(skeleton)))
    assert all(skeleton.parents[partner[j]] == partner[p] for j, p in enumerate(skeleton.parents) if p >= 0)
    middle = {"Hips", "hip", "Spine", "Spine1", "LowerBack", "Chest", "chest", "Neck", "Head", "HeadSite"}
    for j, name in enumerate(skeleton.names):
        plain = name.removeprefix("mixamorig:").rstrip("234")
        assert (partner[j] == j) == (plain in middle), name


def test_the_mirrored_skeleton_has_mirrored_bones(skeletons):
    """Checked where joint frames stand upright: an offset and its partner's differ in the sign of x."""
    for origin in ("100style", "cmu", "mixamo", "poser"):
        skeleton = skeletons[origin]
        np.testing.assert_array_equal(skeleton.offsets[skeleton.mirrored], skeleton.offsets * [-1, 1, 1])


@pytest.mark.parametrize(
    ("lost", "role"), [("LeftWrist", "left hand"), ("RightToe", "right foot"), ("LeftToe", "left foot")]
)
def test_a_missing_role_is_named_with_the_joints_there_are(skeletons, lost, role):
    names = tuple(name.replace(lost, f"Part{lost[0]}").replace("LeftAnkle", "A").replace("RightAnkle", "B")
                  for name in skeletons["100style"].names)  # fmt: skip
    with pytest.raises(InputError, match=f"which joint is the {role}.*this skeleton has Hips, Chest"):
        find_roles(replace(skeletons["100style"], names=names))


def test_given_effectors_decide_thighs_and_sensors(skeletons):
    """For joints whose names say nothing, the four end effectors are enough."""
    known = skeletons["100style"]
    numbered = replace(known, names=tuple(f"joint{j}" for j in range(len(known))))
    with pytest.raises(InputError, match="left foot"):
        _ = numbered.roles
    assert roles_from_effectors(numbered, hands=known.roles.hands, toes=known.roles.toes) == known.roles


def test_an_unknown_joint_is_refused(skeletons):
    assert skeletons["100style"].index("Neck") == 5
    with pytest.raises(InputError, match="no joint 'Nack'"):
        skeletons["100style"].index("Nack")


@pytest.mark.parametrize(
    "parents",
    [(-1, 0, 3, 1), (-1, -1, 0, 1), (0, 0, 1, 2), (-1, 0, 1)],
    ids=["child before parent", "two roots", "no root", "too few"],
)
def test_a_tree_that_is_none_is_refused(parents):
    with pytest.raises(ValueError, match="expected"):
        Skeleton(("a", "b", "c", "d"), parents, np.zeros((4, 3)), (False,) * 4)


def test_chain_and_children_follow_the_tree(skeletons):
    skeleton = skeletons["100style"]
    chain = [skeleton.names[j] for j in skeleton.chain(skeleton.index("LeftToe"))]
    assert chain == ["Hips", "LeftHip", "LeftKnee", "LeftAnkle", "LeftToe"]
    children = [skeleton.names[j] for j in skeleton.children(skeleton.index("Chest4"))]
    assert children == ["Neck", "RightCollar", "LeftCollar"]
