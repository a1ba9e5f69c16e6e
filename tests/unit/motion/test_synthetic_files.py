"""The synthetic data set on disk: one seed gives one result, laid out like 100STYLE, with the truth beside it."""

import csv

import numpy as np
import pytest

from stylephase.data.layouts import find_entries
from stylephase.errors import InputError
from stylephase.files import sha256
from stylephase.motion.bvh import read_bvh
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.synthetic import GAITS, SKELETON, find_style, generate, walk


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("synthetic")
    generate(path, styles=["Plain", "HopOnRight"], seconds=2.0)
    return path


def hashes(folder):
    return {str(path.relative_to(folder)): sha256(path) for path in folder.rglob("*") if path.is_file()}


def rows(path):
    with open(path, newline="", encoding="utf-8") as handle:
        return {row[0]: row[1:] for row in csv.reader(handle)}


def test_files_are_named_as_in_100style(folder):
    names = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    expected = {"Frame_Cuts.csv", "Dataset_List.csv"}
    for style in ("Plain", "HopOnRight"):
        expected |= {f"{style}/{style}_{gait}{end}" for gait in GAITS for end in (".bvh", ".truth.npz")}
    assert names == expected


def test_one_seed_gives_the_same_bytes_whatever_else_is_written(folder, tmp_path):
    generate(tmp_path / "again", styles=["HopOnRight"], seconds=2.0)
    again = {name: value for name, value in hashes(tmp_path / "again").items() if name.startswith("Hop")}
    assert len(again) == 2 * len(GAITS)
    assert again.items() <= hashes(folder).items()


def test_another_seed_gives_another_motion(folder, tmp_path):
    generate(tmp_path / "other", seed=1, styles=["Plain"], seconds=2.0)
    first, other = hashes(folder), hashes(tmp_path / "other")
    assert all(first[f"Plain/Plain_{gait}.bvh"] != other[f"Plain/Plain_{gait}.bvh"] for gait in GAITS)


def test_a_file_reads_back_as_the_take_in_memory(folder):
    clip, truth = walk(find_style("Plain"), "FW", seconds=2.0)
    read = read_bvh(folder / "Plain" / "Plain_FW.bvh")
    assert (read.skeleton.names, read.fps, len(read)) == (SKELETON.names, 60.0, len(clip))
    assert np.abs(forward_kinematics(read).positions - forward_kinematics(clip).positions).max() < 1e-6
    with np.load(folder / "Plain" / "Plain_FW.truth.npz") as stored:
        assert set(stored) == {"phase", "frequency", "contacts", "global_phase", "cut", "fps"}
        assert np.array_equal(stored["phase"], truth.phase)
        assert stored["contacts"].shape == (len(clip), 2) and stored["fps"] == 60


def test_bones_keep_their_length_in_the_files(folder):
    clip = read_bvh(folder / "HopOnRight" / "HopOnRight_TR1.bvh")
    points = forward_kinematics(clip).positions
    lengths = np.linalg.norm(points[:, 1:] - points[:, list(clip.skeleton.parents[1:])], axis=-1)
    assert np.ptp(lengths, axis=0).max() < 1e-9
    assert np.allclose(lengths[0], np.linalg.norm(SKELETON.offsets[1:], axis=-1), atol=1e-6)


def test_cuts_count_from_one_with_the_stop_outside_as_table_1_of_the_paper_needs(folder):
    table = rows(folder / "Frame_Cuts.csv")
    assert table["STYLE_NAME"][:4] == ["BR_START", "BR_STOP", "BW_START", "BW_STOP"]
    assert table["STYLE_NAME"][-2:] == ["TR3_START", "TR3_STOP"] and table["Plain"][-4:] == ["N/A"] * 4
    for gait in GAITS:
        column = table["STYLE_NAME"].index(f"{gait}_START")
        start, stop = (int(cell) for cell in table["Plain"][column : column + 2])
        with np.load(folder / "Plain" / f"Plain_{gait}.truth.npz") as truth:
            assert (start - 1, stop - 1) == tuple(truth["cut"])
            assert start > 30 and stop <= len(truth["phase"]) - 30
            assert stop - start == (60 if gait == "ID" else 120)


def test_the_importer_reads_the_cuts_and_flags_back(folder):
    """Writer and reader agree on where a cut ends; a frame more would be the first of the stand after the walk."""
    entries = find_entries("100style", folder)
    assert [(e.style, e.gait) for e in entries] == [(s, g) for s in ("HopOnRight", "Plain") for g in sorted(GAITS)]
    for entry in entries:
        with np.load(entry.path.with_suffix(".truth.npz")) as truth:
            assert (entry.start, entry.stop) == tuple(truth["cut"])
        assert entry.symmetric == (entry.style == "Plain")


def test_the_list_of_styles_says_which_are_symmetric_and_stochastic(folder):
    table = rows(folder / "Dataset_List.csv")
    assert table["Style Name"] == ["Description", "Stochastic", "Symmetric", "Notes"]
    assert table["Plain"][1:3] == ["No", "Yes"] and table["HopOnRight"][1:3] == ["No", "No"]
    assert all(len(row) == 4 for row in table.values())


def test_an_unknown_style_leaves_nothing_behind(tmp_path):
    with pytest.raises(InputError, match="no synthetic style 'Nobody'"):
        generate(tmp_path / "none", styles=["Plain", "Nobody"])
    assert not (tmp_path / "none").exists()
