"""Random input for long: a sound walker stays plausible, and each way of breaking is caught by its name and time."""

import numpy as np
import pytest
import tiny_walker as tiny
import torch

from stylephase.evaluation.robustness import Plausible, Wander, as_json, endure, random_paths, table

NAN = float("nan")


class Breaking(torch.nn.Module):
    """An obedient walker whose outputs go wrong after some frames, in those whose code begins above zero."""

    def __init__(self, wrong, after: int = 190):
        super().__init__()
        self.sound, self.wrong, self.left = tiny.Obedient(), wrong, after

    def forward(self, x, p, code):
        self.left -= 1
        n = tiny.statistics()
        deviation, mean = torch.from_numpy(n.y_std), torch.from_numpy(n.y_mean)
        y = self.sound(x, p, 0 * code).double() * deviation + mean
        if self.left < 0:
            bad = y.clone()
            self.wrong(bad, bad[:, tiny.BODY.layout.y_pose].view(len(y), -1, 4, 3), -self.left)
            y = torch.where(code[:, :1] > 0, bad, y)
        return ((y - mean) / deviation).float()


def run(network: torch.nn.Module, seconds: float = 5.0, **given):
    bundle, codes = tiny.bundle("Plain", network=network), torch.tensor([[-1.0], [1.0]]).expand(2, 32)
    return endure(bundle, ["sound", "wrong"], codes, tiny.start([0, 0]), np.array([1.2, 1.2]), seconds, **given)


def test_a_sound_walker_stays_plausible():
    found = run(Breaking(lambda *_: None), 8.0)
    for each in found:
        assert (each.broken, each.after) == ("", 8.0)
        assert 0.8 < each.hips[0] <= each.hips[1] < 1.0 and each.bones < 0.05
        assert 0 < each.off_path < 1 and 0.5 < each.speed < 2


def _set(part, value):
    def wrong(y, joints, frames):
        part(y, joints)[:] = value

    return wrong


def _sink(y, joints, frames):
    joints[:, :, 0, 1] -= 0.02 * frames
    y[:, tiny.BODY.layout.y_pose] = joints.reshape(len(y), -1)


def _stretch(y, joints, frames):
    joints[:, :, 0] *= 1 + 0.03 * frames
    y[:, tiny.BODY.layout.y_pose] = joints.reshape(len(y), -1)


def _stray(y, joints, frames):
    y[:, 0] += 0.4


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        (_set(lambda y, joints: y, NAN), "not finite"),
        (_sink, "hips too low"),
        (_stretch, "bones of wrong lengths"),
        (_stray, "off its path"),
    ],
)
def test_each_way_of_breaking_is_caught_and_leaves_the_other_alone(wrong, reason):
    sound, broken = run(Breaking(wrong), limits=Plausible(speed=50.0))
    assert not sound.broken and sound.after == 5.0
    assert broken.broken == reason and 3.1 < broken.after < 4.9


def test_bounds_are_the_askers():
    assert run(Breaking(lambda *_: None), 4.0, limits=Plausible(hips=(0.3, 0.5)))[0].broken == "hips too high"
    assert run(Breaking(lambda *_: None), 4.0, limits=Plausible(speed=0.2))[0].broken == "too fast"


def test_when_all_are_broken_it_ends_early():
    frames = []
    run(Breaking(lambda *_: None), 60.0, limits=Plausible(hips=(5.0, 6.0)), tick=frames.append)
    assert len(frames) < 200


def test_afterwards_the_smallest_numbers_are_numbers_again():
    run(Breaking(lambda *_: None), 1.0)
    assert torch.tensor(5e-324, dtype=torch.float64).mul(1.0).item() > 0


def test_the_same_seed_gives_the_same_and_another_not():
    one, same, other = (run(Breaking(lambda *_: None), 4.0, seed=seed) for seed in (1, 1, 2))
    assert one == same != other


def test_paths_are_smooth_and_begin_ahead():
    paths = random_paths(3, 30.0, np.random.default_rng(0))
    for path in paths:
        steps = np.diff(path, axis=0)
        np.testing.assert_allclose(np.linalg.norm(steps, axis=1), 0.1)
        bends = np.diff(np.unwrap(np.arctan2(steps[:, 0], steps[:, 1])))
        assert np.abs(bends).max() < 0.081 and np.abs(bends).sum() > 3 and steps[0, 1] > 0.09
    assert np.abs(paths[0] - paths[1]).max() > 1


def test_input_changes_and_stops():
    plan, state = Wander(np.ones(2), 120.0, np.random.default_rng(0)), tiny.start([0, 0])
    speeds = np.array([np.linalg.norm(plan(frame, state).velocity, axis=1) for frame in range(7200)])
    assert len(np.unique(speeds[:, 0])) > 15 and (speeds == 0).any() and speeds.max() < 1.3 + 1e-9


def test_reports_are_plain():
    found = run(Breaking(_set(lambda y, joints: y, NAN), after=0), 1.0)
    rows = as_json(found)
    assert rows[1]["broken"] == "not finite" and rows[1]["hips"] == [None, None]
    assert table(found).splitlines()[2].startswith("| wrong | 0 s | not finite")
