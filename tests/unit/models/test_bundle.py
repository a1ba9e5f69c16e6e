"""A trained model in a folder comes back as it was, and a folder that is not whole is refused in one line."""

import errno
import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file

from stylephase import files
from stylephase.errors import InputError
from stylephase.features.normaliser import Normaliser
from stylephase.models.bundle import Bundle, Start, description, is_bundle, load_bundle, save_bundle, save_starts
from stylephase.models.generator import GeneratorSettings


@pytest.fixture
def folder(bundle, tmp_path) -> Path:
    """The bundle, written."""
    save_bundle(tmp_path / "run", bundle)
    return tmp_path / "run"


def outputs(bundle: Bundle, style: str) -> torch.Tensor:
    layout = bundle.body.layout
    generator = torch.Generator().manual_seed(1)
    x, p = (torch.randn(4, width, generator=generator) for width in (layout.inputs, layout.gate_inputs))
    clip = torch.randn(1, 240, layout.pose, generator=generator)
    with torch.inference_mode():
        codes = torch.cat([bundle.code(style)[None].expand(3, -1), bundle.network.generator(clip)])
        return bundle.network.synthesis(x, p, codes)


def refusal(folder: Path) -> str:
    with pytest.raises(InputError) as caught:
        load_bundle(folder)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def rewrite(folder: Path, change) -> None:
    path = folder / "model.json"
    value = json.loads(path.read_text())
    change(value)
    path.write_text(json.dumps(value))


def test_a_round_trip_gives_identical_outputs(bundle, folder):
    found = load_bundle(folder)
    assert not found.network.training and found.styles == bundle.styles
    for style in bundle.styles:
        assert torch.equal(outputs(found, style), outputs(bundle, style))


def test_weights_to_run_a_character_are_half_as_precise_and_make_no_codes(bundle, tmp_path):
    save_bundle(tmp_path / "run", bundle, to_run=True)
    found = load_bundle(tmp_path / "run")
    assert bundle.makes_codes and not found.makes_codes
    x, p = torch.randn(4, bundle.layout.inputs), torch.randn(4, bundle.layout.gate_inputs)
    for style in bundle.styles:
        ours, full = (b.network.synthesis(x, p, b.code(style)[None].expand(4, -1)) for b in (found, bundle))
        assert 0 < (ours - full).abs().max() < 0.01 * full.abs().max()
    with pytest.raises(RuntimeError, match="meta"):
        found.network.generator(torch.zeros(1, 240, bundle.layout.pose))
    save_bundle(tmp_path / "again", found)
    assert torch.equal(load_bundle(tmp_path / "again").code("Plain"), found.code("Plain"))


def test_a_round_trip_keeps_all_that_describes_the_model(bundle, folder):
    found = load_bundle(str(folder))
    assert (found.model, found.settings, found.about) == (bundle.model, bundle.settings, bundle.about)
    assert found.body.skeleton.names == bundle.body.skeleton.names and found.body.layout == bundle.body.layout
    np.testing.assert_array_equal(found.body.rest, bundle.body.rest)
    np.testing.assert_array_equal(found.body.skeleton.offsets, bundle.body.skeleton.offsets)
    for field in fields(Normaliser):
        np.testing.assert_array_equal(getattr(found.normaliser, field.name), getattr(bundle.normaliser, field.name))


@pytest.mark.parametrize("clamp", [5.0, float("inf")])
def test_the_clamp_survives_a_file_that_knows_no_infinity(bundle, tmp_path, clamp):
    settings = replace(bundle.settings, generator=replace(bundle.settings.generator, clamp=clamp))
    save_bundle(tmp_path, replace(bundle, settings=settings))
    assert load_bundle(tmp_path).settings.generator.clamp == clamp
    assert GeneratorSettings().clamp == float("inf")


def test_the_folder_holds_tensors_and_json_alone(folder):
    assert sorted(path.name for path in folder.iterdir()) == ["model.json", "weights.safetensors"]


def test_a_description_is_read_without_the_weights(folder):
    (folder / "weights.safetensors").unlink()
    assert is_bundle(folder) and not is_bundle(folder.parent)
    found = description(folder)
    assert (found["model"], found["styles"], found["data"]) == ("lpn-film", ["Plain", "Very old"], "made")


def test_an_unknown_style_is_answered_with_those_there_are(bundle):
    with pytest.raises(InputError, match=r"no style 'Old' in these weights; there are Plain, Very old"):
        bundle.code("Old")


# What is not whole


@pytest.mark.parametrize("name", ["model.json", "weights.safetensors"])
def test_a_missing_file_is_named(folder, name):
    (folder / name).unlink()
    assert refusal(folder) == f"{folder / name}: no such file"


