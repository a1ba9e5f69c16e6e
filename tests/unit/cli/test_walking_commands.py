"""The commands `rollout`, `evaluate` and `vectors`: what they write and say, and what they refuse in one line."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tiny_walker as tiny
from refusals import refused

from stylephase.cli import app, evaluate, rollout
from stylephase.evaluation import report, rollouts
from stylephase.files import read_json, write_json
from stylephase.models.bundle import save_bundle
from stylephase.motion.bvh import read_bvh, write_bvh
from stylephase.motion.clip import forward_kinematics
from stylephase.runtime import calibration, speeds

Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def call(capsys) -> Call:
    """Runs the command line; gives exit status, standard output and standard error."""

    def run(*words: str | Path) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            app.main([str(word) for word in words])
        return int(end.value.code or 0), *capsys.readouterr()

    return run


def told(result: tuple[int, str, str]) -> dict:
    """The JSON object that stands last on standard output."""
    status, out, err = result
    assert status == 0, err
    return json.loads(out.splitlines()[-1])


@pytest.fixture(scope="module")
def weights(tmp_path_factory) -> Path:
    """A folder of weights that were never trained, of four styles."""
    folder = tmp_path_factory.mktemp("weights")
    save_bundle(folder, tiny.bundle())
    return folder


@pytest.fixture(autouse=True)
def hasty(monkeypatch) -> None:
    """Calibration, turns and stops of a few frames."""
    monkeypatch.setattr(calibration, "_TRIAL_SECONDS", 1.1)
    monkeypatch.setattr(calibration, "_ROUNDS", 1)
    monkeypatch.setattr(speeds, "_SECONDS", 1.2)
    monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.1)
    monkeypatch.setattr(rollouts, "_TRIAL_SECONDS", 1.0)
    monkeypatch.setattr(rollouts, "_CUE_SECONDS", 0.2)
    monkeypatch.setattr(report, "_SHORTEST", 3.3)


class TestRollout:
    @pytest.fixture
    def roll(self, call, weights, tmp_path) -> Call:
        """Runs `stylephase rollout` into the test's folder; options given by name take the place of ordinary ones."""

        def run(*flags: str, out: str = "walk.bvh", **options: str | Path) -> tuple[int, str, str]:
            given = {"weights": weights, "style": "Old", "seconds": "0.5"} | options
            words = [word for name, value in given.items() for word in (f"--{name}", value)]
            return call("rollout", "--out", tmp_path / out, *words, *flags)

        return run

    def test_it_goes_where_a_recorded_walk_went(self, roll, tmp_path):
        walked = tiny.take(turn=0.3).clip
        write_bvh(tmp_path / "walked.bvh", walked)
        found = told(roll("--json", **{"way-of": tmp_path / "walked.bvh", "seconds": "2"}))
        assert found["frames"] == 120 and found["way"]["arrived"] is None
        assert abs(found["asked"] - tiny.SPEED) < 0.1 and found["way"]["off"] >= 0
        # The walker turns by so many radians a second, and sways by a few degrees.
        assert abs(found["asked_way"]["turn"] - np.degrees(0.3)) < 4 and abs(found["asked_way"]["strafe"]) < 5

    def test_a_recorded_walk_says_how_fast_and_where_to_by_itself(self, roll, tmp_path):
        write_bvh(tmp_path / "walked.bvh", tiny.take().clip)
        line = refused(roll(**{"way-of": tmp_path / "walked.bvh", "speed": "2"}))
        assert line.startswith("--way-of says where to go") and not (tmp_path / "walk.bvh").exists()

    def test_of_a_recorded_walk_only_its_time_is_judged(self, roll, tmp_path, monkeypatch):
        """Who stands after it is not too slow."""
        write_bvh(tmp_path / "walked.bvh", tiny.take(seconds=3.0).clip.frames(0, 90))
        monkeypatch.setattr(rollout, "_BESIDE", 1e6)
        runs = []
        monkeypatch.setattr(rollout, "speed_of", lambda root: runs.append(len(root)) or 1.0)
        told(roll("--json", **{"way-of": tmp_path / "walked.bvh", "seconds": "2"}))
        assert set(runs) == {90}

    @pytest.mark.parametrize("frames", [1, 100])
    def test_a_recorded_walk_that_goes_nowhere_is_one_line_with_the_file(self, roll, tmp_path, frames):
        clip = tiny.take().clip
        places, turns = (part[:1].repeat(frames, 0) for part in (clip.root_positions, clip.rotations))
        still = replace(clip, root_positions=places, rotations=turns)
        write_bvh(tmp_path / "still.bvh", still)
        line = refused(roll(**{"way-of": tmp_path / "still.bvh", "seconds": "2"}))
        assert "still.bvh" in line and ("a second or more" if frames == 1 else "goes nowhere") in line

    def test_it_writes_a_walk_that_any_program_reads(self, roll, tmp_path):
        found = told(roll("--json", seconds="1.5"))
        clip = read_bvh(tmp_path / "walk.bvh", metres_per_unit=0.01)
        assert found["out"] == str(tmp_path / "walk.bvh") and len(clip) == found["frames"] == 90
        assert (found["style"], found["fps"], found["licence"]) == ({"Old": 1.0}, 60.0, "none")
        assert found["gain"] > 0 and found["speed"] >= 0
        assert clip.skeleton.names == tiny.BODY.skeleton.names
        np.testing.assert_allclose(clip.skeleton.offsets, tiny.BODY.skeleton.offsets, atol=1e-6)
        assert [path.name for path in tmp_path.iterdir()] == ["walk.bvh"]

    def test_arrays_are_those_of_the_bvh(self, roll, tmp_path):
        assert roll()[0] == 0 and roll(out="walk.npz")[0] == 0
        pose = forward_kinematics(read_bvh(tmp_path / "walk.bvh", metres_per_unit=0.01))
        with np.load(tmp_path / "walk.npz", allow_pickle=False) as found:
            np.testing.assert_allclose(found["positions"], pose.positions, atol=1e-4)
            assert found["contacts"].shape == (30, 2) and found["contacts"].dtype == bool

    def test_the_text_gives_file_frames_style_and_speed(self, roll, tmp_path):
        status, out, _ = roll(style="set1-not-old:3,Plain:1", speed="1.2")
        assert status == 0 and out.startswith(f"{tmp_path / 'walk.bvh'}: 30 frames of set1-not-old:3,Plain:1 at ")
        assert "asked: 1.20" in out

    @pytest.mark.parametrize("flags", [(), ("--raw",)])
    def test_the_bar_knows_its_end_and_says_the_try(self, roll, monkeypatch, flags):
        """At a speed that nobody untrained goes at, all is tried."""
        bars, most = [], 3 - len(flags)

        class Bar(rollout.tqdm):
            def set_description_str(self, desc=None, refresh=True):
                bars.append((desc, self.n, self.total))

        monkeypatch.setattr(rollout, "tqdm", Bar)
        assert roll(*flags, speed="9.5")[0] == 0
        assert bars == [(f"walk.bvh, try {k} of at most {most}", 0, 30) for k in range(1, most + 1)]

    def test_one_call_twice_gives_one_file(self, roll, tmp_path):
        roll(out="one.bvh")
        roll(out="two.bvh")
        assert (tmp_path / "one.bvh").read_bytes() == (tmp_path / "two.bvh").read_bytes()

    def test_turning_strafing_and_a_path_reach_the_controller(self, roll, tmp_path, monkeypatch):
        """In degrees on the command line, in radians inside; at the calibrated gain."""
        plans = []

        def note(plan, wanted):
            plans.append(plan.plan)
            raise KeyboardInterrupt

        monkeypatch.setattr(rollout, "at_pace", note)
        (tmp_path / "way.txt").write_text("0 0\n-3 0\n")
        assert roll(turn="-90", strafe="45")[0] == 130 and roll(path=tmp_path / "way.txt")[0] == 130
        steady, follow = plans
        assert (steady.turn, steady.strafe) == pytest.approx((-np.pi / 2, np.pi / 4))
        np.testing.assert_array_equal(follow.points, [[0, 0], [-3, 0]])
        assert (steady.speeds > 0).all() and follow.speeds == steady.speeds
        assert [path.name for path in tmp_path.iterdir()] == ["way.txt"]

    def test_the_way_is_told_beside_what_was_asked_for(self, roll, tmp_path):
        """Untrained, it goes anywhere; without a wish for a way nothing is told of it."""
        (tmp_path / "way.txt").write_text("0 0\n0 30\n")
        asked = {"strafe": ("90", "° aside (asked: 90°)"), "turn": ("-45", "°/s (asked: -45°/s)")}
        asked |= {"path": (tmp_path / "way.txt", " m off the path, whose end was not reached")}
        for name, (value, says) in asked.items():
            status, out, _ = roll(seconds="2.5", **{name: value})
            assert status == 0 and says in out and out.count("\n") == 1
        found = told(roll("--json", seconds="2.5", strafe="90"))
        assert found["asked_way"] == {"strafe": 90.0, "turn": 0.0} and found["way"]["off"] is None
        assert np.isfinite([found["way"]["strafe"], found["way"]["turn"]]).all()
        assert "aside" not in roll()[1]

    def test_a_movie_shows_the_clip(self, roll, tmp_path, monkeypatch):
        """Drawing is tested where it is done; here, what is handed to it."""
        drawn = []

        def draw(path: Path, motion, *, progress: bool) -> int:
            drawn.append(motion)
            path.write_bytes(b"movie")
            return 1

        monkeypatch.setattr("stylephase.report.render.movie", draw)
        assert roll(out="walk.mp4")[0] == 0 and (tmp_path / "walk.mp4").exists()
        (motion,) = drawn
        assert motion.positions.shape == (30, len(tiny.BODY.skeleton), 3) and motion.label == "Old"

    @pytest.mark.parametrize(
        ("option", "says"),
        [
            ({"style": "Plane"}, "no style 'Plane' in these weights; did you mean Plain?"),
            ({"style": "Old:0.5,Odd:0.5"}, "no style 'Odd' in these weights; did you mean Old?"),
            ({"style": "Old:-1,Plain:2"}, "style weights should be numbers not below zero, with one above"),
            ({"style": "Old:nan"}, "style weights should be numbers not below zero, with one above"),
            ({"style": "Old:0"}, "style weights should be numbers not below zero, with one above"),
            ({"style": "Old:x"}, "style 'Old:x': expected NAME:weight with a number"),
            ({"style": ""}, "style '': a name is missing or named twice"),
            ({"speed": "0"}, "--speed is 0; expected above 0 and at most 10 m/s"),
            ({"speed": "-1"}, "--speed is -1; expected above 0 and at most 10 m/s"),
            ({"speed": "nan"}, "--speed is nan; expected above 0 and at most 10 m/s"),
            ({"speed": "100"}, "--speed is 100; expected above 0 and at most 10 m/s"),
            ({"seconds": "0"}, "--seconds is 0; expected 0.1 to 3600"),
            ({"seconds": "nan"}, "--seconds is nan; expected 0.1 to 3600"),
            ({"seconds": "inf"}, "--seconds is inf; expected 0.1 to 3600"),
            ({"turn": "inf"}, "--turn and --strafe should be numbers of degrees, at most 720 either way"),
            ({"strafe": "nan"}, "--turn and --strafe should be numbers of degrees, at most 720 either way"),
        ],
    )
    def test_bad_values_are_one_line_and_leave_nothing(self, roll, tmp_path, option, says):
        assert refused(roll(**option)) == says
        assert list(tmp_path.iterdir()) == []

    def test_the_movies_are_those_that_can_be_made(self):
        """The command does not load pyvista to know them."""
        from stylephase.report.render import movies

        assert tuple(movies._WRITERS) == rollout.MOVIES

    @pytest.mark.parametrize("name", ["walk.fbx", "walk", "walk.BVHX"])
    def test_another_suffix_is_refused_before_anything_is_done(self, roll, tmp_path, name):
        line = refused(roll(out=name, weights="nowhere"))
        assert line == f"{tmp_path / name}: expected a name that ends in .bvh, .npz, .mp4, .gif"

    def test_missing_and_damaged_weights_are_named(self, roll, tmp_path):
        assert refused(roll(weights=tmp_path / "none")) == f"{tmp_path / 'none' / 'model.json'}: no such file"
        (tmp_path / "bad").mkdir()
        (tmp_path / "bad/model.json").write_text("{}")
        assert refused(roll(weights=tmp_path / "bad")).startswith(str(tmp_path / "bad"))
        assert not (tmp_path / "walk.bvh").exists()

    def test_a_path_that_is_none_is_named_with_its_line(self, roll, tmp_path):
        way = tmp_path / "way.txt"
        assert refused(roll(path=way)) == f"{way}: no such text file"
        way.write_text("0 0\n1\n")
        assert refused(roll(path=way)) == f"{way}:2: expected two finite numbers, found '1'"
        way.write_text("0 0\n1 1\n")
        line = "--path says where to go; it goes with neither --turn nor --strafe"
        assert refused(roll(path=way, turn="10")) == refused(roll(path=way, strafe="10")) == line
        assert [path.name for path in tmp_path.iterdir()] == ["way.txt"]

    @pytest.mark.parametrize("suffix", ["bvh", "npz"])
    def test_a_folder_that_cannot_be_made_is_one_line(self, roll, tmp_path, suffix):
        (tmp_path / "in").write_text("the way")
        assert refused(roll(out=f"in/walk.{suffix}")).startswith(f"{tmp_path / 'in' / f'walk.{suffix}'}: cannot write")
        assert [path.name for path in tmp_path.iterdir()] == ["in"]

    def test_a_motion_that_leaves_the_finite_numbers_is_told_and_not_written(self, roll, tmp_path):
        bundle = tiny.bundle("Old")
        for parameter in bundle.network.synthesis.parameters():
            parameter.data.mul_(1e30)
        save_bundle(tmp_path / "wild", bundle)
        assert refused(roll(weights=tmp_path / "wild")).endswith("style Old does not stay finite at any speed")
        assert not (tmp_path / "walk.bvh").exists()

    def test_holdens_network_walks_on_the_skeleton_of_its_takes(self, roll, cache, mirror, tmp_path, monkeypatch):
        if not {"pfnn-release.npz", "pfnn-locomotion.tar.xz"} <= {path.name for path in mirror.glob("*")}:
            pytest.skip("needs Holden's release and takes: pfnn-*.* are not in the mirror")
        monkeypatch.setenv("STYLEPHASE_MIRROR", str(mirror))
        found = told(roll("--json", weights="pfnn-release", style="walk", speed="1.2", seconds="3"))
        clip = read_bvh(tmp_path / "walk.bvh", metres_per_unit=0.01)
        assert found["style"] == {"walk": 1.0} and 0.8 < found["speed"] < 1.4 and found["near"]
        assert "LeftToeBase" in clip.skeleton.names and len(clip) == 180
        status, _, err = roll(weights="pfnn-release", style="fly")
        assert status == 2 and "no gait 'fly' in pfnn-release; there are stand, walk, jog" in err

    def test_without_the_release_at_hand_its_word_is_one_line(self, roll, cache, tmp_path, monkeypatch):
        monkeypatch.delenv("STYLEPHASE_MIRROR", raising=False)
        line = refused(roll(weights="release"))
        assert line.startswith("lpn-release cannot be downloaded: put local-phases-release.tar.xz into a folder")
        assert "STYLEPHASE_MIRROR" in line and rollout.RELEASE == "release"


