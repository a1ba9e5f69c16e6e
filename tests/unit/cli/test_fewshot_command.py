"""The command `fewshot`: what it writes and says, and what it refuses in one line with nothing written."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tiny_adapters as tiny
import tiny_walker
from refusals import refused

from stylephase.cli import app
from stylephase.models.bundle import load_bundle, load_tensors, save_bundle
from stylephase.motion.bvh import write_bvh
from stylephase.motion.synthetic import find_style, steady, walk


@pytest.fixture(scope="module")
def given(tmp_path_factory) -> Path:
    """A folder with weights that know two styles, and clips: a walk, one cycle of it, half a cycle, too little."""
    folder = tmp_path_factory.mktemp("given")
    save_bundle(folder / "base", tiny.base())
    clip = tiny_walker.take("StoopedOver").clip
    for name, frames in {"walk": 300, "one": 140, "half": 75, "short": 60}.items():
        write_bvh(folder / f"{name}.bvh", clip.frames(0, frames))
    return folder


@pytest.fixture
def call(capsys, given, tmp_path):
    """Runs `stylephase fewshot` on a clip, with options by name in place of ordinary ones and words after them."""

    def run(clip: str | Path = "walk", *words: str, **options: str | Path) -> tuple[int, str, str]:
        path = clip if isinstance(clip, Path) else given / f"{clip}.bvh"
        ordinary = {"weights": given / "base", "style": "New", "out": tmp_path / "new", "steps": "3", "clip": path}
        flags = [str(word) for name, value in (ordinary | options).items() for word in (f"--{name}", value)]
        with pytest.raises(SystemExit) as end:
            app.main(["fewshot", *flags, *words])
        return int(end.value.code or 0), *capsys.readouterr()

    return run


def test_it_writes_weights_that_know_one_style_more(call, given, tmp_path):
    status, out, err = call("walk", "--json", "--asymmetric", factors="4", dropout="0.3")
    assert status == 0, err
    told, new = json.loads(out.splitlines()[-1]), load_bundle(tmp_path / "new")
    assert new.styles == (*tiny.STYLES, "New") == tuple(told["styles"]) and new.settings.adapters[-1] == "cp:4"
    assert told["cycles"] >= 2 and 100 < told["frames"] < 300 and not told["symmetric"]
    learned = {key: told[key] for key in ("style", "frames", "cycles", "symmetric", "adapter", "dropout", "factors")}
    assert new.about["few_shot"] == [learned | {"steps": 3, "seed": 0}]
    before, after = (load_tensors(folder / "weights.safetensors") for folder in (given / "base", tmp_path / "new"))
    assert all(before[name].equal(after[name]) for name in before if not name.startswith("code."))


def test_the_text_tells_frames_cycles_and_seconds(call):
    status, out, err = call()
    assert status == 0 and "New learned from" in out and "whole cycles of 5.0 s of motion" in out and not err


def test_a_single_cycle_is_learned_with_a_warning(call):
    status, _, err = call("one")
    assert status == 0 and "a single cycle of walking; turns and other speeds will come out worse" in err


@pytest.mark.parametrize(("gait", "forward", "told"), [("BW", -1.0, "walks backwards"), ("FR", 3.2, "runs ahead")])
def test_what_is_no_walk_ahead_is_learned_with_a_warning(call, tmp_path, gait, forward, told):
    clip, _ = walk(find_style("Plain"), gait, plan=steady(5.0, forward=forward))
    write_bvh(tmp_path / "other.bvh", clip)
    status, _, err = call(tmp_path / "other.bvh")
    assert status == 0 and f"who {told} in it teaches no walk; expected a clip that walks ahead" in err


class TestRefusals:
    @pytest.fixture(autouse=True)
    def nothing_written(self, tmp_path):
        yield
        assert not (tmp_path / "new").exists()

    def test_a_clip_without_a_cycle(self, call):
        assert refused(call("half")).endswith("half.bvh: no walking cycle in it: neither foot comes down twice")

    def test_a_clip_that_is_too_short(self, call):
        assert refused(call("short")).endswith("short.bvh: lasts 60 frames at 60 a second; a take needs 70")

    def test_another_skeleton(self, call, skeletons, tmp_path):
        clip, other = tiny_walker.take().clip, skeletons["bandai-namco"]
        rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(clip), len(other), 1))
        write_bvh(tmp_path / "other.bvh", replace(clip, skeleton=other, rotations=rotations))
        told = refused(call(tmp_path / "other.bvh"))
        assert "other.bvh: its joints differ from those of the weights' skeleton: it has no " in told

    def test_a_style_that_is_known(self, call):
        assert refused(call(style="Plain")) == "these weights know the style 'Plain' already; choose another name"

    def test_weights_of_another_kind(self, call, tmp_path):
        save_bundle(tmp_path / "film", tiny_walker.bundle())
        assert "lpn-film has no residual adapters" in refused(call(weights=tmp_path / "film"))

    def test_an_adapter_that_there_is_not(self, call):
        assert refused(call(adapter="big")) == "no adapter 'big'; there are cp, diagonal, full"


def test_a_folder_with_weights_is_left_alone(call, given):
    assert "holds trained weights; choose another folder" in refused(call(out=given / "base"))
