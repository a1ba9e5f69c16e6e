"""BVH files: what is written comes back the same, what is odd but right is read, what is wrong is named."""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stylephase.errors import InputError
from stylephase.motion.bvh import guess_unit, read_bvh, write_bvh
from stylephase.motion.clip import Clip, forward_kinematics
from stylephase.motion.rotations import from_euler
from stylephase.motion.skeleton import Skeleton
from stylephase.motion.synthetic import find_style, walk

TURNS = "Zrotation Xrotation Yrotation"
MOVES = "Xposition Yposition Zposition"


def joint(name: str, offset: str, *inside: str, channels: str = f"CHANNELS 3 {TURNS}") -> str:
    return f"JOINT {name}\n{{\nOFFSET {offset}\n{channels}\n" + "".join(inside) + "}\n"


SITE = "End Site\n{\nOFFSET 0 0 10\n}\n"
LEGS = (
    joint("LeftUpLeg", "10 0 0", joint("LeftToeBase", "0 -95 0", SITE)),
    joint("RightUpLeg", "-10 0 0", joint("RightToeBase", "0 -95 0", SITE)),
)
ARMS = (joint("LeftHand", "20 40 0"), joint("RightHand", "-20 40 0"))
ROOT = f"ROOT Hips\n{{\nOFFSET 0 0 0\nCHANNELS 6 {MOVES} {TURNS}\n"
HIERARCHY = "HIERARCHY\n" + ROOT + "".join(LEGS + ARMS) + "}\n"
# Three frames of 6 + 6 x 3 values: the hips walk along z and the left thigh swings.
FRAMES = [f"0 95 {10 * t} 0 0 0 0 {5 * t} 0{' 0' * 15}" for t in range(3)]


def motion(frames: list[str]) -> str:
    return f"MOTION\nFrames: {len(frames)}\nFrame Time: 0.0166667\n" + "".join(f"{frame}\n" for frame in frames)


GOOD = HIERARCHY + motion(FRAMES)


@pytest.fixture
def write(tmp_path: Path):
    """A function that writes text or bytes to a file and gives its path."""

    def to_file(content: str | bytes) -> Path:
        path = tmp_path / "take.bvh"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return to_file


def refusal(path: Path) -> InputError:
    with pytest.raises(InputError) as caught:
        read_bvh(path)
    assert "\n" not in str(caught.value) and str(caught.value).startswith(str(path))
    return caught.value


def test_a_plain_file_is_read_in_metres_radians_and_seconds(write):
    clip = read_bvh(write(GOOD))
    assert clip.name == "take" and clip.fps == 60.0 and len(clip) == 3
    assert clip.skeleton.names[:4] == ("Hips", "LeftUpLeg", "LeftToeBase", "LeftToeBaseSite")
    np.testing.assert_allclose(clip.root_positions, [[0, 0.95, 0], [0, 0.95, 0.1], [0, 0.95, 0.2]])
    np.testing.assert_allclose(clip.skeleton.offsets[2], [0, -0.95, 0])
    # The thigh turns about x by 0, 5 and 10 degrees.
    np.testing.assert_allclose(clip.rotations[:, 1, 1], np.sin(np.radians([0, 2.5, 5])))


# Round trip


LETTERS = st.text(st.characters(categories=("L", "N"), include_characters=":_-."), min_size=1, max_size=12)
# The root has two children: a chain above the first fork would be read as what carries the hips.
TREES = st.lists(st.integers(0, 99), max_size=5).map(
    lambda rest: [-1, 0, 0, *(n % (j + 3) for j, n in enumerate(rest))]
)


def make_clip(parents: list[int], names: list[str], tips: list[bool], seed: int) -> Clip:
    """A clip of any tree: joints in a file's order, end sites on some tips, rotations of every kind."""
    found: list[tuple[str, int, bool]] = []

    def add(joint: int, parent: int) -> None:
        index, children = len(found), [j for j, p in enumerate(parents) if p == joint]
        found.append((names[joint], parent, False))
        for child in children:
            add(child, index)
        if not children and tips[joint]:
            found.append((f"{names[joint]}Site", index, True))

    add(0, -1)
    labels, tree, sites = zip(*found, strict=True)
    rng = np.random.default_rng(seed)
    offsets = rng.uniform(-2, 2, (len(tree), 3)) * (np.arange(len(tree)) > 0)[:, None]
    degrees = rng.choice([rng.uniform(-180, 180), 0.0, 90.0, -90.0, 180.0], (3, len(tree), 3))
    rotations = np.where(np.array(sites)[:, None], [1.0, 0, 0, 0], from_euler("YXZ", degrees))
    fps = float(rng.choice([25, 30, 60, 120]))
    return Clip(Skeleton(labels, tree, offsets, sites), fps, rotations, rng.uniform(-50, 50, (3, 3)))