class TestEvaluate:
    @pytest.fixture(autouse=True)
    def data(self, monkeypatch) -> None:
        """Data of the four styles, which differ by their names only."""
        styles = [tiny.style_vectors("Plain") for _ in tiny.STYLES]
        named = [type(s)(name, *list(vars(s).values())[1:]) for name, s in zip(tiny.STYLES, styles, strict=True)]
        store = tiny.Store(*named)

        def catalogue(name: str, styles: Sequence[str]):
            assert name == "made" and tuple(styles) == tiny.STYLES
            return store.catalogue

        def open_store(catalogue, phases: str):
            assert catalogue is store.catalogue and phases == "adaptive"
            return store

        monkeypatch.setattr(evaluate, "load_catalogue", catalogue)
        monkeypatch.setattr(evaluate, "VectorStore", open_store)

    def test_it_prints_errors_and_rollouts(self, call, weights):
        found = told(call("evaluate", "--weights", weights, "--data", "made", "--seconds", "3.3", "--json"))
        assert found["weights"] == str(weights) and found["data"] == "made" and found["about"]["phases"] == "adaptive"
        assert set(found["errors"]) == {walk["style"] for walk in found["rollouts"]["walks"]} == set(tiny.STYLES)
        assert set(found["errors"]["Old"]) >= {"network", "hold", "mean", "ridge", "untrained", "wrong code"}
        assert all(error["bll"] >= 0 for error in found["groups"]["all"].values())

    def test_the_text_is_a_table(self, call, weights):
        status, out, _ = call("evaluate", "--weights", weights, "--data", "made", "--seconds", "0")
        assert status == 0 and "rollout" not in out
        assert [line.split()[0] for line in out.splitlines()[2:]][:3] == ["network", "dropout", "wrong"]

    @pytest.mark.parametrize("seconds", ["1", "-3", "nan", "inf"])
    def test_rollouts_of_no_sensible_length_are_one_line(self, call, weights, seconds):
        line = refused(call("evaluate", "--weights", weights, "--data", "made", "--seconds", seconds))
        assert line.startswith("rollouts of ") and "expected 0 for none" in line

    def test_missing_weights_are_named(self, call, tmp_path):
        line = refused(call("evaluate", "--weights", tmp_path, "--data", "made"))
        assert line == f"{tmp_path / 'model.json'}: no such file"

    def test_weights_that_do_not_say_their_phases_are_named(self, call, tmp_path):
        save_bundle(tmp_path, tiny.bundle())
        described = read_json(tmp_path / "model.json")
        del described["about"]["phases"]
        write_json(tmp_path / "model.json", described)
        line = refused(call("evaluate", "--weights", tmp_path, "--data", "made"))
        assert line == f"{tmp_path}: the weights do not say which phases they were trained with"


