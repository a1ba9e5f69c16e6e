"""The nearest real style: planted styles are found again, and where there is nothing to find, nothing is found."""

from dataclasses import replace

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.data.split import PARTS
from stylephase.evaluation.style import recognised, statistics, style_space, walking_gaits, windows_of
from stylephase.features.layout import Layout
from stylephase.features.store import StyleVectors

LAYOUT = Layout(3, (0, 2, 1))


def made(name: str, seed: int, offset: np.ndarray | float = 0.0, gaits: tuple[str, str] = ("FW", "FR")) -> StyleVectors:
    """Noise in two gaits, 20 seconds of each for training and for testing; `offset` moves the joints of the first."""
    rng, half = np.random.default_rng(seed), 1200
    x = rng.normal(size=(4 * half, LAYOUT.inputs))
    take = np.repeat([0, 1], 2 * half)
    x[take == 0, LAYOUT.x_pose] += offset
    part = np.tile(np.repeat([PARTS.index("train"), PARTS.index("test")], half), 2)
    blank = np.zeros((len(x), 8)), np.zeros((len(x), LAYOUT.outputs))
    return StyleVectors(name, False, gaits, x, *blank, *np.zeros((2, len(x))), take, part)


@pytest.fixture(scope="module")
def planted() -> list[StyleVectors]:
    rng = np.random.default_rng(9)
    return [made(f"style{n}", n, rng.normal(size=LAYOUT.pose) * 0.5) for n in range(6)]


def test_statistics_are_of_positions_and_velocities():
    """Means and deviations; the axes of the joints do not count."""
    poses = np.zeros((100, 2, 4, 3))
    poses[:, 0, 0] = [1, 2, 3]
    poses[:, 1, 3, 0] = np.tile([-2, 2], 50)
    poses[:, :, 1:3] = np.random.default_rng(0).normal(size=(100, 2, 2, 3))
    mean, std, speed_mean, speed_std = statistics(poses.reshape(100, 24)).reshape(4, 6)
    np.testing.assert_allclose(mean, [1, 2, 3, 0, 0, 0])
    np.testing.assert_allclose(std, 0)
    np.testing.assert_allclose(speed_mean, 0)
    np.testing.assert_allclose(speed_std, [0, 0, 0, 2, 0, 0])


def test_planted_styles_are_found_again(planted):
    space = style_space(planted, LAYOUT)
    right, clips = recognised(space, planted, LAYOUT, "test")
    assert clips == 6 * 9 and right == clips


def test_where_there_is_no_style_it_is_guessed_at_chance():
    """Six names for the same noise: one clip in six is called rightly, give or take."""
    names = [made(f"style{n}", n) for n in range(6)]
    right, clips = recognised(style_space(names, LAYOUT), names, LAYOUT, "test")
    assert clips == 54 and 2 <= right <= 20


def test_shuffled_names_are_not_recognised(planted):
    """Each style's test clips under the name of another."""
    shuffled = [replace(style, style=f"style{(n + 1) % 6}") for n, style in enumerate(planted)]
    assert recognised(style_space(planted, LAYOUT), shuffled, LAYOUT, "test") == (0, 54)


def test_training_clips_make_the_space_and_test_clips_do_not(planted):
    blank = [replace(s, x=np.where(s.part[:, None] == PARTS.index("test"), 1e3, s.x)) for s in planted]
    np.testing.assert_array_equal(style_space(blank, LAYOUT).centres, style_space(planted, LAYOUT).centres)


def test_the_walk_is_the_style_where_the_data_name_one(planted):
    assert walking_gaits(planted[0]) == ("FW",)
    assert walking_gaits(replace(planted[0], gaits=("walk", "run"))) == ("walk",)
    assert walking_gaits(replace(planted[0], gaits=("any", "any"))) is None
    style = planted[0]
    walks = np.concatenate(windows_of(style, "train", LAYOUT))
    assert np.abs(walks.mean(0) - style.x[:1200, LAYOUT.x_pose].mean(0)).max() < 0.2
    assert len(windows_of(replace(style, gaits=("any", "any")), "train", LAYOUT)) == 2 * len(
        windows_of(style, "train", LAYOUT)
    )


def test_a_style_of_one_clip_and_one_without_any_do_no_harm(planted):
    """The spread comes from the others; a style without training clips cannot be the nearest."""
    short = replace(planted[0], part=np.where(np.arange(4800) < 240, planted[0].part, -1))
    none = replace(planted[1], part=np.full(4800, -1))
    space = style_space([short, none, *planted[2:]], LAYOUT)
    assert space.styles == ("style0", "style2", "style3", "style4", "style5")
    assert np.isfinite(space.distances(windows_of(planted[2], "test", LAYOUT)[0])).all()
    assert recognised(space, planted[2:], LAYOUT, "test") == (36, 36)


def test_the_synthetic_styles_are_told_apart():
    styles = [tiny.style_vectors(name, 30.0) for name in ("Plain", "DraggedLeft")]
    right, clips = recognised(style_space(styles, tiny.BODY.layout), styles, tiny.BODY.layout, "test")
    assert clips >= 2 and right == clips
