"""Gram transfer against a controller: who gets which rows, paths with a run-up, and what is measured."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_adapters as adapters
from tiny_walker import BODY, bundle, style_vectors

from stylephase.data.split import PARTS
from stylephase.errors import InputError
from stylephase.evaluation.gram import (
    apart,
    clip_alone,
    contents_of,
    driven,
    farthest,
    few_shot_styles,
    judged,
    known_stretches,
    lasting,
    learned_from_clips,
    material_of,
    materials_of,
    neutral_style,
    recorded_stretch,
    sliding,
    weights_folder,
)
from stylephase.evaluation.measures import Reference
from stylephase.evaluation.stretches import Stretch
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import save_bundle
from stylephase.motion.root import Root


def takes(*parts: str, gait: str = "walk", style: str = "Plain") -> StyleVectors:
    """Takes of 240 rows, each wholly in a part."""
    vectors, count = style_vectors(style), len(parts)
    part = np.repeat([PARTS.index(name) for name in parts], 240)
    take = np.repeat(np.arange(count), 240)
    arrays = {name: getattr(vectors, name)[: 240 * count] for name in ("x", "p", "y", "phase", "phase_update")}
    return replace(vectors, gaits=(gait,) * count, take=take, part=part, **arrays)


def test_walks_of_the_test_part_are_unseen_and_the_clip_is_of_another():
    material = material_of(takes("train", "test", "train"))
    assert [list(rows[[0, -1]]) for rows in material.unseen] == [[240, 479]]
    assert set(material.clip) <= set(range(240))
    assert sorted(int(rows[0]) for rows in material.known) == [0, 480]


def test_without_such_walks_the_last_take_is_unseen_and_of_one_take_its_end():
    two = material_of(takes("train", "train"))
    assert two.unseen[0][0] == 240 and len(two.known) == 1
    vectors = replace(style_vectors(), part=np.zeros(len(style_vectors().x), dtype=int))
    one = material_of(vectors)
    seen, held = np.concatenate([one.clip, *one.known]), one.unseen[0]
    assert seen.max() + 30 < held.min()


def test_a_style_of_one_short_walk_has_no_material():
    short = takes("train")
    with pytest.raises(InputError, match="no two walks"):
        material_of(short)
    assert list(materials_of([short, replace(takes("train", "test"), style="Other")])) == ["Other"]


def test_neutral_is_the_style_of_that_name_with_most_rows():
    some = [material_of(replace(takes(*parts), style=name)) for name, parts in (
        ("set1-normal", ("train", "test")), ("set2-normal", ("train", "test", "train")), ("old", ("train", "test"))
    )]  # fmt: skip
    assert neutral_style(some) == "set2-normal"
    with pytest.raises(InputError, match="none of the styles"):
        neutral_style(some[2:])


def test_contents_are_unseen_and_of_even_length():
    found = contents_of(material_of(takes("train", "test")), BODY.layout, frames=181)
    assert {name: len(motion) for name, motion in found.items()} == {"straight 1": 180}


def test_symmetric_styles_come_with_their_mirror_images():
    style = takes("train", "test")
    for symmetric, count in ((True, 2), (False, 1)):
        found = known_stretches([material_of(replace(style, symmetric=symmetric))], BODY.layout)
        assert len(found["Plain"]) == count


def test_a_path_with_a_run_up_begins_at_the_origin_and_keeps_its_shape():
    angles = np.linspace(0.7, 1.9, 240)
    steps = np.stack([np.sin(angles), np.cos(angles)], axis=1) / 60
    root = Root(np.cumsum(steps, axis=0) + [3.0, -2.0], angles)
    whole = lasting(root, 60)
    assert len(whole) == 300
    np.testing.assert_allclose(whole.positions[0], 0, atol=1e-9)
    np.testing.assert_allclose(whole.angles[:60], 0, atol=0.02)
    np.testing.assert_allclose(np.linalg.norm(np.diff(whole.positions[:60], axis=0), axis=1) * 60, 1.0, atol=0.05)
    ends = np.linalg.norm(whole.positions[-1] - whole.positions[60])
    assert ends == pytest.approx(np.linalg.norm(root.positions[-1] - root.positions[0]), abs=0.1)
    assert whole.angles[-1] - whole.angles[60] == pytest.approx(1.2, abs=0.1)


def test_a_controller_is_driven_for_as_long_as_its_path():
    weights, style = bundle("Plain", "Old"), style_vectors("Plain")
    path = Root(np.stack([np.zeros(90), np.arange(90) / 60], axis=1), np.zeros(90))
    drive = driven(weights, [style], {"Plain": path})
    asked, walked = drive.way("Plain")
    assert len(asked) == len(walked) == 90
    assert drive.off("Plain") == pytest.approx(np.linalg.norm(asked - walked, axis=1).mean())
    # Whoever goes straight on is right where the path is straight.
    assert drive.unled("Plain") < 0.1
    assert len(drive.walks["Plain"]) == 90


@pytest.fixture(scope="module")
def reference() -> Reference:
    return Reference(BODY, {name: [whole(name)] for name in ("Plain", "GiantStrides", "StoopedOver")})


def whole(style: str) -> Stretch:
    vectors = style_vectors(style)
    return recorded_stretch(vectors, np.arange(len(vectors.x)), BODY.layout)


def test_a_walk_is_nearest_to_its_own_style(reference):
    halves = {style: [whole(style).at(slice(480, None))] for style in ("Plain", "GiantStrides", "StoopedOver")}
    real = [whole("GiantStrides")]
    assert apart(reference, halves["GiantStrides"], real) < 0.3 * apart(reference, halves["Plain"], real)
    right = judged(reference, halves, halves)
    wrong = judged(reference, {"Plain": halves["GiantStrides"], "GiantStrides": halves["Plain"]}, halves)
    assert right["other style"].max() == 0 and right["distance"].max() == 0
    assert wrong["other style"][:2].min() == 1 and np.isnan(wrong["distance"][2])


def test_sliding_feet_are_noticed(reference):
    walk = whole("Plain")
    joints = walk.joints
    joints[:, :, 3, 2] += 0.3
    assert sliding(BODY, [Stretch(joints.reshape(len(walk), -1), walk.phase, walk.contacts)]) > 2 * sliding(
        BODY, [walk]
    )


def test_problem_styles_lie_farthest_from_neutral(reference):
    assert farthest(reference, "Plain", ["GiantStrides", "StoopedOver"]) == ["StoopedOver"]


def test_weights_are_those_named_then_a_run_then_those_shipped(tmp_path):
    run, shipped = tmp_path / "run", tmp_path / "shipped"
    with pytest.raises(InputError, match="no trained weights"):
        weights_folder(None, run, shipped)
    save_bundle(shipped, bundle())
    assert weights_folder(None, run, shipped) == shipped
    with pytest.raises(InputError, match="no trained weights"):
        weights_folder(tmp_path / "named", run, shipped)
    save_bundle(run, bundle())
    assert weights_folder(None, run, shipped) == run


def test_weights_say_which_styles_they_learned_from_one_clip():
    weights = bundle()
    assert few_shot_styles(weights) == ()
    learned = [{"style": "Old", "frames": 200}]
    assert few_shot_styles(replace(weights, about=weights.about | {"few_shot": learned})) == ("Old",)


def test_what_is_driven_learned_each_style_from_its_clip_and_nothing_else():
    material = material_of(takes("train", "test", "train"))
    cut = clip_alone(material)
    assert len(cut.x) == len(material.clip) and len(cut.gaits) == 1 and set(cut.part) == set(cut.take) == {0}
    np.testing.assert_array_equal(cut.y, material.style.y[material.clip])
    known = adapters.base()
    new = replace(material, style=replace(material.style, style="Limp"))
    old = replace(material, style=replace(material.style, style=known.styles[0]))
    learned = learned_from_clips(known, {"Limp": new, known.styles[0]: old})
    assert few_shot_styles(learned) == ("Limp",) and learned.styles == (*known.styles, "Limp")
