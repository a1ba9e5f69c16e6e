"""One run that nothing interrupted, to compare the others with."""

from pathlib import Path

import pytest
import tiny_training as tiny

from stylephase.models.bundle import Bundle


@pytest.fixture(scope="session")
def whole(tmp_path_factory) -> tuple[Path, Bundle, list[dict]]:
    """Folder, trained model and log of the tiny preset's run with seed 0."""
    out, run = tmp_path_factory.mktemp("whole") / "run", tiny.trainer()
    return out, run.run(out, tiny.ignore), run.log
