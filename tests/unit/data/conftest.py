"""Small data sets made for the tests, in the layouts of the real ones."""

import hashlib
import tarfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stylephase.data import registry
from stylephase.data.registry import Archive, Dataset
from stylephase.motion.bvh import write_bvh
from stylephase.motion.clip import Clip
from stylephase.motion.skeleton import Skeleton

NAMES = ("Hips", "LeftHip", "LeftToe", "RightHip", "RightToe", "LeftHand", "RightHand")
OFFSETS = [[0, 0, 0], [0.1, 0, 0], [0, -0.95, 0], [-0.1, 0, 0], [0, -0.95, 0], [0.3, 0.5, 0], [-0.3, 0.5, 0]]


@pytest.fixture(scope="session")
def make_bvh() -> Callable[..., Path]:
    """A function that writes a small BVH file: the hips walk along z at 1 m/s."""

    def make(path: Path, *, frames: int = 12, fps: float = 60.0, names=NAMES, offsets=OFFSETS) -> Path:
        skeleton = Skeleton(tuple(names), (-1, 0, 1, 0, 3, 0, 0), np.array(offsets, dtype=float), (False,) * 7)
        path.parent.mkdir(parents=True, exist_ok=True)
        still = np.tile([1.0, 0.0, 0.0, 0.0], (frames, 7, 1))
        hips = np.linspace([0, 0.95, 0], [0, 0.95, (frames - 1) / fps], frames)
        write_bvh(path, Clip(skeleton, fps, still, hips))
        return path

    return make


@pytest.fixture(scope="session")
def bandai_files(tmp_path_factory, make_bvh) -> Path:
    """Four takes in the layout of the Bandai-Namco sets, one of them no locomotion."""
    top = tmp_path_factory.mktemp("bandai") / "motions"
    for name in ("1_walk_old_001", "2_walk_old_001", "2_walk-turn-left_not-confident_001", "1_bow_old_001"):
        number = name[0]
        make_bvh(top / f"dataset/set-{number}/data/dataset-{name}.bvh", frames=40, fps=30.0)
    return top


@pytest.fixture
def small_mirror(tmp_path, monkeypatch, bandai_files) -> Path:
    """A mirror with one small archive, takes.tar.gz."""
    folder = tmp_path / "mirror"
    folder.mkdir()
    with tarfile.open(folder / "takes.tar.gz", "w:gz") as archive:
        archive.add(bandai_files, bandai_files.name)
    monkeypatch.setenv("STYLEPHASE_MIRROR", str(folder))
    return folder


@pytest.fixture
def small(small_mirror, cache, monkeypatch) -> Dataset:
    """A registered data set called `small`, whose archive is in the mirror."""
    key = hashlib.sha256((small_mirror / "takes.tar.gz").read_bytes()).hexdigest()
    archives = (Archive("takes.tar.gz", sha256=key),)
    made = replace(registry.dataset("bandai-namco"), name="small", archives=archives, content=None)
    monkeypatch.setattr(registry, "datasets", lambda: {"small": made})
    return made
