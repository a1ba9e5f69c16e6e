"""Vectors of files named one by one: what a data set of the same files would give, or a line that names the file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.data.catalogue import load_catalogue
from stylephase.errors import InputError
from stylephase.features.captures import captured_vectors, check_upright
from stylephase.features.store import StyleVectors, style_vectors
from stylephase.motion.bvh import write_bvh
from stylephase.motion.clip import Clip, resample
from stylephase.motion.rotations import from_matrix, to_matrix


@pytest.fixture
def walk(tmp_path) -> Path:
    path = tmp_path / "Sleepwalk_walk.bvh"
    write_bvh(path, tiny.take("Sleepwalk").clip)
    return path


def captured(*paths: Path, data: str = "unheard-of") -> StyleVectors:
    return captured_vectors(paths, "Sleepwalk", tiny.BODY, "adaptive", data)


def changed(path: Path, clip: Clip) -> Path:
    other = path.with_name("other.bvh")
    write_bvh(other, clip)
    return other


def test_they_are_those_of_a_folder_with_the_same_files(walk):
    found = captured(walk)
    expected = style_vectors(load_catalogue(f"own:{walk.parent}"), "Sleepwalk", tiny.BODY, "adaptive")
    for name in ("x", "p", "y", "phase", "take", "part"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    assert found.style == "Sleepwalk" and found.gaits == ("any",) and len(found.rows("test")) > 0


def test_every_file_is_a_take(walk):
    found = captured(walk, changed(walk, tiny.take("Plain").clip))
    assert len(found.gaits) == 2 and np.unique(found.take).tolist() == [0, 1]


def test_a_file_has_its_own_frame_rate(walk):
    """Whatever that of the data the weights were trained on."""
    slow = changed(walk, resample(tiny.take("Sleepwalk").clip, 30.0))
    assert abs(len(captured(slow, data="bandai-namco").x) - len(captured(walk).x)) <= 2


def test_contacts_are_by_the_rule_of_the_data(walk):
    strict, loose = (captured(walk, data=data).y[:, -2:].mean() for data in ("synthetic", "bandai-namco"))
    assert strict < loose


def test_a_short_take_is_refused(walk):
    short = changed(walk, tiny.take("Sleepwalk").clip.frames(0, 60))
    with pytest.raises(InputError, match=r"other.bvh: lasts 60 frames at 60 a second; a take needs 70"):
        captured(walk, short)


def test_standing_is_refused(walk):
    clip = tiny.take("Sleepwalk").clip
    still = replace(clip, root_positions=np.tile(clip.root_positions[:1], (len(clip), 1)))
    with pytest.raises(InputError, match=r"other.bvh: nobody walks in it: it gets on by 0.00 m/s"):
        captured(changed(walk, still))


def lying(clip: Clip) -> Clip:
    """Turned as a program with z up exports it."""
    turned = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    rotations = clip.rotations.copy()
    rotations[:, 0] = from_matrix(turned @ to_matrix(clip.rotations[:, 0]))
    return replace(clip, rotations=rotations, root_positions=clip.root_positions @ turned.T)


def test_another_axis_up_is_refused_in_files_and_in_a_data_set(walk):
    other = changed(walk, lying(tiny.take("Plain").clip))
    says = "its up axis seems to be z; export it with y up"
    with pytest.raises(InputError, match=f"other.bvh: {says}"):
        captured(walk, other)
    check_upright(load_catalogue(f"own:{walk.parent}", ["Sleepwalk"]))
    with pytest.raises(InputError, match=f"other.bvh: {says}"):
        check_upright(load_catalogue(f"own:{walk.parent}"))


def test_another_skeleton_is_refused(walk, skeletons):
    clip, other = tiny.take("Sleepwalk").clip, skeletons["bandai-namco"]
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(clip), len(other), 1))
    with pytest.raises(InputError, match=r"other.bvh: its joints differ from those of the weights' skeleton"):
        captured(changed(walk, replace(clip, skeleton=other, rotations=rotations)))


def test_other_bones_are_refused(walk):
    clip = tiny.take("Sleepwalk").clip
    offsets = clip.skeleton.offsets.copy()
    offsets[clip.skeleton.index("LeftKnee")] *= 1.2
    longer = replace(clip, skeleton=replace(clip.skeleton, offsets=offsets))
    with pytest.raises(InputError, match=r"other.bvh: joint LeftKnee lies 0.0\d+ m off its place in the weights' sk"):
        captured(changed(walk, longer))


def test_a_missing_file_is_refused(walk):
    with pytest.raises(InputError, match=r"nowhere\.bvh"):
        captured(walk.with_name("nowhere.bvh"))
