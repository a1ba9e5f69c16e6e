"""Post-processing gives constant bones and feet that stay, and leaves good motion as it is."""

from types import SimpleNamespace

import numpy as np
import pytest

from stylephase.errors import InputError
from stylephase.evaluation.motion import foot_skate
from stylephase.features.body import Body
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.contacts import ContactRule, foot_contacts
from stylephase.motion.rest import rest_axes
from stylephase.motion.skeleton import Skeleton
from stylephase.runtime.finish import finish, finish_frame
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import Rollout, to_clip

CONTACT = ContactRule(speed=0.3, height=0.03)


def _rollout(clip: Clip, copies: int = 1) -> SimpleNamespace:
    """A clip as if a network had given it, with its own contacts."""
    body, pose = Body(clip.skeleton, rest_axes(clip.skeleton, [clip])), forward_kinematics(clip)
    joints, sensors = list(body.joints), list(clip.skeleton.roles.toe_sensors[::-1])
    positions, rotations = pose.positions[:, joints], pose.rotations[:, joints] @ body.rest[joints]
    contacts = foot_contacts(pose.positions[:, sensors], clip.fps, CONTACT).astype(float)
    root, still = positions[:, 0][:, [0, 2]], np.zeros((len(clip), copies))
    parts = [np.repeat(part[:, None], copies, axis=1) for part in (positions, rotations, root, contacts)]
    run = Rollout(parts[0], parts[1], parts[2], still, parts[3], np.zeros((len(clip), copies, 8)))
    return SimpleNamespace(run=run, body=body, rig=rig_of(body), clip=clip)


@pytest.fixture(scope="module", params=["limping", "real_take"])
def given(request) -> SimpleNamespace:
    """A synthetic take with upright joint frames, or a real one whose frames lie along the bones."""
    return _rollout(request.getfixturevalue(request.param))


def _slid(run: Rollout, speed: float) -> Rollout:
    """The same with a body that slides sideways over the ground, bones that breathe, and feet with it."""
    frames = np.arange(len(run))
    positions = run.positions * (1 + 0.01 * np.sin(frames / 7))[:, None, None, None]
    positions[..., 0] += (speed * frames / 60)[:, None, None]
    return Rollout(positions, run.rotations, run.root_positions, run.root_angles, run.contacts, run.phases)


def _lengths(positions: np.ndarray, body: Body) -> np.ndarray:
    parents, children = (list(column) for column in zip(*body.bones, strict=True))
    return np.linalg.norm(positions[..., parents, :] - positions[..., children, :], axis=-1)


def test_the_rig_stands_on_two_long_bones_a_limb(skeletons):
    for name in ("100style", "bandai-namco", "cmu", "mixamo"):
        skeleton = skeletons[name]
        body = Body(skeleton, np.tile(np.eye(3), (len(skeleton), 1, 1)))
        rig, names = rig_of(body), [skeleton.names[joint] for joint in body.joints]
        limbs = [[names[j] for j in (limb.start, limb.middle, limb.end)] for limb in (*rig.legs, *rig.arms)]
        assert limbs == LIMBS[name]


LIMBS = {
    "100style": [[f"{s}Hip", f"{s}Knee", f"{s}Ankle"] for s in ("Right", "Left")]
    + [[f"{s}Shoulder", f"{s}Elbow", f"{s}Wrist"] for s in ("Right", "Left")],
    "bandai-namco": [[f"UpperLeg_{s}", f"LowerLeg_{s}", f"Foot_{s}"] for s in "RL"]
    + [[f"UpperArm_{s}", f"LowerArm_{s}", f"Hand_{s}"] for s in "RL"],
    "cmu": [[f"{s}UpLeg", f"{s}Leg", f"{s}Foot"] for s in ("Right", "Left")]
    + [[f"{s}Arm", f"{s}ForeArm", f"{s}Hand"] for s in ("Right", "Left")],
    "mixamo": [[f"mixamorig:{s}UpLeg", f"mixamorig:{s}Leg", f"mixamorig:{s}Foot"] for s in ("Right", "Left")]
    + [[f"mixamorig:{s}Arm", f"mixamorig:{s}ForeArm", f"mixamorig:{s}Hand"] for s in ("Right", "Left")],
}


