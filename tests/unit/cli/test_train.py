"""The command `stylephase train`: what it makes, what it refuses in one line, and that it overwrites no run."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
import tiny_training as tiny
from refusals import refused

from stylephase.cli import app, train
from stylephase.models.bundle import load_bundle
from stylephase.training.presets import PRESETS

Call = Callable[..., tuple[int, str, str]]


@pytest.fixture
def data(monkeypatch) -> dict:
    """What the tiny data set is made with; a test may change it."""
    options = {}

    def catalogue(name, styles):
        return replace(
            tiny.TinyStore(*(styles or ())).catalogue, dataset=replace(tiny.TinyStore().catalogue.dataset, name=name)
        )

    def store(chosen, phases):
        made = tiny.TinyStore(**options)
        made.catalogue = chosen
        return made

    monkeypatch.setattr(train, "load_catalogue", catalogue)
    monkeypatch.setattr(train, "VectorStore", store)
    monkeypatch.setitem(PRESETS, "quick", tiny.PRESET)
    monkeypatch.setitem(PRESETS, "cpu", replace(tiny.PRESET, steps=30))
    return options


@pytest.fixture
def call(capsys) -> Call:
    """Runs `stylephase train`; options given by name take the place of those of an ordinary run."""

    def run(out: Path, *flags: str, **options: str) -> tuple[int, str, str]:
        words = {"model": "lpn-film", "data": "tiny", "preset": "quick"} | options
        with pytest.raises(SystemExit) as end:
            app.main(
                [
                    "train",
                    "--out",
                    str(out),
                    *flags,
                    *(w for k, v in words.items() for w in (f"--{k.replace('_', '-')}", v)),
                ]
            )
        return int(end.value.code or 0), *capsys.readouterr()

    return run


def kept(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in out.iterdir()}


@pytest.fixture
def finished(data, call, tmp_path) -> Path:
    """A folder with a finished run."""
    out = tmp_path / "finished"
    assert call(out)[0] == 0
    return out


@pytest.fixture
def interrupted(data, call, tmp_path, monkeypatch) -> Path:
    """A folder with a run that was interrupted at step 14, after the checkpoint of step 8."""
    out, learn = tmp_path / "interrupted", train.Trainer.round

    def tire(run: train.Trainer) -> dict[str, float]:
        if run.step == 14:
            raise KeyboardInterrupt
        return learn(run)

    with monkeypatch.context() as patched:
        patched.setattr(train.Trainer, "round", tire)
        assert call(out)[0] == 130
    assert json.loads((out / "state.json").read_text())["step"] == 8
    return out


def test_a_run_leaves_a_model_and_tells_of_it(data, call, tmp_path):
    status, out, _ = call(tmp_path / "run", "--json", seed="5", styles="Sway")
    told = json.loads(out.splitlines()[-1])
    bundle = load_bundle(tmp_path / "run")
    assert status == 0 and told["out"] == str(tmp_path / "run")
    assert told["about"] == bundle.about and told["about"]["seed"] == 5 and bundle.styles == ("Sway",)
    assert told["last"] == json.loads((tmp_path / "run/log.json").read_text())[-1]


def test_another_input_dropout_is_another_run(finished, call, tmp_path):
    out = tmp_path / "run"
    assert call(out, input_dropout="0.45")[0] == 0
    bundle = load_bundle(out)
    assert bundle.settings.input_rate == 0.45 and bundle.about["preset"] == "quick with input dropout 0.45"
    assert refused(call(finished, "--resume", input_dropout="0.45")).endswith("of which these differ: preset")


def test_the_text_gives_folder_steps_and_errors(finished, call):
    _, out, _ = call(finished, "--resume")
    assert out.startswith(f"{finished}: 24 steps in ") and "training error" in out and "validation error" in out


def test_without_validation_frames_there_is_no_validation_error(data, call, tmp_path):
    data["validation"] = False
    status, out, _ = call(tmp_path / "run")
    assert status == 0 and "training error" in out and "validation error" not in out


# Runs that are there already


@pytest.mark.parametrize(
    ("kind", "says"), [("finished", "holds a finished run"), ("interrupted", "holds an interrupted run")]
)
def test_a_run_is_not_overwritten(request, call, kind, says):
    out = request.getfixturevalue(kind)
    before = kept(out)
    line = refused(call(out))
    assert line.startswith(f"{out}: {says}") and "--resume" in line and "another folder" in line
    assert kept(out) == before


@pytest.mark.parametrize("kind", ["finished", "interrupted"])
@pytest.mark.parametrize(
    ("change", "differs"),
    [
        ({"seed": "1"}, "seed"),
        ({"preset": "cpu"}, "preset"),
        ({"styles": "Plain"}, "styles"),
        ({"data": "other"}, "data"),
    ],
)
def test_resuming_another_run_is_refused_and_loses_nothing(request, call, kind, change, differs):
    out = request.getfixturevalue(kind)
    before = kept(out)
    line = refused(call(out, "--resume", **change))
    assert line.startswith(f"{out}: holds another run, of which these differ: {differs}")
    assert kept(out) == before


def test_resuming_with_other_vectors_is_refused(interrupted, data, call):
    """The same data set by name, of other files or computed otherwise."""
    data["version"] = "2"
    assert refused(call(interrupted, "--resume")).endswith("these differ: vectors")


def test_an_interrupted_run_goes_on(interrupted, finished, call):
    assert call(interrupted, "--resume")[0] == 0
    one, other = (tiny.weights(load_bundle(out)) for out in (interrupted, finished))
    assert tiny.same(one, other)


def test_a_finished_run_is_left_as_it_is(finished, call, monkeypatch):
    monkeypatch.setattr(train, "Trainer", None)
    before = kept(finished)
    status, out, _ = call(finished, "--resume", "--json")
    told = json.loads(out.splitlines()[-1])
    assert status == 0 and told["about"]["steps"] == told["last"]["step"] == 24
    assert kept(finished) == before


def test_a_run_killed_after_its_model_was_written_is_finished(finished, interrupted, call):
    """The checkpoint is removed after the model is written; a kill between the two leaves both."""
    before = kept(finished)
    for path in interrupted.iterdir():
        if "checkpoint" in path.name or path.name == "state.json":
            path.rename(finished / path.name)
    assert call(finished, "--resume")[0] == 0
    assert kept(finished) == before


def test_resume_starts_where_there_is_nothing_to_go_on_with(data, call, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run/notes.txt").write_text("mine")
    assert call(tmp_path / "run", "--resume")[0] == 0
    assert (tmp_path / "run/notes.txt").read_text() == "mine"


def test_weights_that_are_damaged_are_named_and_kept(finished, call):
    path = finished / "weights.safetensors"
    path.write_bytes(path.read_bytes()[:-10])
    before = kept(finished)
    assert refused(call(finished, "--resume")).startswith(f"{path}: not a whole safetensors file")
    assert kept(finished) == before


# Bad input


def test_an_unknown_model_is_answered_with_those_there_are(data, call, tmp_path):
    line = refused(call(tmp_path / "run", model="lpn"))
    assert line == (
        "no model 'lpn'; there are pfnn-onehot, lpn-onehot, pfnn-resad, lpn-resad, pfnn-film, mann-film, lpn-film, "
        "pfnn, pfnn-full, pfnn-diag, pfnn-cp, cp-pfnn"
    )


def test_unknown_preset_data_set_style_and_seed_are_one_line_and_leave_no_folder(call, tmp_path, make_own):
    out = tmp_path / "run"
    assert refused(call(out, preset="fast")) == "no preset 'fast'; there are quick, cpu, paper"
    assert refused(call(out, data="nowhere")).startswith("no data set 'nowhere'; there are ")
    assert refused(call(out, data=make_own, styles="Old,Swagger")) == "no style 'Swagger'; there are Old"
    assert refused(call(out, data=make_own, styles="")) == "no style ''; there are Old"
    assert "--seed" in refused(call(out, seed="-1"))
    assert not out.exists()


@pytest.fixture
def make_own(tmp_path) -> str:
    """A data set of the user's own with one style; nothing reads its file here."""
    (tmp_path / "own/Old").mkdir(parents=True)
    (tmp_path / "own/Old/walk.bvh").write_text("HIERARCHY")
    return f"own:{tmp_path / 'own'}"


def test_a_folder_that_is_a_file_is_one_line(data, call, tmp_path):
    (tmp_path / "run").write_text("in the way")
    assert refused(call(tmp_path / "run")).startswith(str(tmp_path / "run"))
    assert (tmp_path / "run").read_text() == "in the way"


def test_styles_may_be_left_out(call, data, tmp_path):
    assert call(tmp_path / "one", without="Plain")[0] == 0
    assert load_bundle(tmp_path / "one").styles == ("Sway",)


@pytest.mark.parametrize(
    ("left_out", "reason"), [("Plain,Sway", "--without leaves no style to learn"), ("Swey", "no style 'Swey'; did you")]
)
def test_leaving_out_all_styles_or_one_that_is_not_there_is_refused(call, data, tmp_path, left_out, reason):
    assert refused(call(tmp_path / "none", without=left_out)).startswith(reason)
    assert not (tmp_path / "none").exists()
