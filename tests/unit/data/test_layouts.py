"""Each layout gives style, gait and cut; a table that is wrong is named with its line."""

from collections import Counter
from pathlib import Path

import pytest

from stylephase.data.archive import fetch
from stylephase.data.layouts import find_entries, hash_content, published_entries
from stylephase.data.registry import dataset
from stylephase.errors import InputError

LIST = "Style Name,Description,Stochastic,Symmetric,Notes\nProud,chest out,No,Yes,\nDrunk,sways,Yes,No,\n"
CUTS = "STYLE_NAME,FW_START,FW_STOP,ID_START,ID_STOP,TR1_START,TR1_STOP\nDrunk,3,9,N/A,N/A,2,8\nProud,1,5,2,4,N/A,N/A\n"


@pytest.fixture
def styled(tmp_path: Path) -> Path:
    """A folder in the layout of 100STYLE, where one file of the table is missing."""
    top = tmp_path / "100STYLE"
    for name in ("Drunk_FW", "Drunk_TR1", "Proud_FW"):
        path = top / name.split("_")[0] / f"{name}.bvh"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    (top / "Dataset_List.csv").write_text(LIST)
    (top / "Frame_Cuts.csv").write_text(CUTS)
    return tmp_path


def test_the_layout_of_100style_takes_cuts_and_flags_from_its_tables(styled):
    drunk, turning, proud = find_entries("100style", styled)
    assert (drunk.style, drunk.gait, drunk.start, drunk.stop) == ("Drunk", "FW", 2, 8)
    assert drunk.stochastic and not drunk.symmetric and proud.symmetric and not proud.stochastic
    assert turning.transition and not turning.idle and not proud.transition
    assert (proud.path.name, proud.start, proud.stop) == ("Proud_FW.bvh", 0, 4)


@pytest.mark.parametrize(
    ("file", "old", "new", "line", "reason"),
    [
        ("Frame_Cuts.csv", "STYLE_NAME", "STYLE", 1, "no column 'STYLE_NAME'"),
        ("Frame_Cuts.csv", "Drunk,3,9", "Drunk,9,3", 2, "FW: expected a start below a stop, found '9' and '3'"),
        ("Frame_Cuts.csv", "Drunk,3,9", "Drunk,0,9", 2, "FW: expected a start below a stop"),
        ("Frame_Cuts.csv", "Drunk,3,9", "Drunk,3,nine", 2, "FW: expected a start below a stop"),
        ("Frame_Cuts.csv", "Proud,1,5,2,4,N/A,N/A", "Proud,1", 3, "FW: expected a start below a stop"),
        ("Frame_Cuts.csv", "Proud", "Prude", 3, "style Prude is not in Dataset_List.csv"),
        ("Dataset_List.csv", "Style Name", "Name", 1, "no column 'Style Name'"),
        ("Dataset_List.csv", "sways,Yes,No", "sways,Yes,Maybe", 3, "Symmetric: expected Yes or No, found 'Maybe'"),
        ("Dataset_List.csv", "chest out,No,Yes,", "chest out", 2, "Symmetric: expected Yes or No, found ''"),
    ],
)
def test_a_wrong_table_is_named_with_its_line(styled, file, old, new, line, reason):
    path = styled / "100STYLE" / file
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError) as caught:
        find_entries("100style", styled)
    assert str(caught.value).startswith(f"{path}:{line}: {reason}")


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00\x81"])
def test_a_table_that_is_missing_or_no_text_is_named(styled, content):
    path = styled / "100STYLE/Frame_Cuts.csv"
    path.unlink() if content is None else path.write_bytes(content)
    with pytest.raises(InputError, match=r"Frame_Cuts\.csv: no(t a CSV| such) file"):
        find_entries("100style", styled)


