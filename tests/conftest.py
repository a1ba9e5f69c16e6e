"""Fixtures that several tests share."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]
# Timings differ between machines, so no deadline; derandomised, so that one commit has one result.
settings.register_profile("fixed", deadline=None, derandomize=True, database=None, max_examples=50)
settings.load_profile("fixed")


@pytest.fixture(scope="session")
def root() -> Path:
    """The top folder of the repository."""
    return ROOT


@pytest.fixture(scope="session")
def mirror() -> Path:
    """The folder of real data named by STYLEPHASE_MIRROR; the test is skipped where there is none."""
    folder = Path(os.environ.get("STYLEPHASE_MIRROR") or ROOT.parent / "shared" / "mirror")
    if not folder.is_dir():
        pytest.skip("needs real data: STYLEPHASE_MIRROR names no folder")
    return folder


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache of data of the test's own."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("STYLEPHASE_CACHE", str(folder))
    return folder


@pytest.fixture(scope="session")
def frozen() -> Callable[[np.ndarray], np.ndarray]:
    """A function that gives a read-only copy of an array, so that a callee that writes into its input fails."""

    def freeze(array: np.ndarray) -> np.ndarray:
        copy = np.array(array)
        copy.flags.writeable = False
        return copy

    return freeze
