"""Training learns, repeats itself to the last bit, goes on after any interruption, and loses nothing when it fails."""

import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import tiny_training as tiny
import torch

from stylephase import files
from stylephase.errors import InputError
from stylephase.models.bundle import is_bundle, load_bundle
from stylephase.models.zoo import MODELS
from stylephase.training import checkpoint
from stylephase.training.loop import Trainer


def stop_at(step: int):
    """A progress bar that the user interrupts once so many steps are done."""
    done = 0

    def tick(steps: int) -> None:
        nonlocal done
        done += steps
        if done >= step:
            raise KeyboardInterrupt

    return tick


def interrupted(out: Path, step: int, **changes) -> None:
    with pytest.raises(KeyboardInterrupt):
        tiny.trainer(**changes).run(out, stop_at(step))


def resumed(out: Path, **changes) -> Trainer:
    run = tiny.trainer(**changes)
    run.resume(out)
    return run


def kept(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in out.iterdir()}


# Learning


def test_the_errors_go_down_and_the_style_codes_come_to_matter(tmp_path):
    run = tiny.trainer(steps=100, log_every=10)
    run.run(tmp_path, tiny.ignore)
    first, last = run.log[0], run.log[-1]
    assert last["mse"] < 0.8 * first["mse"] and last["validation_mse"] < 0.6 * first["validation_mse"]
    assert last["wrong_code_factor"] > 1.02


@pytest.mark.parametrize("model", sorted(MODELS))
def test_every_model_learns_and_an_interrupted_run_of_it_ends_as_a_whole_one(tmp_path, model):
    how = {"model": model, "steps": 60, "log_every": 20}
    whole = tiny.trainer(**how).run(tmp_path / "whole", tiny.ignore)
    first, *_, last = (entry["validation_mse"] for entry in tiny.read_log(tmp_path / "whole"))
    assert last < 0.98 * first
    interrupted(tmp_path / "part", 16, **how)
    again = resumed(tmp_path / "part", **how).run(tmp_path / "part", tiny.ignore)
    assert tiny.same(tiny.weights(whole), tiny.weights(again))
    assert tiny.same(tiny.weights(whole), tiny.weights(load_bundle(tmp_path / "whole")))


@pytest.mark.parametrize("mixed", [False, True])
def test_the_same_seed_gives_the_same_weights_and_another_seed_others(tmp_path, mixed):
    bundles = [
        tiny.trainer(seed=seed, steps=8, mixed=mixed).run(tmp_path / str(n), tiny.ignore)
        for n, seed in enumerate((1, 1, 2))
    ]
    one, again, other = (tiny.weights(bundle) for bundle in bundles)
    assert tiny.same(one, again)
    assert not any(torch.equal(one[name], other[name]) for name in one if name.endswith("weight"))


def test_every_weight_learns(tmp_path):
    run = tiny.trainer()
    before = {name: tensor.clone() for name, tensor in run.network.state_dict().items()}
    run.run(tmp_path, tiny.ignore)
    assert [name for name, tensor in run.network.state_dict().items() if torch.equal(tensor, before[name])] == []


def test_one_generator_pass_serves_several_steps_and_learns_from_their_mean(monkeypatch):
    """With one step per code or with four on the same frames, the generator's gradient is the same."""
    gradients = []
    for steps in (1, 4):
        rates = {"network_rate": 0.0, "generator_rate": 0.0, "steps_per_code": steps}
        run = tiny.trainer(**rates)
        batch = run.sampler.draw_frames(run.sampler.draw_styles(2), 8)
        monkeypatch.setattr(run.sampler, "draw_frames", lambda chosen, frames, same=batch: same)
        for module in ("synthesis", "experts"):
            monkeypatch.setattr(f"stylephase.models.{module}.dropout", lambda h, rate, training: h)
        torch.manual_seed(3)
        run.round()
        gradients.append(run.network.generator.code.weight.grad)
    assert gradients[0].abs().max() > 0
    torch.testing.assert_close(gradients[0], gradients[1])


def test_the_log_tells_of_steps_times_errors_and_codes(whole):
    out, _, log = whole
    assert json.loads((out / "log.json").read_text()) == log
    assert [entry["step"] for entry in log] == [6, 12, 18, 24]
    times = {"seconds", "processor_seconds"}
    told = {"mse", "bll", "validation_mse", "wrong_code_factor", "code_between", "code_within"}
    assert all(entry.keys() == {"step"} | times | told for entry in log)
    assert [entry["seconds"] for entry in log] == sorted(entry["seconds"] for entry in log)


def test_the_progress_told_adds_up_to_the_steps(tmp_path):
    ticks: list[int] = []
    tiny.trainer(steps=6).run(tmp_path, ticks.append)
    assert ticks == [2, 2, 2]


