"""The released network's walks as a data set: read like any other, the same each time, feet still."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stylephase.data import registry
from stylephase.data.catalogue import cut_frames, load_catalogue, load_clip
from stylephase.data.split import PARTS
from stylephase.errors import InputError
from stylephase.evaluation.motion import foot_skate
from stylephase.evaluation.style import recognised, style_space
from stylephase.features.layout import FPS
from stylephase.features.store import StyleVectors
from stylephase.features.vectors import vectors
from stylephase.files import sha256
from stylephase.models.bundle import Bundle
from stylephase.models.released import HELD_OUT, UNUSABLE, release_bundle
from stylephase.motion.clip import forward_kinematics
from stylephase.motion.contacts import foot_contacts
from stylephase.runtime.rig import rig_of
from stylephase.runtime.rollout import Rollout, to_clip
from stylephase.runtime.rollout_set import GAITS, finished_walk, generate, raw_walk

_STYLES = ("Neutral", "Old", "Zombie", "HandsInPockets")
_SHORT = tuple(replace(gait, seconds=2.0) for gait in GAITS[:2])


@pytest.fixture(scope="module")
def here(mirror, tmp_path_factory):
    """The mirror, and a cache for this module."""
    if not all((mirror / name).exists() for name in ("local-phases-release.tar.xz", "100style-excerpts.tar.xz")):
        pytest.skip("needs the release and a skeleton of 100STYLE: their archives are not in the mirror")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STYLEPHASE_MIRROR", str(mirror))
        patch.setenv("STYLEPHASE_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def made(here, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    generate(folder, styles=_STYLES, gaits=_SHORT)
    return folder


@pytest.fixture
def catalogue(made, monkeypatch):
    """The short set behind its own door."""
    monkeypatch.setattr("stylephase.data.catalogue.fetch", lambda dataset: made)
    return load_catalogue("lpn-rollouts")


def test_it_is_read_by_the_same_door(catalogue):
    assert catalogue.styles == tuple(sorted(_STYLES)) and catalogue.gaits == ("FR", "FW")
    assert [entry.symmetric for entry in catalogue.of("Old", "FW") + catalogue.of("Neutral", "FW")] == [False, True]
    for entry in catalogue.entries:
        clip = load_clip(entry, catalogue.dataset)
        assert cut_frames(entry, catalogue.dataset, clip) == (0, 120) and len(clip) == 120
        assert clip.skeleton.names[0] == "Hips" and len(clip.skeleton) == 28


def test_feet_are_still_where_our_own_contacts_find_them(catalogue):
    for entry in catalogue.entries:
        clip = load_clip(entry, catalogue.dataset)
        pose, roles = forward_kinematics(clip), clip.skeleton.roles
        contacts = foot_contacts(pose.positions[:, roles.toe_sensors[::-1]], clip.fps, catalogue.dataset.contact)
        assert contacts.any() and foot_skate(pose.positions[:, roles.toes[::-1]], contacts) < 0.06


def test_the_same_seed_writes_the_same_bytes_whoever_walks_beside(made, here, tmp_path):
    generate(tmp_path, styles=_STYLES, gaits=_SHORT)
    files = sorted(path.relative_to(made) for path in made.rglob("*") if path.is_file())
    assert len(files) == 2 + 2 * len(_STYLES)
    assert [sha256(made / name) for name in files] == [sha256(tmp_path / name) for name in files]


def test_each_step_of_the_cleaning_stills_the_feet(here):
    """The whole predicted step slides; grounding takes about half of it away, the held feet nearly all."""
    bundle, gait = release_bundle(), replace(GAITS[0], seconds=2.0)
    toes, skates = [leg.tip for leg in rig_of(bundle.body).legs], []
    raw = raw_walk(bundle, _STYLES, gait, grounded=False)
    for run in (raw, raw_walk(bundle, _STYLES, gait), finished_walk(bundle, _STYLES, gait)):
        walks = range(len(_STYLES))
        skates.append(
            np.mean([foot_skate(run.positions[180:, k][:, toes], run.contacts[180:, k] > 0.5) for k in walks])
        )
    assert skates[0] > 0.2 and skates[1] < 0.7 * skates[0] and skates[2] < 0.02


def _halves(bundle: Bundle, run: Rollout, k: int, style: str) -> StyleVectors:
    """Poses of a walk whose first half trains and whose second half tests."""
    clip, body = to_clip(run, k, bundle.body, style).frames(180, len(run)), bundle.body
    silent, lifted = np.zeros((len(clip), 8)), np.zeros((len(clip), 2), dtype=bool)
    made = vectors(forward_kinematics(clip), body.skeleton, body.rest, FPS, silent, lifted)
    part = np.repeat([PARTS.index("train"), PARTS.index("test")], [len(made.x) // 2, len(made.x) - len(made.x) // 2])
    take, phase = np.zeros(len(part), dtype=int), np.zeros(len(part))
    return StyleVectors(style, False, ("FW",), made.x, made.p, made.y, phase, phase, take, part)


def test_the_second_half_of_a_walk_is_told_by_the_first(here):
    """Each style is recognised, and with the names of the halves shuffled none is."""
    bundle, gait = release_bundle(), replace(GAITS[0], seconds=12.0)
    run = finished_walk(bundle, _STYLES, gait)
    halves, layout = [_halves(bundle, run, k, style) for k, style in enumerate(_STYLES)], bundle.body.layout
    right, count = recognised(style_space(halves, layout), halves, layout, "test")
    assert right == count >= len(_STYLES)
    named = [replace(half, style=_STYLES[(k + 1) % len(_STYLES)]) for k, half in enumerate(halves)]
    assert recognised(style_space(halves, layout), named, layout, "test")[0] == 0


def test_all_styles_that_walk_have_4000_frames_and_more():
    assert sum(gait.seconds for gait in GAITS) * 60 >= 4000
    assert not set(UNUSABLE) & set(HELD_OUT)


def test_an_unknown_style_is_refused_and_no_table_written(here, tmp_path):
    with pytest.raises(InputError, match="no style 'Walk'"):
        generate(tmp_path, styles=("Walk",), gaits=_SHORT)
    assert not list(tmp_path.iterdir())


def test_its_origin_says_that_a_network_made_it():
    found = registry.dataset("lpn-rollouts")
    assert found.origin == "generated by a network" and "research" in found.licence and "circular" in found.source
