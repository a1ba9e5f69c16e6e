"""Plots: the data are in them, axes have units, colours stay apart, files are small, described and repeatable."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from PIL import Image

from stylephase.errors import InputError
from stylephase.report import palette
from stylephase.report.plots import bar_with_interval, embedding, learning_curve, phase_plot, save_figure
from stylephase.report.png import LIMIT, write_png

FPS = 60.0
# How colours look to readers without one kind of cone, in linear RGB (Machado et al. 2009, severity 1).
_SIGHT = {
    "usual": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
_TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def _lab(colour: str, sight: np.ndarray) -> np.ndarray:
    """CIELAB of an sRGB colour as seen with `sight`."""
    channels = np.array(palette.rgb(colour)) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    xyz = _TO_XYZ @ np.clip(sight @ linear, 0, 1) / [0.9505, 1.0, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("sight", _SIGHT)
@pytest.mark.parametrize(
    "colours",
    [
        palette.MODELS,
        palette.EFFECTORS,
        {"left": palette.LEFT, "right": palette.RIGHT, "body": palette.BODY},
        {f"outcome {k}": colour for k, colour in enumerate(palette.OUTCOMES)},
    ],
)
def test_colours_stay_apart_for_every_reader(colours: dict[str, str], sight: str):
    """Two colours are clearly told apart from a CIELAB distance of 20 on, with any colour vision."""
    for one, other in combinations(colours, 2):
        distance = np.linalg.norm(_lab(colours[one], _SIGHT[sight]) - _lab(colours[other], _SIGHT[sight]))
        assert distance > 20, (one, other)


def test_letters_can_be_read_on_every_outcome():
    for colour in palette.OUTCOMES:
        ink, ground = (_lab(each, np.eye(3))[0] for each in (palette.ink_on(colour), colour))
        assert abs(ink - ground) > 40, colour


def test_colour_belongs_to_the_name():
    """Every model of the command line has a colour of its own; a naive predictor is grey."""
    names = ("pfnn-onehot", "lpn-onehot", "pfnn-resad", "lpn-resad", "pfnn-film", "mann-film", "lpn-film")
    assert len({palette.colour_of(name) for name in names}) == len(names)
    assert palette.colour_of("LeftFoot") == palette.LEFT
    assert palette.colour_of("hold the pose") == palette.QUIET


def _phases() -> dict:
    phases = np.stack([(np.arange(120) / FPS + start) % 1 for start in (0.0, 0.5, 0.1, 0.6)], axis=1)
    contacts = phases[:, [3, 2]] < 0.5
    return {
        "sources": np.sin(2 * np.pi * phases),
        "phases": phases,
        "magnitudes": np.ones((120, 4)) * [0.25, 0.0, 1.0, 1.0],
        "contacts": contacts,
        "fps": FPS,
    }


def test_phase_plot_fades_with_the_magnitude_and_breaks_at_wraps():
    """Four rows in the order of the paper; no line runs from one cycle's end to the next one's beginning."""
    rows = phase_plot(**_phases(), mark=0.5)
    assert [axes.get_title("left") for axes in rows] == ["RightHand", "LeftHand", "RightFoot", "LeftFoot"]
    opacity = {}
    for axes in rows:
        (line,) = [artist for artist in axes.collections if isinstance(artist, LineCollection)]
        assert all(abs(segment[1, 1] - segment[0, 1]) < 0.5 for segment in line.get_segments())
        assert len(line.get_segments()) in (117, 118)
        opacity[axes.get_title("left")] = line.get_colors()[:, 3].mean()
    assert opacity["RightHand"] < opacity["LeftHand"] < opacity["LeftFoot"]


def test_phase_plot_gives_each_foot_its_own_contacts():
    """Right and left are easily swapped: contacts are (right, left), effectors left before right."""
    data = _phases() | {"contacts": np.zeros((120, 2), dtype=bool)}
    data["contacts"][30:60, 0] = True
    rows = {axes.get_title("left"): axes for axes in phase_plot(**data)}
    assert [len(rows[name].patches) for name in ("RightHand", "LeftHand", "LeftFoot")] == [0, 0, 0]
    (bar,) = rows["RightFoot"].patches
    assert (bar.get_x(), bar.get_width()) == pytest.approx((0.5, 0.5))


def test_learning_curve_shows_the_median_of_the_seeds():
    axes = learning_curve(np.arange(1.0, 4.0), {"lpn-film": np.array([[4.0, 2, 1], [5, 3, 2], [90, 4, 3]])})
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_ydata(), [5, 3, 2])
    assert line.get_color() == palette.MODELS["lpn-film"]


def test_bars_are_sorted_and_keep_their_intervals():
    """The least is at the top, and each interval lies on its own bar."""
    values = {"hold": (0.9, 0.8, 1.0), "lpn-film": (0.1, 0.05, 0.2), "ridge": (0.5, 0.4, 0.6)}
    axes = bar_with_interval(values, quantity="error", unit="ratio", reference=(0.3, "paper"))
    assert [label.get_text() for label in axes.get_yticklabels()] == ["lpn-film", "ridge", "hold"]
    assert axes.yaxis_inverted()
    assert [tuple(line.get_xdata()) for line in axes.lines[:3]] == [(0.05, 0.2), (0.4, 0.6), (0.8, 1.0)]


def test_embedding_puts_each_label_at_its_points():
    points = np.concatenate([np.zeros((3, 2)), np.full((3, 2), 5.0)])
    axes = embedding(points, ["old"] * 3 + ["proud"] * 3, method="t-SNE")
    assert {text.get_text(): tuple(text.xy) for text in axes.texts} == {"old": (0, 0), "proud": (5, 5)}
    with pytest.raises(InputError, match="1 labels for 6 points"):
        embedding(points, ["old"], method="t-SNE")


def _all_figures() -> list[Figure]:
    plots = [
        phase_plot(**_phases())[0],
        learning_curve(np.arange(3.0), {"lpn-film": np.ones((1, 3))}),
        bar_with_interval({"ridge": (0.5, 0.4, 0.6)}, quantity="error", unit="ratio"),
        embedding(np.zeros((2, 2)), ["old", "old"], method="t-SNE"),
    ]
    return [axes.figure for axes in plots]


def test_every_axis_says_what_it_shows_and_in_what_unit():
    """Names need no unit, and rows above another share its time axis."""
    for figure in _all_figures():
        across = {axes.get_xlabel() for axes in figure.axes} - {""}
        upwards = {axes.get_ylabel() for axes in figure.axes}
        assert across
        assert all(label == "predictor" or label.endswith(")") for label in across | upwards)


def test_saved_figure_is_small_described_and_the_same_twice(tmp_path: Path):
    for name in ("one.png", "two.png"):
        axes = phase_plot(**_phases())[0]
        save_figure(axes.figure, tmp_path / name, alt="Contacts of a walk: é")
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
    with Image.open(tmp_path / "one.png") as picture:
        assert picture.info["Description"] == "Contacts of a walk: é"
        assert np.asarray(picture).std() > 5
    assert (tmp_path / "one.png").stat().st_size <= LIMIT


def test_large_picture_is_reduced_to_the_limit(tmp_path: Path):
    """A picture of many shades shrinks; one that cannot shrink enough is refused and not left behind."""
    ramp = np.add.outer(np.arange(500), np.arange(600))[..., None] * [1, 2, 3] // 7 % 256
    noise = np.random.default_rng(0).integers(0, 40, ramp.shape)
    write_png(tmp_path / "ramp.png", ((ramp + noise) // 2).astype(np.uint8), alt="a ramp")
    assert (tmp_path / "ramp.png").stat().st_size <= LIMIT
    chance = np.random.default_rng(0).integers(0, 256, (900, 900, 3), dtype=np.uint8)
    with pytest.raises(InputError, match=r"chance\.png: the picture takes \d+ bytes, more than 500000"):
        write_png(tmp_path / "chance.png", chance, alt="chance")
    assert [path.name for path in tmp_path.iterdir()] == ["ramp.png"]


@pytest.mark.parametrize(("name", "alt", "reason"), [("a.png", " ", "description"), ("a.jpg", "a", r"end in \.png")])
def test_figure_without_description_or_png_name_is_refused(tmp_path: Path, name: str, alt: str, reason: str):
    with pytest.raises(InputError, match=reason):
        save_figure(Figure(), tmp_path / name, alt=alt)
    assert not list(tmp_path.iterdir())