def test_a_folder_that_is_not_there_is_named(tmp_path):
    assert refusal(tmp_path / "nowhere").startswith(str(tmp_path / "nowhere" / "model.json"))


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b'{"model": "lpn-film",\n "sett', ":2: not JSON"),
        (b"\xff\xfe\x00", ": not UTF-8"),
        (b"[1, 2]", ": does not describe a trained model"),
        (b'"text"', ": does not describe a trained model"),
        (b"{}", ": does not describe a trained model: it lacks 'settings'"),
    ],
)
def test_json_of_something_else_is_refused_with_its_file(folder, content, says):
    (folder / "model.json").write_bytes(content)
    assert refusal(folder).startswith(f"{folder / 'model.json'}{says}")


@pytest.mark.parametrize(
    "change",
    [
        lambda value: value["settings"].update(experts=None),
        lambda value: value["settings"].update(colour=3),
        lambda value: value["settings"].update(generator=7),
        lambda value: value["body"].update(parents=[0]),
        lambda value: value["body"].update(names=[f"joint{n}" for n in range(len(value["body"]["names"]))]),
        lambda value: value.update(styles=3),
        lambda value: value.update(about=["nothing"]),
    ],
)
def test_json_whose_values_make_no_model_is_refused_with_its_file(folder, change):
    rewrite(folder, change)
    assert refusal(folder).startswith(f"{folder / 'model.json'}: does not describe a trained model")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda value: value["settings"].update(units=9), "expected (36,), found (32,)"),
        (lambda value: value["settings"].update(experts=3), "expected (3,), found (2,)"),
        (lambda value: value["styles"].append("New"), "for code.New expected (32,), found nothing"),
        (lambda value: value["styles"].remove("Plain"), "for code.Plain expected nothing, found (32,)"),
    ],
)
def test_weights_of_another_model_are_refused_with_what_does_not_fit(folder, change, says):
    rewrite(folder, change)
    message = refusal(folder)
    assert message.startswith(f"{folder / 'weights.safetensors'}: does not fit model.json: for ") and says in message


@pytest.mark.parametrize("prefix", ["network.synthesis.gating", "normaliser.y_std", "code.Plain"])
def test_weights_with_a_part_missing_are_refused(folder, prefix):
    path = folder / "weights.safetensors"
    save_file({name: tensor for name, tensor in load_file(path).items() if not name.startswith(prefix)}, path)
    assert refusal(folder).startswith(f"{path}: does not fit model.json: for {prefix}")


@pytest.mark.parametrize("keep", [0, 7, 100, -1])
def test_weights_that_are_cut_off_are_refused(folder, keep):
    path = folder / "weights.safetensors"
    path.write_bytes(path.read_bytes()[:keep])
    assert refusal(folder).startswith(f"{path}: not a whole safetensors file")


@pytest.mark.parametrize("write", [1, 2])
def test_a_full_disk_is_one_line_and_leaves_no_model_that_is_half_new(bundle, tmp_path, monkeypatch, write):
    """The disk fills up at the first or second file: before, there is no model, and after, there is none."""
    calls = []

    def full(handle: int) -> None:
        calls.append(handle)
        if len(calls) == write:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(InputError, match=r"^\S+: cannot write: No space left on device$"):
        save_bundle(tmp_path, bundle)
    assert not is_bundle(tmp_path) and [path for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def with_starts(bundle: Bundle) -> Bundle:
    layout = bundle.layout
    return replace(bundle, starts={"Very old": Start(torch.randn(layout.inputs), torch.randn(layout.gate_inputs))})


def test_starts_come_back_and_go_with_weights_that_have_none(bundle, tmp_path):
    kept = with_starts(bundle)
    save_bundle(tmp_path, kept, to_run=True)
    found = load_bundle(tmp_path).starts
    assert list(found) == ["Very old"]
    for part in ("x", "p"):
        assert torch.equal(getattr(found["Very old"], part), getattr(kept.starts["Very old"], part))
    save_bundle(tmp_path, bundle)
    assert load_bundle(tmp_path).starts == {}


@pytest.mark.parametrize("wrong", [torch.zeros(3), torch.tensor([float("nan")])])
def test_starts_that_do_not_fit_are_refused(bundle, tmp_path, wrong):
    kept = with_starts(bundle).starts["Very old"]
    save_bundle(tmp_path, bundle)
    save_starts(tmp_path, {"Very old": replace(kept, p=wrong.expand(3))})
    assert refusal(tmp_path).startswith(f"{tmp_path / 'starts.safetensors'}: does not fit model.json: p.Very old")
