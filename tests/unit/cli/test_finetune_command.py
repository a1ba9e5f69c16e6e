"""The command `finetune`: what it writes and says, and what it refuses in one line with nothing written."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import tiny_walker as tiny
from refusals import refused

from stylephase.cli import app
from stylephase.models.bundle import load_bundle, load_tensors, save_bundle
from stylephase.motion.bvh import write_bvh

Call = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def given(tmp_path_factory) -> Path:
    """A folder with weights that know four styles, and two takes of another."""
    folder = tmp_path_factory.mktemp("given")
    save_bundle(folder / "base", tiny.bundle())
    for number, turn in enumerate((0.0, 0.3)):
        write_bvh(folder / f"take{number}.bvh", tiny.take("Sleepwalk", turn=turn).clip)
    return folder


@pytest.fixture
def call(capsys, given, tmp_path) -> Call:
    """Runs `stylephase finetune` on one take, with options by name in place of ordinary ones and words after them."""

    def run(*words: str | Path, **options: str | Path) -> tuple[int, str, str]:
        ordinary = {"base": given / "base", "style": "Sleepwalk", "out": tmp_path / "new", "steps": "3"}
        flags = [str(word) for name, value in (ordinary | options).items() for word in (f"--{name}", value)]
        with pytest.raises(SystemExit) as end:
            app.main(["finetune", *flags, "--bvh", *map(str, words or [given / "take0.bvh"])])
        return int(end.value.code or 0), *capsys.readouterr()

    return run


def test_it_writes_weights_that_know_one_style_more(call, given, tmp_path):
    status, out, err = call(given / "take0.bvh", given / "take1.bvh", "--json")
    assert status == 0, err
    told, new = json.loads(out.splitlines()[-1]), load_bundle(tmp_path / "new")
    assert new.styles == (*tiny.STYLES, "Sleepwalk") == tuple(told["styles"])
    assert (told["files"], told["steps"], told["part"]) == (2, 3, "test")
    assert told["frames"] == sum(len(tiny.take("Sleepwalk", turn=turn).clip) - 1 for turn in (0.0, 0.3))
    assert np.isfinite([told[when][kind] for when in ("before", "after") for kind in ("mse", "bll")]).all()
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == [
        "log.json",
        "model.json",
        "weights.safetensors",
    ]
    learned = {"style": "Sleepwalk", "frames": told["frames"], "files": 2, "steps": 3, "seed": 0}
    assert new.about == tiny.bundle().about | {"fine_tuned": [learned]}


def test_one_call_twice_gives_the_same_weights(call, tmp_path):
    for name in ("one", "two"):
        assert call(out=tmp_path / name)[0] == 0
    files = [(tmp_path / name / "weights.safetensors").read_bytes() for name in ("one", "two")]
    assert files[0] == files[1]


def test_what_the_weights_knew_is_kept_to_the_last_bit(call, given, tmp_path):
    assert call()[0] == 0
    before, after = (load_tensors(folder / "weights.safetensors") for folder in (given / "base", tmp_path / "new"))
    kept = {name for name in before if not name.startswith("network.generator.")}
    assert all(before[name].equal(after[name]) for name in kept) and "network.synthesis.layers.0.weight" in kept


def test_the_text_gives_the_errors_before_and_after(call, tmp_path):
    _, out, _ = call()
    assert out.startswith(f"{tmp_path / 'new'}: Sleepwalk learned from 479 frames") and " before, " in out


class TestRefusals:
    @pytest.fixture(autouse=True)
    def nothing_written(self, tmp_path):
        yield
        assert not (tmp_path / "new").exists()

    @pytest.mark.parametrize("name", ["", "a,b", "a:1"])
    def test_names_that_a_mixture_could_not_hold(self, call, name):
        assert refused(call(style=name)) == f"--style is {name!r}; expected a name without commas and colons"

    def test_a_style_that_is_known(self, call):
        assert refused(call(style="Old")) == "these weights know the style 'Old' already; choose another name"

    def test_a_folder_that_holds_no_weights(self, call, tmp_path):
        assert refused(call(base=tmp_path)).endswith("model.json: no such file")

    def test_a_file_that_is_none(self, call, tmp_path):
        assert str(tmp_path / "none.bvh") in refused(call(tmp_path / "none.bvh"))

    def test_a_short_take(self, call, tmp_path):
        write_bvh(tmp_path / "short.bvh", tiny.take("Sleepwalk").clip.frames(0, 50))
        assert refused(call(tmp_path / "short.bvh")).startswith(f"{tmp_path / 'short.bvh'}: lasts 50 frames")


def test_a_folder_with_weights_is_left_alone(call, given):
    before = {path.name: path.read_bytes() for path in (given / "base").iterdir()}
    assert "holds trained weights; choose another folder" in refused(call(out=given / "base"))
    assert before == {path.name: path.read_bytes() for path in (given / "base").iterdir()}
