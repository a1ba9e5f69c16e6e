"""Notebook 09 in JupyterLab in headless Chromium: its first cells give a zombie to drive."""

import os
import time
from collections.abc import Iterator
from pathlib import Path

import jupytext
import numpy as np
import pytest
from devtools import CHROMIUM
from labs import Lab, opened, telling

# CI installs one, so there its absence is a failure.
pytestmark = pytest.mark.skipif(
    CHROMIUM is None and not os.environ.get("CI"), reason="needs a browser: apt-get install chromium"
)


@pytest.fixture(scope="module")
def zombie(root, tmp_path_factory) -> Iterator[Lab]:
    """The cells of notebook 09 as far as its first viewer, as anybody runs them."""
    folder = tmp_path_factory.mktemp("zombie")
    cells = [cell.source for cell in jupytext.read(root / "notebooks/09_play.py").cells if cell.cell_type == "code"]
    first = next(k for k, cell in enumerate(cells) if "Viewer(" in cell)
    with opened(folder, [*cells[: first + 1], telling(folder)], 1) as found:
        yield found


def _looks(lab: Lab, seconds: float = 1.5) -> np.ndarray:
    """Mean heights (m) of the joints for a while: what a style looks like wherever it walks."""
    end, seen = time.monotonic() + seconds, []
    while time.monotonic() < end:
        seen.append(lab.told()["heights"])
        time.sleep(0.02)
    return np.mean(seen, axis=0)


def test_a_zombie_is_driven_within_a_minute_by_the_first_cells_of_the_notebook(zombie):
    """The weights that lie with the code: W makes it walk, and the triangle makes it another character."""
    zombie.wait(lambda told: told["running"])
    assert zombie.seconds < 60
    # The red dot is drawn where the mixture is: at the left corner.
    middle = zombie.page.js(
        "(() => { const c = document.querySelector('.sp-triangle'), d = c.getContext('2d').getImageData(0, 0, c.width,"
        " c.height).data; let x = 0, n = 0; for (let i = 0; i < d.length; i += 4) if (d[i] === 0xC2"
        " && d[i + 1] === 0x18 && d[i + 2] === 0x5B) { x += (i / 4) % c.width; n += 1; } return x / n / c.width })()"
    )
    assert middle < 0.2
    zombie.click()
    delays = [zombie.delay(0.6) for _ in range(5)]
    assert np.median(delays) < 0.1, delays
    zombie.page.key("KeyW", down=True)
    time.sleep(1.0)
    place, alike = zombie.told()["place"], [_looks(zombie), _looks(zombie)]
    assert np.linalg.norm(np.subtract(zombie.told()["place"], place)) > 1.0
    zombie.page.picture(Path(os.environ.get("STYLEPHASE_SHOT", zombie.out.parent / "shot.png")))
    x, y = zombie.middle(".sp-triangle")
    zombie.page.drag((x, y), (x + 30, y + 30), (x + 60, y + 60))
    zombie.wait(lambda told: told["point"][0] > 0.7)
    time.sleep(1.0)
    other = np.abs(_looks(zombie) - alike[1]).max()
    assert other > 0.04 and other > 2 * np.abs(alike[1] - alike[0]).max()
    zombie.page.key("KeyW", down=False)
