"""The Snakefile with a command line that only notes its calls: what is done, in which order, and not twice."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stylephase.models.zoo import PAPER_2022

# Stands for `stylephase` and for the runner of notebooks: notes the call and writes what the call promises.
_NOTING = """#!{python}
import pathlib, sys, time
words = sys.argv[1:]
notebook = words[:2] == ["-m", "stylephase.report.notebooks"]
note = "notebook " + words[3] if notebook else " ".join(words[:2] if words[0] == "data" else words[:1])
if note == "train":
    checkpoint = pathlib.Path(words[words.index("--out") + 1], "checkpoint")
    note += " resumed" if checkpoint.exists() else ""
    note += " without" if "--without" in words else ""
    checkpoint.touch()
if note == "train" and pathlib.Path("slow").exists():
    pathlib.Path("slow").unlink()
    time.sleep(60)
with open("calls", "a") as calls:
    print(note, file=calls)
if notebook:
    for folder, kind in ((words[5], "ipynb"), (words[-1], "json")):
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
        pathlib.Path(folder, words[3] + "." + kind).touch()
else:
    content = "".join(path.read_text() for path in pathlib.Path("mine").glob("*.bvh"))
    print('{{"frames_by_style": {{"Old": 3, "Very old": 4}}, "sha256": "' + content + '"}}')
"""
_AFTER_TRAINING = ["evaluate", "notebook 00_scorecard", "notebook 04_training"]
_ONE = ("models=lpn-film",)
_NOTEBOOKS = ("00_scorecard", "01_data_and_skeleton", "04_training")


@pytest.fixture
def tree(root, tmp_path) -> Path:
    """A small copy of the repository's shape, with the real Snakefile."""
    shutil.copy(root / "Snakefile", tmp_path)
    files = ["data/registry.toml", "lib/stylephase/motion/clip.py", "lib/stylephase/models/film.py"]
    for name in [*files, *(f"notebooks/{name}.py" for name in _NOTEBOOKS)]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    for name in ("stylephase", "python"):
        command = tmp_path / "bin" / name
        command.parent.mkdir(exist_ok=True)
        command.write_text(_NOTING.format(python=sys.executable))
        command.chmod(0o755)
    return tmp_path


def _start(tree: Path, *config: str) -> subprocess.Popen[str]:
    snakemake = [sys.executable, "-m", "snakemake", "--cores", "2", "--nolock", "--rerun-incomplete"]
    snakemake += ["--config", *config] if config else []
    environment = {**os.environ, "PATH": f"{tree / 'bin'}:{os.environ['PATH']}", "XDG_CACHE_HOME": str(tree / "cache")}
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    return subprocess.Popen(snakemake, cwd=tree, env=environment, start_new_session=True, **streams)


def _run(tree: Path, *config: str) -> list[str]:
    """The calls of one complete run, sorted; of one model unless `config` names others."""
    (tree / "calls").unlink(missing_ok=True)
    with _start(tree, *(config or _ONE)) as process:
        out, _ = process.communicate(timeout=200)
    assert process.returncode == 0, out
    return sorted((tree / "calls").read_text().splitlines()) if (tree / "calls").exists() else []


def test_a_second_run_redoes_only_what_changed(tree):
    others = ["notebook 01_data_and_skeleton", *_AFTER_TRAINING]
    assert _run(tree) == sorted(["data check", "vectors", "train", *others])
    assert _run(tree) == []
    (tree / "lib/stylephase/models/film.py").write_text("another")
    assert _run(tree) == sorted(["train", *others]), "a change of code must not resume the old run"


def test_a_changed_file_of_ones_own_is_noticed(tree):
    own = tree / "mine/one.bvh"
    own.parent.mkdir()
    own.write_text("a walk")
    asked = ("dataset=own:mine", *_ONE)
    assert "train" in _run(tree, *asked) and _run(tree, *asked) == []
    own.write_text("another walk")
    assert {"data check", "vectors", "train"} <= set(_run(tree, *asked))


def test_all_seven_models_are_trained_unless_told_otherwise(tree):
    (tree / "notebooks/05_test_error.py").write_text("it compares them")
    calls = _run(tree, "preset=quick")
    assert calls.count("train") == calls.count("evaluate") == len(PAPER_2022) == 7


def test_notebooks_get_the_trainings_that_they_alone_need(tree):
    """Interpolation a second model, new styles a run that never sees some of the styles."""
    for name in ("07_interpolation", "08_new_styles"):
        (tree / f"notebooks/{name}.py").write_text(name)
    calls = _run(tree)
    assert {"notebook 07_interpolation", "notebook 08_new_styles"} <= set(calls)
    runs = {path.parent.name: path.name for path in (tree / "build/runs").glob("*/training.json")}
    evaluated = {path.parent.name for path in (tree / "build/runs").glob("*/evaluation.json")}
    film, onehot, without = (f"synthetic-quick-{run}-seed0" for run in ("lpn-film", "lpn-onehot", "lpn-film-heldout"))
    assert runs.keys() >= {film, onehot, without} and evaluated >= {film, onehot} and without not in evaluated
    assert (
        calls.count("train") == len(runs) - 1
        and calls.count("train without") == 1
        and calls.count("evaluate") == len(evaluated)
    )


def test_of_a_hundred_styles_no_model_sees_those_kept_back_so_one_run_serves_both(tree):
    for name in ("05_test_error", "08_new_styles"):
        (tree / f"notebooks/{name}.py").write_text(name)
    calls = _run(tree, "dataset=lpn-rollouts", "models=lpn-film,pfnn-film")
    assert [call for call in calls if call.startswith("train")] == ["train without"] * 2


def test_an_interrupted_run_goes_on(tree):
    """Killed in the middle of the training: what came before is not repeated, and the training resumes."""
    slow = tree / "slow"
    slow.touch()
    with _start(tree, *_ONE) as process:
        while slow.exists() and process.poll() is None:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGKILL)
    assert {"data check", "vectors"} <= set((tree / "calls").read_text().splitlines())
    calls = _run(tree)
    assert {"train resumed", *_AFTER_TRAINING} <= set(calls) and not {"data check", "vectors"} & set(calls)


def test_a_dry_run_tells_of_every_seed_and_makes_nothing(tree):
    """What one tries before jobs are sent to a cluster."""
    before = sorted(path for path in tree.rglob("*") if ".snakemake" not in path.parts and "cache" not in path.parts)
    command = [
        sys.executable,
        "-m",
        "snakemake",
        "--dry-run",
        "--cores",
        "2",
        "--nolock",
        "--config",
        "seeds=0,1",
        *_ONE,
    ]
    environment = {**os.environ, "PATH": f"{tree / 'bin'}:{os.environ['PATH']}", "XDG_CACHE_HOME": str(tree / "cache")}
    done = subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stdout + done.stderr
    told = done.stdout + done.stderr
    assert "lpn-film-seed0" in told and "lpn-film-seed1" in told
    after = sorted(path for path in tree.rglob("*") if ".snakemake" not in path.parts and "cache" not in path.parts)
    assert after == before
