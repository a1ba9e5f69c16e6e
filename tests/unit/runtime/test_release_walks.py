"""The authors' released network walks under this controller as it was measured to walk under theirs."""

import numpy as np
import pytest
import torch

from stylephase.cli import app
from stylephase.data.registry import released_weights
from stylephase.errors import InputError
from stylephase.evaluation.motion import bones_of, steps_of
from stylephase.models.bundle import Bundle
from stylephase.models.released import release_bundle, style_names
from stylephase.motion.bvh import read_bvh
from stylephase.runtime import calibration
from stylephase.runtime.calibration import speed_of
from stylephase.runtime.controller import RELEASE, start_state
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import roll_out

# Speed (m/s) and cycle (s) of walking straight at a gain of 6, from an implementation of its own of the release.
MEASURED = {"Neutral": (0.94, 79 / 60), "Zombie": (1.05, 72 / 60)}


@pytest.fixture(scope="module")
def folders(mirror, tmp_path_factory):
    """The mirror, and a cache for this module."""
    if not (mirror / "local-phases-release.tar.xz").exists() or not (mirror / "100style-excerpts.tar.xz").exists():
        pytest.skip("needs the release and a skeleton of 100STYLE: their archives are not in the mirror")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STYLEPHASE_MIRROR", str(mirror))
        patch.setenv("STYLEPHASE_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def bundle(folders) -> Bundle:
    return release_bundle()


def test_it_walks_as_fast_and_steps_as_often_as_was_measured(bundle):
    """Two styles from the mean pose with phases at zero; the first three seconds settle."""
    codes = torch.stack([bundle.code(style) for style in MEASURED])
    start = start_state(np.tile(bundle.normaliser.x_mean, (2, 1)), np.zeros((2, 8)), bundle.body.layout)
    run = roll_out(bundle, codes, start, 480, Steady(np.full(2, 6.0)), RELEASE)
    skeleton, joints, bones = bundle.body.skeleton, bundle.body.joints, bundle.body.bones
    lengths = np.array([np.linalg.norm(skeleton.offsets[joints[child]]) for _, child in bones])
    for k, (speed, cycle) in enumerate(MEASURED.values()):
        steps = steps_of(run.contacts[180:, k] > 0.5)
        held = bones_of(run.positions[180:, k], bones, lengths)
        assert speed_of(run.root_positions[180:, k]) == pytest.approx(speed, rel=0.1)
        assert steps.alternation == 1.0 and steps.cycle == pytest.approx(cycle, rel=0.1)
        assert held.median < 1.6 and held.worst < 4 and held.off < 20


def test_the_command_writes_its_walk(folders, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(calibration, "_TRIAL_SECONDS", 1.1)
    monkeypatch.setattr(calibration, "_ROUNDS", 1)
    monkeypatch.setattr(calibration, "_WARM_UP_SECONDS", 0.1)
    with pytest.raises(SystemExit) as end:
        app.main(
            ["rollout", "--weights", "release", "--style", "Old:1,HandsInPockets:1", "--seconds", "0.2", "--json"]
            + ["--out", str(tmp_path / "walk.bvh")]
        )
    assert not end.value.code and '"licence": "research and education only"' in capsys.readouterr().out
    clip = read_bvh(tmp_path / "walk.bvh", metres_per_unit=0.01)
    assert clip.skeleton.names[0] == "Hips" and len(clip.skeleton) == 28 and len(clip) == 12


def test_each_code_has_the_name_of_its_style(bundle):
    assert len(bundle.styles) == 100 == len(set(bundle.styles))
    numbers = {"Aeroplane": 0, "Drunk": 23, "Heavyset": 32, "Neutral": 50, "PendulumHands": 57, "Robot": 66}
    numbers |= {"Swimming": 80, "Zombie": 94, "HandsInPockets": 95, "Skip": 97, "WildArms": 99}
    assert (
        {name: bundle.styles.index(name) for name in numbers}
        == numbers
        == {name: style_names().index(name) for name in numbers}
    )


def test_it_says_whose_it_is(bundle):
    assert bundle.about["licence"] == "research and education only" and "Mason" in bundle.about["credit"]
    assert (bundle.body.layout.inputs, bundle.body.layout.outputs) == (348, 342)
    np.testing.assert_allclose(bundle.body.rest, np.broadcast_to(np.eye(3), bundle.body.rest.shape), atol=1e-12)


def test_its_generator_cannot_be_run_unnoticed(bundle):
    """It was never released: what stands in its place has no values."""
    with pytest.raises(RuntimeError, match="meta"):
        bundle.network.generator(torch.zeros(1, 240, bundle.body.layout.pose))


def test_without_a_skeleton_at_hand_nothing_large_is_downloaded(folders, tmp_path, monkeypatch, mirror):
    only = tmp_path / "mirror"
    only.mkdir()
    (only / "local-phases-release.tar.xz").symlink_to((mirror / "local-phases-release.tar.xz").resolve())
    monkeypatch.setenv("STYLEPHASE_MIRROR", str(only))
    monkeypatch.setattr("stylephase.data.archive.cache_folder", lambda: tmp_path / "cache")
    with pytest.raises(InputError, match="first run: stylephase data fetch 100style"):
        release_bundle()


def test_the_ledger_has_its_archive_hash_and_licence(root):
    """Without the mirror: what is registered is written down."""
    ledger = (root / "data/README.md").read_text()
    for name, weights in released_weights().items():
        wanted = {name, weights.licence}
        wanted |= {text for archive in weights.archives for text in (archive.file, archive.sha256)}
        assert [text for text in sorted(wanted) if text not in ledger] == []