def test_a_limb_of_one_bone_is_refused():
    names = ("Hips", "LeftToe", "RightToe", "LeftHand", "RightHand")
    offsets = np.array([[0, 0, 0], [0.1, -1, 0], [-0.1, -1, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]])
    skeleton = Skeleton(names, (-1, 0, 0, 0, 0), offsets, (False,) * 5)
    with pytest.raises(InputError, match="RightToe has no two bones"):
        rig_of(Body(skeleton, np.tile(np.eye(3), (5, 1, 1))))


def test_forward_kinematics_of_the_rig_are_those_of_the_clip(given):
    placed = given.rig.place(given.run.positions[:, :, 0], given.run.rotations)
    np.testing.assert_allclose(placed, given.run.positions, atol=1e-9)


def test_good_motion_without_contacts_stays_as_it_is(given):
    """Up to the easing of stretched limbs: 1 % of a leg's length at the most, on a stretched limb alone."""
    free = Rollout(**(vars(given.run) | {"contacts": 0 * given.run.contacts}))
    moved = np.linalg.norm(finish(free, given.rig).positions - free.positions, axis=-1)
    limbs = [j for limb in (*given.rig.legs, *given.rig.arms) for j in (limb.middle, limb.end, limb.tip)]
    others = [j for j in range(moved.shape[-1]) if j not in limbs]
    assert moved[..., others].max() < 1e-9 and moved.max() < 0.05
    assert np.median(moved.max(axis=(1, 2))) < 0.015


def test_bones_keep_the_lengths_of_the_skeleton(given):
    slid = _slid(given.run, 0.2)
    assert np.ptp(_lengths(slid.positions, given.body), axis=0).max() > 0.005
    found = finish(slid, given.rig)
    assert np.ptp(_lengths(found.positions, given.body), axis=0).max() < 1e-9
    pose = forward_kinematics(to_clip(found, 0, given.body, "made"))
    np.testing.assert_allclose(pose.positions[:, list(given.body.joints)], found.positions[:, 0], atol=1e-6)


def test_feet_in_contact_do_not_skate(given):
    slid, toes = _slid(given.run, 0.2), [leg.tip for leg in given.rig.legs]
    found = finish(slid, given.rig)
    before, after = (foot_skate(r.positions[:, 0, toes], given.run.contacts[:, 0] > 0.5) for r in (slid, found))
    assert before > 0.15 and after < 0.03


def test_hands_come_to_where_they_were_predicted(given):
    slid = _slid(given.run, 0.2)
    found, hands = finish(slid, given.rig), [arm.tip for arm in given.rig.arms]
    off = np.linalg.norm((found.positions - slid.positions)[:, :, hands], axis=-1)
    assert np.median(off) < 1e-6 and off.max() < 0.03


def test_frame_by_frame_and_at_once_are_the_same(given):
    slid, feet, frames = _slid(given.run, 0.2), None, []
    for k in range(len(slid)):
        positions, _, feet = finish_frame(given.rig, feet, slid.positions[k], slid.rotations[k], slid.contacts[k])
        frames.append(positions)
    np.testing.assert_allclose(np.stack(frames), finish(slid, given.rig).positions, atol=1e-9)


def test_a_mirrored_run_is_finished_as_in_a_mirror(limping, change):
    plain, image = _rollout(limping), _rollout(change.mirrored(limping))
    swap = [plain.body.joints.index(limping.skeleton.mirrored[j]) for j in plain.body.joints]
    found, mirrored = (finish(_slid(r.run, s), r.rig).positions for r, s in ((plain, 0.2), (image, -0.2)))
    np.testing.assert_allclose(mirrored[:, :, swap] * [-1, 1, 1], found, atol=1e-6)


def test_one_characters_nonsense_stays_its_own(limping):
    two = _rollout(limping, copies=2)
    alone = finish(_rollout(limping).run, two.rig).positions
    broken = two.run.positions.copy()
    broken[40:, 1] = np.nan
    found = finish(Rollout(**(vars(two.run) | {"positions": broken})), two.rig).positions
    np.testing.assert_array_equal(found[:, :1], alone)