def test_a_finished_run_is_a_model_and_a_log_with_its_origin(whole):
    out, bundle, _ = whole
    assert sorted(path.name for path in out.iterdir()) == ["log.json", "model.json", "weights.safetensors"]
    found = load_bundle(out)
    assert tiny.same(tiny.weights(found), tiny.weights(bundle)) and found.styles == ("Plain", "Sway")
    expected = {"data": "tiny", "origin": "synthetic", "preset": "tiny", "seed": 0, "steps": 24, "gaits": ["FR", "FW"]}
    assert expected.items() <= found.about.items()


def test_styles_too_short_for_a_validation_train_all_the_same(tmp_path):
    run = Trainer(tiny.TinyStore(validation=False), "lpn-film", tiny.PRESET, "tiny", 0)
    run.run(tmp_path, tiny.ignore)
    assert run.log[-1]["validation_mse"] is None and run.log[-1]["wrong_code_factor"] is None


def test_one_style_alone_trains(tmp_path):
    assert tiny.trainer("Sway").run(tmp_path, tiny.ignore).styles == ("Sway",)


# Interrupted


@pytest.mark.parametrize("step", [2, 8, 10, 14, 22, 24])
def test_an_interrupted_run_ends_as_one_that_nothing_interrupted(whole, tmp_path, step):
    """Checkpoints stand at steps 8 and 16: before the first, right at one, between two, at the very end."""
    interrupted(tmp_path, step)
    run = resumed(tmp_path)
    assert run.step == max(at for at in (0, 8, 16) if at < step or at == 0)
    bundle = run.run(tmp_path, tiny.ignore)
    assert tiny.same(tiny.weights(bundle), tiny.weights(whole[1]))
    assert tiny.untimed(run.log) == tiny.untimed(whole[2])
    assert kept(tmp_path).keys() == kept(whole[0]).keys()


def test_a_run_interrupted_twice_keeps_counting_its_time(tmp_path):
    interrupted(tmp_path, 10)
    first = resumed(tmp_path).seconds
    with pytest.raises(KeyboardInterrupt):
        resumed(tmp_path).run(tmp_path, stop_at(10))
    run = resumed(tmp_path)
    assert run.step == 16 and run.seconds > first > 0


_KILLED = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, {folder!r})
import tiny_training as tiny