def test_evaluate_refuses_data_without_the_weights_styles(call, weights, tmp_path):
    (tmp_path / "own/Old").mkdir(parents=True)
    (tmp_path / "own/Old/walk.bvh").write_text("HIERARCHY")
    line = refused(call("evaluate", "--weights", weights, "--data", f"own:{tmp_path / 'own'}"))
    assert line == "no style 'Plain'; there are Old"
    assert refused(call("evaluate", "--weights", weights, "--data", "nowhere")).startswith("no data set 'nowhere'")


class TestVectors:
    @pytest.fixture
    def own(self, tmp_path) -> str:
        """A data set of two styles, one short file each."""
        clip = tiny.take().clip
        for style, start in (("Plain", 0), ("Again", 60)):
            write_bvh(tmp_path / f"own/{style}/walk.bvh", clip.frames(start, start + 90))
        return f"own:{tmp_path / 'own'}"

    def test_they_are_computed_once_and_counted(self, call, own, cache):
        found = told(call("vectors", "--data", own, "--json"))
        assert found["rows"] == {"Again": 89, "Plain": 89} and Path(found["folder"]).is_relative_to(cache)
        assert sorted(path.name for path in Path(found["folder"]).glob("*.npz")) == ["Again.npz", "Plain.npz"]

    def test_some_styles_alone(self, call, own, cache):
        status, out, _ = call("vectors", "--data", own, "--styles", "Again")
        assert status == 0 and out.startswith("89 rows in ")

    @pytest.mark.parametrize(
        ("flags", "says"),
        [
            (("--styles", "Plane"), "no style 'Plane'; did you mean Plain?"),
            (("--styles", ""), "no style ''; there are Again, Plain"),
            (("--phases", "odd"), "odd"),
        ],
    )
    def test_unknown_styles_and_phases_are_one_line(self, call, own, cache, flags, says):
        assert says in refused(call("vectors", "--data", own, *flags))
        assert not (cache / "vectors").exists()

    def test_a_file_that_is_cut_off_is_named(self, call, own, cache, tmp_path):
        path = tmp_path / "own/Again/walk.bvh"
        path.write_text(path.read_text()[:-500])
        assert refused(call("vectors", "--data", own)).startswith(f"{path}:")