@settings(max_examples=25)
@given(
    parents=TREES,
    names=st.lists(LETTERS.filter(lambda name: "Site" not in name), min_size=8, max_size=8, unique=True),
    tips=st.lists(st.booleans(), min_size=8, max_size=8),
    seed=st.integers(0, 2**32 - 1),
    order=st.permutations("XYZ").map("".join),
    unit=st.sampled_from([1.0, 0.01, 0.001]),
)
def test_what_is_written_is_read_back(tmp_path_factory, parents, names, tips, seed, order, unit):
    """Within a tenth of a millimetre and a hundredth of a degree."""
    clip = make_clip(parents, names, tips, seed)
    path = tmp_path_factory.mktemp("round") / "clip.bvh"
    write_bvh(path, clip, metres_per_unit=unit, order=order)
    back = read_bvh(path, metres_per_unit=unit)
    assert (back.skeleton.names, back.skeleton.parents) == (clip.skeleton.names, clip.skeleton.parents)
    assert back.skeleton.sites == clip.skeleton.sites and back.fps == clip.fps
    np.testing.assert_allclose(back.skeleton.offsets, clip.skeleton.offsets, atol=1e-4)
    np.testing.assert_allclose(back.root_positions, clip.root_positions, atol=1e-4)
    # The chord between unit quaternions is half the angle between the rotations.
    chord = np.minimum(*(np.linalg.norm(back.rotations - sign * clip.rotations, axis=-1) for sign in (1, -1)))
    assert np.degrees(2 * chord).max() < 0.01


@pytest.mark.parametrize("middle", [90.0, -90.0])
def test_gimbal_lock_survives_the_round_trip_without_a_warning(tmp_path, middle):
    """Two axes fall together there, so the angles are not unique, but the rotation is."""
    skeleton = Skeleton(("Hips", "A", "B"), (-1, 0, 0), np.eye(3), (False, False, False))
    rotations = np.tile(from_euler("YXZ", np.array([20.0, middle, 50.0])), (1, 3, 1))
    write_bvh(tmp_path / "lock.bvh", Clip(skeleton, 60.0, rotations, np.zeros((1, 3))))
    back = read_bvh(tmp_path / "lock.bvh", metres_per_unit=0.01)
    np.testing.assert_allclose(np.abs((back.rotations * rotations).sum(axis=-1)), 1.0, atol=1e-9)


# Odd, but right


@pytest.mark.parametrize("unit", [1.0, 0.01, 0.001, 0.0254, 0.0254 / 0.45])
def test_the_unit_is_guessed_from_the_legs(write, unit):
    offsets = read_bvh(write(GOOD)).skeleton
    scaled = Skeleton(offsets.names, offsets.parents, offsets.offsets / unit, offsets.sites)
    assert guess_unit(scaled) == unit


def test_legs_without_length_say_that_no_unit_can_be_guessed(write):
    flat = re.sub(r"OFFSET \S+ \S+ \S+", "OFFSET 0 0 0", GOOD)
    with pytest.raises(InputError, match="the unit cannot be guessed"):
        read_bvh(write(flat))


@pytest.mark.parametrize("top", ["10 20 30 0 0 0", "0 0 0 0 0 90", "5 0 -5 30 40 50"])
def test_joints_above_the_hips_carry_them(write, top):
    """A chain above the first fork is composed into the hips: place and heading are those of the whole tree."""
    bare = read_bvh(write(GOOD))
    inner = ROOT.replace("ROOT", "JOINT")
    carried = f"HIERARCHY\n{ROOT.replace('Hips', 'joint_Root')}{inner}{''.join(LEGS + ARMS)}}}\n}}\n"
    clip = read_bvh(write(carried + motion([f"{top} {frame}" for frame in FRAMES])))
    assert clip.skeleton.names == bare.skeleton.names
    values = np.array(top.split(), dtype=float)
    turn = forward_kinematics(
        Clip(bare.skeleton, 60.0, np.tile(from_euler("ZXY", values[3:]), (1, 11, 1)), np.zeros((1, 3)))
    )
    expected = forward_kinematics(bare).positions @ turn.rotations[0, 0].T + values[:3] / 100
    np.testing.assert_allclose(forward_kinematics(clip).positions, expected, atol=1e-9)


def with_hand_channels(values: list[str]) -> str:
    """The right hand, last in the file, gets position channels with these values."""
    six = GOOD.replace(ARMS[1], joint("RightHand", "-20 40 0", channels=f"CHANNELS 6 {MOVES} {TURNS}"))
    head = six[: six.index("MOTION")]
    return head + motion(
        [f"{frame.removesuffix(' 0 0 0')} {own} 0 0 0" for frame, own in zip(FRAMES, values, strict=True)]
    )


