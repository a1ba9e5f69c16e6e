"""The catalogue: takes by style and gait, clips at 60 fps with one skeleton, and refusals that name the file."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from stylephase.data.catalogue import Catalogue, cut_frames, load_catalogue, load_clip, load_clips, usable
from stylephase.data.layouts import Entry
from stylephase.data.registry import dataset
from stylephase.errors import InputError
from stylephase.motion import synthetic


def test_takes_are_found_by_style_and_gait(small):
    catalogue = load_catalogue("small")
    assert catalogue.styles == ("set1-old", "set2-not-confident", "set2-old")
    assert catalogue.gaits == ("walk", "walk-turn-left")
    assert len(catalogue.of("set2-old")) == len(catalogue.of("set2-old", "walk")) == 1
    assert catalogue.of("set2-old", "run") == ()


def test_only_the_styles_asked_for_are_kept(small):
    assert load_catalogue("small", ["set1-old"]).styles == ("set1-old",)


def test_an_unknown_style_is_refused_with_those_spelt_alike(small):
    with pytest.raises(InputError, match=r"no style 'Set2_Old'; did you mean set2-old or set1-old\?"):
        load_catalogue("small", ["set1-old", "Set2_Old"])
    with pytest.raises(InputError, match="no style 'zebra'; there are set1-old, set2-not-confident, set2-old"):
        load_catalogue("small").of("zebra")


def test_a_clip_of_30_frames_a_second_comes_at_60(small):
    catalogue = load_catalogue("small")
    clip = load_clip(catalogue.entries[0], catalogue.dataset)
    assert clip.fps == 60.0 and len(clip) == 2 * 40 - 1
    np.testing.assert_allclose(np.diff(clip.root_positions[:, 2]) * 60, 1.0, atol=1e-4)


@pytest.mark.parametrize("fps", [29.0, 60.0])
def test_a_file_of_another_frame_rate_is_refused(small, make_bvh, fps):
    catalogue = load_catalogue("small")
    make_bvh(catalogue.entries[0].path, fps=fps)
    with pytest.raises(InputError, match=f"walk_old_001.bvh: expected 30 frames a second, found {fps:g}"):
        load_clip(catalogue.entries[0], catalogue.dataset)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (
            {"names": ("Hips", "LeftHip", "LeftToe", "RightHip", "RightToe", "LeftHand", "RightWrist")},
            "its joints differ .*: it has no RightHand",
        ),
        ({"offsets": [[0, 0, 0], [0.1, 0, 0], [0, -0.9, 0], *[[0.1, 0, 0]] * 4]}, "joint .* m off its place"),
    ],
)
def test_a_file_with_another_skeleton_is_named(small, make_bvh, change, reason):
    catalogue = load_catalogue("small")
    make_bvh(catalogue.entries[1].path, fps=30.0, **change)
    with pytest.raises(InputError, match=f"{catalogue.entries[1].path.name}: {reason}"):
        list(load_clips(catalogue))


def test_all_clips_have_the_skeleton_of_the_first_also_where_end_sites_lie_elsewhere(tmp_path, make_bvh):
    """An end site decides which joint counts as the hand, so one that some files lack must not change that."""
    for name, length in (("A_1", 0), ("A_2", 10)):
        path = make_bvh(tmp_path / f"{name}.bvh")
        hand = path.read_text().index("JOINT RightHand")
        head, tail = path.read_text()[:hand], path.read_text()[hand:]
        path.write_text(head + tail.replace("}", f"End Site\n{{\nOFFSET {length} 0 0\n}}\n}}", 1))
    first, second = (clip for _, clip in load_clips(load_catalogue(f"own:{tmp_path}")))
    assert second.skeleton is first.skeleton and first.skeleton.roles.hands[1] == 6


def test_a_cut_is_counted_at_60_fps_and_ends_with_the_file(make_bvh, tmp_path):
    style = dataset("bandai-namco")
    entry = Entry(make_bvh(tmp_path / "a.bvh", frames=40, fps=30.0), "A", "walk", 10, 30)
    clip = load_clip(entry, style)
    assert cut_frames(entry, style, clip) == (20, 60)
    assert cut_frames(replace(entry, stop=None), style, clip) == (20, 79)
    assert cut_frames(replace(entry, stop=4000), style, clip) == (20, 79)
    with pytest.raises(InputError, match=r"a\.bvh: the cut starts at frame 80, but the file has only 79 frames"):
        cut_frames(replace(entry, start=40), style, clip)


@pytest.mark.parametrize("content", ["", "HIERARCHY\nROOT Hips\n", "not a BVH"])
def test_a_broken_file_among_good_ones_is_named(tmp_path, make_bvh, content):
    make_bvh(tmp_path / "A_1.bvh")
    (tmp_path / "A_2.bvh").write_text(content)
    with pytest.raises(InputError, match=r"A_2\.bvh:(\d+:)? "):
        list(load_clips(load_catalogue(f"own:{tmp_path}")))


def test_a_folder_without_bvh_files_is_refused(tmp_path):
    with pytest.raises(InputError, match="no BVH files"):
        load_catalogue(f"own:{tmp_path}")


def test_standing_can_be_left_out(tmp_path):
    takes = tuple(Entry(Path(f"A_{gait}.bvh"), "A", gait) for gait in ("FW", "ID", "TR1"))
    assert [entry.gait for entry in Catalogue(dataset("100style"), takes).without_idle().entries] == ["FW", "TR1"]


def test_a_take_is_usable_from_70_frames_on():
    assert usable(70) and not usable(69)


def test_the_synthetic_walker_is_read_by_the_same_door(cache, monkeypatch):
    """One of its styles, generated short: cuts inside the files, one skeleton, flags from its own tables."""
    names = [style.name for style in synthetic.STYLES[:1]]
    monkeypatch.setattr(synthetic, "generate", partial(synthetic.generate, styles=names, seconds=1.0))
    catalogue = load_catalogue("synthetic")
    assert catalogue.styles == tuple(sorted(names)) and "ID" in catalogue.gaits
    for entry, clip in load_clips(catalogue):
        start, stop = cut_frames(entry, catalogue.dataset, clip)
        assert 0 <= start < stop == entry.stop <= len(clip)


@pytest.mark.timeout(300)
def test_the_real_locomotion_has_22_styles_and_every_style_reads(mirror, cache, monkeypatch):
    """One take of each style; `stylephase data check bandai-namco` reads all."""
    monkeypatch.setenv("STYLEPHASE_MIRROR", str(mirror))
    catalogue = load_catalogue("bandai-namco")
    assert len(catalogue.entries) == 1067 and len(catalogue.styles) == 22
    some = replace(catalogue, entries=tuple(catalogue.of(style)[0] for style in catalogue.styles))
    hips = [np.median(clip.root_positions[:, 1]) for _, clip in load_clips(some)]
    assert len(hips) == 22 and min(hips) > 0.6 and max(hips) < 1.1