def test_the_layout_of_bandai_namco_keeps_the_styles_of_its_two_sets_apart(bandai_files):
    found = [(entry.style, entry.gait, entry.start, entry.stop) for entry in find_entries("bandai-namco", bandai_files)]
    assert found == [
        ("set1-old", "walk", 0, None),
        ("set2-not-confident", "walk-turn-left", 0, None),
        ("set2-old", "walk", 0, None),
    ]


def test_a_file_named_otherwise_is_refused(tmp_path):
    (tmp_path / "dataset-1_walk.bvh").write_text("")
    with pytest.raises(InputError, match=r"dataset-1_walk\.bvh: expected a name such as"):
        find_entries("bandai-namco", tmp_path)


def test_own_files_are_named_by_folder_or_prefix(tmp_path):
    for name in ("Pirate/one.bvh", "Pirate/deep/two.BVH", "Robot_walk_1.bvh", "plain.bvh", "notes.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    entries = find_entries("own", tmp_path)
    assert [entry.style for entry in entries] == ["Pirate", "Pirate", "Robot", "plain"]
    assert {entry.gait for entry in entries} == {"any"}
    # Nobody has said that the mirrored motion is of the same style.
    assert not any(entry.symmetric for entry in entries)


def test_the_layout_of_pfnn_leaves_out_the_mirrored_copies(tmp_path):
    """They would be a second copy of the same motion, since a take of a symmetric style is mirrored in training."""
    for name in ("NewCaptures10_000", "NewCaptures10_000_mirror", "LocomotionFlat04_000"):
        for ending in ("bvh", "phase"):
            (tmp_path / f"{name}.{ending}").write_text("")
    flat, rough = find_entries("pfnn", tmp_path)
    assert (flat.path.name, rough.path.name) == ("LocomotionFlat04_000.bvh", "NewCaptures10_000.bvh")
    assert {(e.style, e.gait, e.symmetric) for e in (flat, rough)} == {("neutral", "any", True)}


@pytest.mark.parametrize("layout", ["own", "bandai-namco", "100style", "pfnn"])
def test_an_empty_folder_is_refused(tmp_path, layout):
    with pytest.raises(InputError, match="no BVH files of this data set in the folder"):
        find_entries(layout, tmp_path)


def test_the_content_hash_does_not_depend_on_the_place_but_on_every_byte(styled, tmp_path):
    entries = find_entries("100style", styled)
    first = hash_content(entries)
    moved = styled.rename(tmp_path.parent / f"{tmp_path.name}-moved")
    entries = find_entries("100style", moved)
    assert hash_content(entries) == hash_content(entries[::-1]) == first
    entries[0].path.write_text("Drunk_FX")
    assert hash_content(entries) != first


def test_the_cuts_of_100style_sum_to_table_1_of_the_paper():
    """Frames by gait."""
    frames: Counter[str] = Counter()
    for entry in published_entries():
        frames["TR" if entry.transition else entry.gait] += entry.stop - entry.start
    assert frames.total() == 4_055_978
    assert frames == {
        **{"BR": 434_329, "BW": 768_574, "FR": 414_911, "FW": 777_640},
        **{"SR": 250_980, "SW": 541_041, "ID": 81_685, "TR": 786_818},
    }


def test_the_list_of_100style_has_100_styles_of_which_70_are_symmetric():
    entries = published_entries()
    assert len({entry.style for entry in entries}) == 100
    assert len({entry.style for entry in entries if entry.symmetric}) == 70
    assert len({entry.style for entry in entries if entry.stochastic}) == 5


def test_the_list_agrees_with_the_tables_of_the_data_set(mirror, cache, monkeypatch):
    """Where the mirror has them: every take there has the cut and the flags that the list says."""
    monkeypatch.setenv("STYLEPHASE_MIRROR", str(mirror))
    listed = {(e.style, e.gait): (e.start, e.stop, e.symmetric, e.stochastic) for e in published_entries()}
    found = find_entries("100style", fetch(dataset("100style")))
    assert len(found) >= 3
    for entry in found:
        assert listed[entry.style, entry.gait] == (entry.start, entry.stop, entry.symmetric, entry.stochastic)
