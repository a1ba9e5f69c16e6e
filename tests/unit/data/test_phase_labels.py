"""Phase labels are read strictly: one number for each frame, and a file that is wrong is named with its line."""

from pathlib import Path

import numpy as np
import pytest

from stylephase.data.labels import label_files, read_phase_labels
from stylephase.errors import InputError


@pytest.fixture
def labels(tmp_path: Path) -> Path:
    path = tmp_path / "take.phase"
    path.write_text("0.000000\n0.25\n0.5\n1.00000\n")
    return path


def test_labels_are_read_in_radians_and_a_whole_cycle_is_none(labels):
    assert np.allclose(read_phase_labels(labels, 4), [0, np.pi / 2, np.pi, 0])


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("0\n0.5 0.6\n0\n0\n", 2, "expected one phase, found '0.5 0.6'"),
        ("0\n0\n\n0\n", 3, "expected one phase, found ''"),
        ("0\n0\nhalf\n0\n", 3, "expected one phase, found 'half'"),
        ("0\n1.01\n0\n0\n", 2, "expected a phase from 0 to 1 cycles, found 1.01"),
        ("0\n0\n0\n-0.1\n", 4, "expected a phase from 0 to 1 cycles, found -0.1"),
        ("0\nnan\n0\n0\n", 2, "expected a phase from 0 to 1 cycles, found nan"),
        ("0\n0\n0\n", 3, "expected 4 phases, one for each frame, found 3"),
        ("0\n0\n0\n0\n0\n", 5, "expected 4 phases, one for each frame, found 5"),
        ("", None, "expected 4 phases, one for each frame, found 0"),
    ],
)
def test_a_wrong_line_is_named(labels, text, line, reason):
    labels.write_text(text)
    with pytest.raises(InputError) as caught:
        read_phase_labels(labels, 4)
    assert str(caught.value) == (f"{labels}:{line}: {reason}" if line else f"{labels}: {reason}")


def test_a_file_that_is_missing_or_no_text_is_named(labels):
    labels.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"take\.phase: not a file of phase labels"):
        read_phase_labels(labels, 4)
    labels.unlink()
    with pytest.raises(InputError, match=r"take\.phase: no such file"):
        read_phase_labels(labels, 4)


def test_the_labels_of_a_take_lie_beside_it_with_those_of_its_mirrored_copy():
    own, copy = label_files(Path("some/Walk04_000.bvh"))
    assert (own, copy) == (Path("some/Walk04_000.phase"), Path("some/Walk04_000_mirror.phase"))