@pytest.mark.parametrize(("values", "expected"), [("-25 50 1", [-0.25, 0.5, 0.01]), ("0 0 0", [-0.2, 0.4, 0])])
def test_constant_position_channels_replace_the_offset_unless_all_zero(write, values, expected):
    clip = read_bvh(write(with_hand_channels([values] * 3)))
    np.testing.assert_allclose(clip.skeleton.offsets[-1], expected)


def test_a_bone_that_changes_its_length_is_refused(write):
    error = refusal(write(with_hand_channels(["-20 40 0", "-20 40 0", "-20 45 0"])))
    assert "joint RightHand moves against its parent" in error.reason
    assert GOOD.splitlines()[error.line - 2] == "JOINT RightHand"


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace(" ", "\t"),
        lambda text: text.replace("\n", " \t\n"),
        lambda text: text.replace("\n", "\n\n"),
        lambda text: "\ufeff" + text,
        lambda text: text.rstrip("\n"),
        lambda text: text.replace("End Site", "End site"),
        lambda text: text.replace("0.0166667", "1.66667e-02"),
    ],
    ids=["crlf", "tabs", "trailing blanks", "blank lines", "byte order mark", "no last newline", "case", "exponent"],
)
def test_spellings_that_mean_the_same_are_read_the_same(write, change):
    expected, clip = read_bvh(write(GOOD)), read_bvh(write(change(GOOD)))
    assert clip.skeleton.names == expected.skeleton.names and clip.fps == expected.fps
    np.testing.assert_array_equal(clip.rotations, expected.rotations)
    np.testing.assert_array_equal(clip.root_positions, expected.root_positions)


@pytest.mark.parametrize(
    ("prefix", "roles"),
    [("mixamorig:", True), ("キャラ_", True), ("Character 1 ", True)],
    ids=["namespace", "Japanese", "spaces"],
)
def test_exotic_names_are_kept(write, prefix, roles):
    clip = read_bvh(write(GOOD.replace("JOINT ", f"JOINT {prefix}")), metres_per_unit=0.01)
    assert clip.skeleton.names[1] == f"{prefix}LeftUpLeg".replace(" ", "_")
    assert (clip.skeleton.names[clip.skeleton.roles.toes[0]].endswith("LeftToeBase")) is roles


# Wrong


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("HIERARCHY", "HIERARCHIE", "not a BVH file"),
        ("ROOT Hips", "ROOT", "a joint without a name"),
        ("JOINT RightHand", "ROOT RightHand", "a second root"),
        ("JOINT RightHand", "JOINT LeftHand", "two joints are called LeftHand"),
        ("OFFSET 20 40 0", "OFFSET 20 40", "OFFSET: expected 3 numbers, found 2"),
        ("OFFSET 20 40 0", "OFFSET 20 4O 0", "OFFSET: expected numbers"),
        ("OFFSET 20 40 0", "OFFSET 20 nan 0", "OFFSET: a number is not finite"),
        ("OFFSET 20 40 0", "OFSET 20 40 0", "unexpected 'OFSET 20 40 0'"),
        (f"CHANNELS 6 {MOVES}", f"CHANNELS 5 {MOVES}", "CHANNELS: 5 announced, 6 named"),
        (f"CHANNELS 3 {TURNS}", "CHANNELS 3 Zrotation Xrotation Wrotation", "'Wrotation' is not a set of"),
        (f"CHANNELS 3 {TURNS}", "CHANNELS 3 Zrotation Xrotation Zrotation", "is not a set of"),
        ("MOTION", "MOTIONS", "unexpected 'MOTIONS'"),
        ("Frames: 3", "Frames 3", "expected 'Frames: N'"),
        ("Frames: 3", "Frames: three", "expected 'Frames: N'"),
        ("Frames: 3", "Frames: 3²", "expected 'Frames: N'"),
        ("Frame Time: 0.0166667", "Frame Time: 0", "it should be above zero"),
        ("Frame Time: 0.0166667", "Frame Time: nan", "Frame Time: a number is not finite"),
        (FRAMES[1], FRAMES[1] + " 0", "frame 1: expected 24 values, found 25"),
        (FRAMES[1], FRAMES[1].removesuffix(" 0"), "frame 1: expected 24 values, found 23"),
        (FRAMES[1], FRAMES[1].removesuffix("0") + "NaN", "frame 1: a number is not finite"),
        (FRAMES[1], FRAMES[1].removesuffix("0") + "1e999", "frame 1: a number is not finite"),
        (FRAMES[1], FRAMES[1].removesuffix("0") + "0,5", "frame 1: expected numbers"),
    ],
)
def test_a_wrong_line_is_named(write, old, new, reason):
    error = refusal(write(GOOD.replace(old, new, 1)))
    assert reason in error.reason and error.line == GOOD[: GOOD.index(old)].count("\n") + 1