def die_in_the_second(method, name):
    whole, seen = getattr(Path, method), []

    def half(path, content, **how):
        seen.extend([path] * (name in path.name))
        if len(seen) == 2:
            whole(path, content[: len(content) // 2], **how)
            os.kill(os.getpid(), signal.SIGKILL)
        return whole(path, content, **how)

    setattr(Path, method, half)

run = tiny.trainer()
for method, name in (("write_bytes", "-checkpoint"), ("write_text", ".state")):
    child = os.fork()
    if not child:
        die_in_the_second(method, name)
        run.run(Path({out!r}, name), tiny.ignore)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


def test_a_kill_in_the_middle_of_the_second_checkpoint_resumes_from_the_first(whole, tmp_path):
    """Killed while the tensors are half written, and while the state is that would point to them."""
    code = _KILLED.format(folder=str(Path(tiny.__file__).parent), out=str(tmp_path))
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100, env=environment)
    assert process.stdout.split() == [str(-signal.SIGKILL)] * 2, process.stderr
    for out in tmp_path.iterdir():
        left = [name for name in kept(out) if name.startswith(".")]
        assert len(left) == 1 and left[0].startswith(".state" if out.name == ".state" else ".16-checkpoint")
        run = resumed(out)
        assert run.step == 8
        assert tiny.same(tiny.weights(run.run(out, tiny.ignore)), tiny.weights(whole[1]))
        assert kept(out).keys() == kept(whole[0]).keys(), "what the kill left is swept up"


# Failing


@pytest.mark.parametrize("changes", [{"seed": 1}, {"steps": 30}, {"bone_weight": 2.0}])
def test_a_checkpoint_of_another_run_is_refused_and_kept(tmp_path, changes):
    interrupted(tmp_path, 10)
    before = kept(tmp_path)
    with pytest.raises(InputError, match=r"holds another run, of which these differ: (seed|settings)$"):
        resumed(tmp_path, **changes)
    assert kept(tmp_path) == before


@pytest.mark.parametrize(
    ("store", "differs"), [(tiny.TinyStore("Plain"), "styles"), (tiny.TinyStore(version="2"), "vectors")]
)
def test_a_checkpoint_of_other_styles_or_vectors_is_refused(tmp_path, store, differs):
    interrupted(tmp_path, 10)
    with pytest.raises(InputError, match=rf"these differ: {differs}$"):
        Trainer(store, "lpn-film", tiny.PRESET, "tiny", 0).resume(tmp_path)


def test_a_diverging_run_says_so_in_one_line_and_keeps_the_last_checkpoint(tmp_path):
    run = tiny.trainer()
    learn = run.round

    def diverging() -> dict[str, float]:
        if run.step >= 12:
            torch.nn.init.constant_(run.network.synthesis.layers[0].weight, float("inf"))
        return learn()

    run.round = diverging
    with pytest.raises(InputError, match=rf"^{tmp_path}: training diverged at step 14: "):
        run.run(tmp_path, tiny.ignore)
    assert resumed(tmp_path).step == 8


@pytest.mark.parametrize("at", [12, 16])
def test_weights_that_are_not_finite_never_replace_a_checkpoint(tmp_path, at):
    """The loss is from before the update that broke the weights: finite still when a log or checkpoint is due."""
    run = tiny.trainer()
    learn = run.round

    def breaking() -> dict[str, float]:
        errors = learn()
        if run.step == at:
            torch.nn.init.constant_(run.network.synthesis.layers[2].bias, float("nan"))
        return errors

    run.round = breaking
    with pytest.raises(InputError, match=f"training diverged at step {at}"):
        run.run(tmp_path, tiny.ignore)
    assert resumed(tmp_path).step == 8 and not is_bundle(tmp_path)


@pytest.mark.parametrize("part", ["-checkpoint", ".state", ".log"])
def test_a_disk_that_is_full_keeps_the_last_checkpoint_and_the_run_goes_on_later(whole, tmp_path, monkeypatch, part):
    interrupted(tmp_path, 10)
    run, flush = resumed(tmp_path), os.fsync

    def full(handle: int) -> None:
        if part in os.readlink(f"/proc/self/fd/{handle}"):
            raise OSError(errno.ENOSPC, "No space left on device")
        flush(handle)

    monkeypatch.setattr(files.os, "fsync", full)
    with pytest.raises(InputError, match="cannot write: No space left on device"):
        run.run(tmp_path, tiny.ignore)
    monkeypatch.undo()
    again = resumed(tmp_path)
    assert again.step == 8
    assert tiny.same(tiny.weights(again.run(tmp_path, tiny.ignore)), tiny.weights(whole[1]))


def test_a_disk_that_is_full_at_the_end_keeps_the_last_checkpoint(whole, tmp_path, monkeypatch):
    def full(folder, bundle):
        raise InputError("cannot write: No space left on device", folder)

    with monkeypatch.context() as patched:
        patched.setattr("stylephase.training.loop.save_bundle", full)
        with pytest.raises(InputError, match="No space left"):
            tiny.trainer().run(tmp_path, tiny.ignore)
    assert not is_bundle(tmp_path)
    bundle = resumed(tmp_path).run(tmp_path, tiny.ignore)
    assert tiny.same(tiny.weights(bundle), tiny.weights(whole[1]))


def test_a_folder_that_cannot_be_written_costs_no_training(tmp_path):
    (tmp_path / "file").write_text("in the way")
    run = tiny.trainer()
    with pytest.raises(InputError, match="cannot write"):
        run.run(tmp_path / "file", tiny.ignore)
    assert run.step == 0


# Damaged checkpoints


def cut(out: Path) -> None:
    path = out / "8-checkpoint.safetensors"
    path.write_bytes(path.read_bytes()[:-1])


def other_tensors(out: Path) -> None:
    checkpoint.save_tensors(out / "8-checkpoint.safetensors", {"random": torch.get_rng_state()})


def change(**values):
    def rewrite(out: Path) -> None:
        state = json.loads((out / "state.json").read_text()) | values
        (out / "state.json").write_text(json.dumps({key: value for key, value in state.items() if value is not None}))

    return rewrite


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (cut, r"8-checkpoint\.safetensors: not a whole safetensors file"),
        (lambda out: (out / "8-checkpoint.safetensors").unlink(), r"8-checkpoint\.safetensors: no such file"),
        (other_tensors, r"state\.json: not a checkpoint of this run"),
        (lambda out: (out / "state.json").write_text("{"), r"state\.json:1: not JSON"),
        (lambda out: (out / "state.json").write_text("[]"), r"state\.json: not the state of a training run"),
        (change(rng=None), r"state\.json: not a checkpoint of this run: it lacks 'rng'"),
        (change(rng={"bit_generator": "Dice"}), r"state\.json: not a checkpoint of this run"),
        (change(tensors=None), "no such file"),
    ],
)
def test_a_damaged_checkpoint_is_one_line_with_its_file(tmp_path, damage, says):
    interrupted(tmp_path, 10)
    damage(tmp_path)
    with pytest.raises(InputError, match=says) as caught:
        resumed(tmp_path)
    assert "\n" not in str(caught.value) and str(caught.value).startswith(str(tmp_path))
