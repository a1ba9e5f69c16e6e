"""Separation of style codes: planted groups are found, and groups that are none are at chance."""

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.evaluation.embedding import codes_of_clips, nearest_centroid, picture, silhouettes


def groups(spread: float, seed: int = 0, styles: int = 5, clips: int = 20) -> dict[str, np.ndarray]:
    """Clouds of unit size about centres that lie `spread` apart from the origin in each of many directions."""
    rng = np.random.default_rng(seed)
    return {f"style{n}": rng.normal(size=60) * spread + rng.normal(size=(clips, 60)) for n in range(styles)}


def test_separate_groups_are_separate():
    assert min(silhouettes(groups(10.0)).values()) > 0.8
    assert set(nearest_centroid(groups(10.0)).values()) == {1.0}


def test_groups_that_are_none_are_at_chance():
    """A clip does not find its own group again because it is in the mean."""
    apart = [nearest_centroid(groups(0.0, seed)) for seed in range(20)]
    assert np.mean([share for shares in apart for share in shares.values()]) == pytest.approx(0.2, abs=0.06)
    assert np.abs(list(silhouettes(groups(0.0)).values())).max() < 0.05


def test_names_that_are_swapped_are_found_out():
    one = groups(10.0)
    swapped = {"style0": one["style1"], "style1": one["style0"]}
    assert nearest_centroid(one, swapped) == {"style0": 0.0, "style1": 0.0}


def test_other_clips_are_asked_with_all_centroids():
    assert nearest_centroid(groups(10.0, clips=20), {"style2": groups(10.0)["style2"][:3]}) == {"style2": 1.0}


def test_a_style_of_one_clip_is_a_rival_and_is_not_asked():
    some = groups(10.0)
    some["style4"] = some["style0"][:1]
    assert list(silhouettes(some)) == list(nearest_centroid(some)) == ["style0", "style1", "style2", "style3"]
    assert silhouettes(some)["style0"] < silhouettes(groups(10.0))["style0"]


def test_the_picture_keeps_groups_together_and_repeats_itself():
    places, labels = picture(groups(10.0))
    assert places.shape == (100, 2) and labels[0] == "style0" and labels[-1] == "style4"
    np.testing.assert_array_equal(places, picture(groups(10.0))[0])
    flat = {name: places[np.array(labels) == name] for name in dict.fromkeys(labels)}
    assert set(nearest_centroid(flat).values()) == {1.0}


def test_codes_are_of_clips_of_known_and_unknown_styles():
    styles = [tiny.style_vectors(name, 30.0) for name in ("Plain", "Sleepwalk")]
    bundle = tiny.bundle("Plain")
    codes = codes_of_clips(bundle, styles, most=3)
    assert {name: group.shape for name, group in codes.items()} == {"Plain": (3, 32), "Sleepwalk": (3, 32)}
    assert codes_of_clips(bundle, styles, part="test")["Plain"].shape[1] == 32