def test_a_second_root_beside_the_first_is_refused(write):
    second = f"ROOT Prop\n{{\nOFFSET 0 0 0\nCHANNELS 3 {TURNS}\n}}\n"
    content = HIERARCHY + second + motion([f"{frame} 0 0 0" for frame in FRAMES])
    error = refusal(write(content))
    assert error.reason == "a second root" and error.line == HIERARCHY.count("\n") + 1


def test_helpers_beside_the_hips_are_left_out(write):
    """A camera before and targets after the hips, all below a bone that stands on the ground."""
    plain = read_bvh(write(GOOD))
    hips = HIERARCHY.removeprefix("HIERARCHY\n").replace("ROOT", "JOINT")
    camera = joint("Camera", "0 100 300")
    targets = joint("Targets", "0 0 0", joint("TargetL", "10 0 0"), joint("TargetR", "-10 0 0"))
    content = f"HIERARCHY\nROOT Ground\n{{\nOFFSET 0 0 0\nCHANNELS 3 {TURNS}\n{camera}{hips}{targets}}}\n"
    content += motion([f"0 0 0 9 9 9 {frame} {'7 ' * 9}".rstrip() for frame in FRAMES])
    found = read_bvh(write(content))
    assert found.skeleton.names == plain.skeleton.names
    np.testing.assert_allclose(forward_kinematics(found).positions, forward_kinematics(plain).positions, atol=1e-9)


@pytest.mark.parametrize("old", [f"CHANNELS 3 {TURNS}\n", "OFFSET 20 40 0\n"])
def test_a_joint_without_offset_or_channels_is_refused(write, old):
    assert f"ends without {old.split()[0]}" in refusal(write(GOOD.replace(old, ""))).reason


def test_fewer_values_in_every_frame_than_channels_are_refused(write):
    """All lines alike, so only the comparison with the hierarchy can tell."""
    error = refusal(write(HIERARCHY + motion([frame.removesuffix(" 0") for frame in FRAMES])))
    assert (
        error.reason == "frame 0: expected 24 values, found 23" and error.line == GOOD.splitlines().index(FRAMES[0]) + 1
    )


@pytest.mark.parametrize(
    ("frames", "reason"),
    [("Frames: 2", "more frames than the 2 announced"), ("Frames: 4", "the file ends after 3 of 4 frames")],
)
def test_more_or_fewer_frames_than_announced_are_refused(write, frames, reason):
    error = refusal(write(GOOD.replace("Frames: 3", frames)))
    assert error.reason == reason and error.line == len(GOOD.splitlines())


def test_no_frames_are_refused(write):
    assert refusal(write(HIERARCHY + motion([]))).reason == "the file has no frames"


@given(st.integers(0, len(GOOD) - 2))
def test_a_file_cut_off_anywhere_is_refused(tmp_path_factory, end):
    """Every number of this file has one digit; a cut inside the very last number of a file cannot be seen."""
    path = tmp_path_factory.mktemp("cut") / "take.bvh"
    path.write_text(GOOD[:end])
    refusal(path)


@pytest.mark.parametrize(
    "content", [b"", b"\n\n", b"\x89PNG\r\n\x1a\n\x00\xff", bytes(range(256)), b"PK\x03\x04", "walk\n".encode("utf-16")]
)
def test_what_is_no_bvh_is_refused(write, content):
    reason = refusal(write(content)).reason
    assert "not a BVH file" in reason or reason == "the file ends where HIERARCHY should stand"


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    assert refusal(tmp_path / "none.bvh").reason == "no such file"
    assert "is a folder" in refusal(tmp_path).reason


def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "take.bvh")
    assert refusal(tmp_path / "take.bvh").reason == "is no regular file"


def test_a_clip_that_is_not_finite_is_not_written(tmp_path):
    """A rollout that blew up must not take the place of an earlier result."""
    path = tmp_path / "clip.bvh"
    path.write_text(GOOD)
    clip = read_bvh(path)
    broken = Clip(clip.skeleton, clip.fps, np.full_like(clip.rotations, np.nan), clip.root_positions)
    with pytest.raises(InputError, match="not finite"):
        write_bvh(path, broken)
    assert path.read_text() == GOOD and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("seconds", ["1000", "1e-9"])
def test_a_frame_that_lasts_too_long_or_too_short_is_refused(tmp_path, seconds):
    """A slip in the unit would make windows of a second a handful of frames, or a thousand million."""
    clip, _ = walk(find_style("Plain"), "FW", seconds=1.0)
    write_bvh(tmp_path / "a.bvh", clip)
    text = re.sub(r"Frame Time: \S+", f"Frame Time: {seconds}", (tmp_path / "a.bvh").read_text())
    (tmp_path / "a.bvh").write_text(text)
    with pytest.raises(InputError, match=r"a\.bvh:\d+: Frame Time is .* expected 0.001 to 1"):
        read_bvh(tmp_path / "a.bvh")
