"""The live viewer in JupyterLab in headless Chromium: keys move the character, the triangle changes it, it stops."""

import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from devtools import CHROMIUM
from labs import PANEL, Lab, opened, telling

# CI installs one, so there its absence is a failure.
pytestmark = pytest.mark.skipif(
    CHROMIUM is None and not os.environ.get("CI"), reason="needs a browser: apt-get install chromium"
)
_CELL = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np, tiny_walker as tiny
from stylephase.runtime.player import Player
from stylephase.runtime.speeds import SpeedCurve
from stylephase.runtime.viewer import Viewer
curves = {{s: SpeedCurve(np.array([0.5, 2.0]), np.array([0.5, 2.0])) for s in tiny.STYLES}}
views = [Viewer(Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3], curves=curves)) for _ in range(2)]
"""


@pytest.fixture(scope="module")
def lab(root, tmp_path_factory) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("lab")
    with opened(
        folder, [_CELL.format(tests=str(root / "tests")) + telling(folder), "views[0]", "views[1]"], 2
    ) as found:
        yield found


def test_frames_go_out_at_60_a_second(lab):
    """By the median second: after a halt of the machine, late frames follow at once."""
    lab.wait(lambda told: told["running"])
    rates = []
    for _ in range(5):
        before, start = lab.told()["sent"], time.monotonic()
        time.sleep(1)
        rates.append((lab.told()["sent"] - before) / (time.monotonic() - start))
    assert 45 < np.median(rates) < 63, rates


def test_keys_act_within_a_tenth_of_a_second_and_move_one_character_only(lab):
    lab.click()
    other, delays = lab.told(1), [lab.delay(0.3) for _ in range(9)]
    assert np.median(delays) < 0.1, delays
    assert np.linalg.norm(lab.told()["place"]) > 0.3
    np.testing.assert_allclose(lab.told(1)["place"], other["place"], atol=0.05)


def test_keys_are_let_go_when_the_viewer_loses_the_focus(lab):
    lab.click()
    lab.page.key("KeyW", down=True)
    lab.wait(lambda told: told["held"] == ["w"])
    lab.page.js("document.activeElement.blur()")
    lab.wait(lambda told: told["held"] == [])
    lab.page.key("KeyW", down=False)


def test_dragging_the_triangle_changes_the_mixture(lab):
    before = lab.told()["point"]
    x, y = lab.middle(".sp-triangle")
    lab.page.drag((x, y), (x + 30, y + 30), (x + 60, y + 60))
    lab.wait(lambda told: told["point"][0] > 0.7)
    assert lab.told(1)["point"] == before


def test_a_path_drawn_on_the_ground_is_followed(lab):
    lab.page.js("document.querySelector('.sp-draw').click()")
    x, y = lab.middle(".sp-stage")
    lab.page.drag(*[(x - 150 + 10 * k, y + 120 - 3 * k) for k in range(30)])
    lab.wait(lambda told: told["path"])


def test_a_picture_is_drawn(lab, tmp_path):
    """The colours of both sides are on the canvas, and the picture changes while the character walks."""
    lab.click()
    lab.page.key("KeyW", down=True)
    time.sleep(0.6)
    data = "document.querySelector('.sp-stage').toDataURL()"
    first = lab.page.js(data)
    time.sleep(0.3)
    assert first != lab.page.js(data)
    pixels = lab.page.js(
        "(() => { const c = document.querySelector('.sp-stage'), d = c.getContext('2d').getImageData(0, 0, c.width,"
        " c.height).data; let l = 0, r = 0; for (let i = 0; i < d.length; i += 4) { l += d[i] === 0"
        " && d[i + 1] === 0x72 && d[i + 2] === 0xB2; "
        " r += d[i] === 0xD5 && d[i + 1] === 0x5E && d[i + 2] === 0; } return [l, r] })()"
    )
    lab.page.picture(Path(os.environ.get("STYLEPHASE_SHOT", tmp_path / "shot.png")))
    assert min(pixels) > 20
    lab.page.key("KeyW", down=False)


def test_no_request_leaves_the_machine(lab):
    names = lab.page.js("performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert names and all(name.startswith(("http://127.0.0.1:", "data:", "blob:")) for name in names)


def test_stopping_one_viewer_leaves_the_other_running(lab):
    lab.page.js("document.querySelectorAll('.sp-power')[0].click()")
    lab.wait(lambda told: not told["running"], 2.0)
    assert lab.told(1)["running"]
    lab.page.js("document.querySelectorAll('.sp-power')[0].click()")
    lab.wait(lambda told: told["running"])


def test_clearing_the_cells_stops_them_and_running_them_again_starts_them(lab):
    lab.page.js("jupyterapp.commands.execute('notebook:clear-all-cell-outputs')")
    for which in range(2):
        lab.wait(lambda told: not told["running"], 5.0, which)
    lab.page.js(f"{PANEL}.content.activeCellIndex = 1")
    lab.page.js("jupyterapp.commands.execute('notebook:run-all-below')")
    for which in range(2):
        lab.wait(lambda told: told["running"], 20.0, which)
