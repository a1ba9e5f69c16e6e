"""The live viewer in JupyterLab in headless Chromium: keys move the character, the triangle changes it, it stops."""

import json
import os
import secrets
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from urllib.error import URLError

import nbformat
import numpy as np
import pytest
from devtools import CHROMIUM, Page, browser

# CI installs one, so there its absence is a failure.
pytestmark = pytest.mark.skipif(
    CHROMIUM is None and not os.environ.get("CI"), reason="needs a browser: apt-get install chromium"
)
_CELL = """
import sys, json, threading, time
sys.path.insert(0, {tests!r})
import numpy as np, tiny_walker as tiny
from stylephase.runtime.player import Player
from stylephase.runtime.speeds import SpeedCurve
from stylephase.runtime.viewer import Viewer
curves = {{s: SpeedCurve(np.array([0.5, 2.0]), np.array([0.5, 2.0])) for s in tiny.STYLES}}
views = [Viewer(Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3], curves=curves)) for _ in range(2)]
def told():
    while True:
        out = [dict(sent=v.sent, running=v.running, held=sorted(v.player.held), point=list(v.player.point),
                    place=v.player.state.path.root.positions[0].tolist(),
                    heard=time.time(), path=v.player.path is not None) for v in views]
        open({out!r} + ".new", "w").write(json.dumps(out))
        import os; os.replace({out!r} + ".new", {out!r})
        time.sleep(0.005)
threading.Thread(target=told, daemon=True).start()
"""
_PANEL = "jupyterapp.shell.currentWidget"


class Lab:
    """A page with JupyterLab and its two viewers, and what the kernel says of them."""

    def __init__(self, page: Page, out: Path):
        self.page, self.out = page, out

    def told(self, which: int = 0) -> dict:
        return json.loads(self.out.read_text())[which]

    def wait(self, true, seconds: float = 10.0, which: int = 0) -> float:
        """Wait until `true` of what the kernel says of a viewer; seconds that it took."""
        start = time.monotonic()
        while time.monotonic() - start < seconds:
            if true(self.told(which)):
                return time.monotonic() - start
            time.sleep(0.002)
        raise AssertionError(self.told(which))

    def middle(self, selector: str, which: int = 0) -> tuple[float, float]:
        box = self.page.js(
            f"(() => {{ const e = document.querySelectorAll('{selector}')[{which}];"
            " e.scrollIntoView({block: 'center'});"
            " const r = e.getBoundingClientRect(); return [r.x, r.y, r.width, r.height] })()"
        )
        return box[0] + box[2] / 2, box[1] + box[3] / 2


def _free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


@pytest.fixture(scope="module")
def lab(root, tmp_path_factory) -> Iterator[Lab]:
    folder, port, token = tmp_path_factory.mktemp("lab"), _free_port(), secrets.token_hex(8)
    out = folder / "told.json"
    notebook = nbformat.v4.new_notebook(metadata={"kernelspec": {"name": "python3", "display_name": "Python 3"}})
    cells = [_CELL.format(tests=str(root / "tests"), out=str(out)), "views[0]", "views[1]"]
    notebook.cells = [nbformat.v4.new_code_cell(source) for source in cells]
    nbformat.write(notebook, folder / "play.ipynb")
    words = [sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root", f"--port={port}"]
    words += [f"--IdentityProvider.token={token}", "--LabApp.expose_app_in_browser=True", "--ServerApp.port_retries=0"]
    words += [f"--app-dir={found}"] if (found := os.environ.get("STYLEPHASE_LAB_APP")) else []
    with open(folder / "lab.log", "w") as log, subprocess.Popen(words, cwd=folder, stdout=log, stderr=log) as server:
        try:
            _answering(f"http://127.0.0.1:{port}/api?token={token}")
            url = f"http://127.0.0.1:{port}/lab/workspaces/{token}/tree/play.ipynb?reset&token={token}"
            with browser(folder, url) as page:
                page.wait("!!window.jupyterapp && !!document.querySelector('.jp-Notebook')", 90)
                page.js("jupyterapp.restored.then(() => 1)")
                page.wait(f"{_PANEL}.sessionContext.session?.kernel?.status === 'idle'", 60)
                page.js("jupyterapp.commands.execute('notebook:run-all-cells')")
                page.wait("document.querySelectorAll('.sp-viewer').length === 2", 90)
                yield Lab(page, out)
        finally:
            server.terminate()


def _answering(url: str) -> None:
    end = time.monotonic() + 60
    while time.monotonic() < end:
        try:
            urllib.request.urlopen(url).close()
        except URLError:
            time.sleep(0.2)
        else:
            return
    raise AssertionError("JupyterLab did not start")


def _clicked(lab: Lab) -> None:
    x, y = lab.middle(".sp-stage")
    lab.page.drag((x, y))


def test_frames_go_out_at_60_a_second(lab):
    lab.wait(lambda told: told["running"])
    before, start = lab.told()["sent"], time.monotonic()
    time.sleep(3)
    rate = (lab.told()["sent"] - before) / (time.monotonic() - start)
    assert 45 < rate < 62


def test_keys_act_within_a_tenth_of_a_second_and_move_one_character_only(lab):
    _clicked(lab)
    other, delays = lab.told(1), []
    for _ in range(5):
        start = time.monotonic()
        lab.page.key("KeyW", down=True)
        lab.wait(lambda told: told["held"] == ["w"])
        delays.append(time.monotonic() - start)
        time.sleep(0.3)
        lab.page.key("KeyW", down=False)
        lab.wait(lambda told: told["held"] == [])
    assert np.median(delays) < 0.1, delays
    assert np.linalg.norm(lab.told()["place"]) > 0.3
    np.testing.assert_allclose(lab.told(1)["place"], other["place"], atol=0.05)


def test_keys_are_let_go_when_the_viewer_loses_the_focus(lab):
    _clicked(lab)
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
    _clicked(lab)
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
    lab.page.js(f"{_PANEL}.content.activeCellIndex = 1")
    lab.page.js("jupyterapp.commands.execute('notebook:run-all-below')")
    for which in range(2):
        lab.wait(lambda told: told["running"], 20.0, which)
