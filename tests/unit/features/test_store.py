"""Vectors of a data set: cached by content, the same for any choice of styles, each row within one part."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stylephase.data.catalogue import load_catalogue, usable
from stylephase.data.split import PARTS, split
from stylephase.errors import InputError
from stylephase.features import store as module
from stylephase.features.body import body_from_json, body_of
from stylephase.features.store import StyleVectors, VectorStore
from stylephase.motion.bvh import write_bvh
from stylephase.motion.rest import stands_at_zero
from stylephase.motion.synthetic import find_style, steady, walk


@pytest.fixture(scope="module")
def folder(tmp_path_factory, change) -> Path:
    """Three styles with a file or two each, joint frames lying in any way; `brief` is too short to learn from."""
    top = tmp_path_factory.mktemp("own") / "mine"
    for style, name, lengths in (
        ("plain", "Plain", (300, 90)),
        ("limp", "DraggedLeft", (120,)),
        ("brief", "Plain", (25,)),
    ):
        clip, _ = walk(find_style(name), "FW", plan=steady(6.0))
        for number, length in enumerate(lengths):
            path = top / style / f"take{number}.bvh"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_bvh(path, change.reframed(clip.frames(number, number + length)))
    return top


@pytest.fixture(scope="module")
def filled(folder, tmp_path_factory) -> Path:
    """A cache with the vectors of the styles that are long enough."""
    path = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STYLEPHASE_CACHE", str(path))
        opened = VectorStore(load_catalogue(f"own:{folder}"), "adaptive")
        for style in ("plain", "limp"):
            opened.load(style)
    return path


@pytest.fixture
def store(folder, filled, monkeypatch) -> VectorStore:
    monkeypatch.setenv("STYLEPHASE_CACHE", str(filled))
    return VectorStore(load_catalogue(f"own:{folder}"), "adaptive")


@pytest.fixture
def plain(store) -> StyleVectors:
    return store.load("plain")


def refuse(*_, **__):
    raise AssertionError("vectors would be computed")


def test_rows_and_widths_are_as_the_layout_says(store, plain):
    layout = store.body.layout
    assert plain.x.shape == (299 + 89, layout.inputs) == (388, 348)
    assert (plain.p.shape, plain.y.shape) == ((388, 8), (388, 342))
    assert {plain.x.dtype, plain.p.dtype, plain.y.dtype} == {np.dtype("float32")}
    assert plain.gaits == ("any", "any") and not plain.symmetric
    np.testing.assert_array_equal(np.bincount(plain.take), [299, 89])
    assert np.isfinite(plain.x).all() and np.isfinite(plain.y).all()


def test_a_second_call_reads_the_cache(store, monkeypatch):
    monkeypatch.setattr(module, "style_vectors", refuse)
    monkeypatch.setattr(module, "body_of", refuse)
    assert len(store.load("limp").x) == 119
    assert len(store.body.joints) == 25


def test_parts_never_mix(store, plain):
    """A row stands for its frame and the next: both lie in the row's part, and no frame of a guard is used."""
    entries, lengths = store.catalogue.of("plain"), [300, 90]
    frames = [np.full(length, -1) for length in lengths]
    for segment in split(entries, lengths, seed=0):
        frames[segment.entry][segment.start : segment.stop] = PARTS.index(segment.part)
    for take in (0, 1):
        part = plain.part[plain.take == take]
        used = part >= 0
        np.testing.assert_array_equal(frames[take][:-1][used], part[used])
        np.testing.assert_array_equal(frames[take][1:][used], part[used])
        assert used.sum() == sum(len(s) - 1 for s in split(entries, lengths, seed=0) if s.entry == take)
    # The long take has all three parts, the one below four seconds trains only.
    assert set(plain.part[plain.take == 0]) == {-1, 0, 1, 2}
    assert set(plain.part[plain.take == 1]) == {PARTS.index("train")}


def test_rows_are_chosen_by_part_and_gait(plain):
    two = replace(plain, gaits=("walk", "run"))
    train = two.rows("train")
    assert np.all(two.part[train] == PARTS.index("train"))
    np.testing.assert_array_equal(np.sort(np.concatenate([two.rows("train", g) for g in ("walk", "run")])), train)
    assert np.all(two.take[two.rows("train", "run")] == 1)
    assert len(two.rows("test", "run")) == 0


def test_a_style_with_too_few_frames_is_refused_in_one_line(store):
    assert not usable(25)
    with pytest.raises(InputError, match=r"^style 'brief' has no take that is long enough to learn from$"):
        store.load("brief")
    assert not store.path("brief").exists()


def test_an_unknown_style_is_refused(store):
    with pytest.raises(InputError, match="no style 'plane'; did you mean plain"):
        store.load("plane")


def test_the_body_is_that_of_the_whole_set_whichever_styles_are_asked_for(folder, store, cache):
    """Where it is a mean pose, it would else depend on which command came first."""
    assert not stands_at_zero(store.body.skeleton)
    one = VectorStore(load_catalogue(f"own:{folder}", ["limp"]), "adaptive")
    assert one.folder.name == store.folder.name and one.catalogue.styles == ("limp",)
    np.testing.assert_array_equal(one.body.rest, store.body.rest)
    only_limp = body_of(load_catalogue(f"own:{folder}", ["limp"]))
    assert np.abs(only_limp.rest - store.body.rest).max() > 0.1


def test_a_body_comes_back_from_json(store):
    body = store.body
    again = body_from_json(json.loads(json.dumps(body.to_json())))
    assert (again.skeleton.names, again.skeleton.parents) == (body.skeleton.names, body.skeleton.parents)
    np.testing.assert_array_equal(again.skeleton.offsets, body.skeleton.offsets)
    np.testing.assert_array_equal(again.rest, body.rest)
    assert again.layout == body.layout and again.bones == body.bones


def test_bones_join_neighbours_of_the_skeleton(store):
    body = store.body
    pairs = {tuple(body.skeleton.names[body.joints[k]] for k in bone) for bone in body.bones}
    assert len(body.bones) == 24
    assert {("LeftWrist", "LeftWristSite"), ("Hips", "RightHip"), ("Chest4", "Neck")} <= pairs


@pytest.fixture
def make_folder(tmp_path, upright):
    """A function that makes a folder with a style for each name, whose take begins at the frame given."""

    def make(starts: dict[str, int]) -> Path:
        for style, start in starts.items():
            path = tmp_path / "own" / style / "take.bvh"
            path.parent.mkdir(parents=True)
            write_bvh(path, upright.frames(start, start + 75))
        return tmp_path / "own"

    return make


def test_styles_whose_names_differ_in_signs_only_have_files_of_their_own(make_folder, cache):
    store = VectorStore(load_catalogue(f"own:{make_folder({'a b': 0, 'a_b': 1})}"), "adaptive")
    assert store.path("a b") != store.path("a_b")
    assert np.abs(store.load("a b").x - store.load("a_b").x).max() > 0.01


def test_the_cache_is_another_when_files_or_their_styles_change(make_folder, cache):
    folder = make_folder({"old": 0, "proud": 1})

    def place() -> str:
        return VectorStore(load_catalogue(f"own:{folder}"), "adaptive").folder.name

    first = place()
    assert VectorStore(load_catalogue(f"own:{folder}"), "release").folder.name != first
    for old, new in (("old", "was-old"), ("proud", "old"), ("was-old", "proud")):
        (folder / old).rename(folder / new)
    swapped = place()
    assert swapped != first
    with open(folder / "old" / "take.bvh", "a") as handle:
        handle.write("\n")
    assert place() != swapped
