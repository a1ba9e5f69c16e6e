"""JupyterLab with a notebook in headless Chromium, and what the notebook's kernel says of its viewers."""

import json
import os
import secrets
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from urllib.error import URLError

import nbformat
from devtools import Page, browser

# What the kernel says of the viewers, again and again.
_TELL = """
import gc, json, os, threading, time
from stylephase.runtime.viewer import Viewer
views = globals().get("views") or [found for found in gc.get_objects() if isinstance(found, Viewer)]
def told():
    while True:
        out = [dict(sent=v.sent, running=v.running, held=sorted(v.player.held), point=list(v.player.point),
                    place=v.player.state.path.root.positions[0].tolist(),
                    heights=v.player.state.positions[0, :, 1].tolist(),
                    heard=time.time(), path=v.player.path is not None) for v in views]
        open({out!r} + ".new", "w").write(json.dumps(out))
        os.replace({out!r} + ".new", {out!r})
        time.sleep(0.005)
threading.Thread(target=told, daemon=True).start()
"""
PANEL = "jupyterapp.shell.currentWidget"


class Lab:
    """A page with JupyterLab and viewers, what the kernel says of them, and the seconds until they were there."""

    def __init__(self, page: Page, out: Path, seconds: float):
        self.page, self.out, self.seconds = page, out, seconds

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

    def click(self) -> None:
        """Give the first viewer the focus."""
        x, y = self.middle(".sp-stage")
        self.page.drag((x, y))

    def delay(self, seconds: float) -> float:
        """Hold W for some seconds; how long it took until the kernel knew."""
        start = time.monotonic()
        self.page.key("KeyW", down=True)
        self.wait(lambda told: told["held"] == ["w"])
        delay = time.monotonic() - start
        time.sleep(seconds)
        self.page.key("KeyW", down=False)
        self.wait(lambda told: told["held"] == [])
        return delay


def telling(folder: Path) -> str:
    """The code of a cell with which the kernel begins to say how its viewers are, into a file of the folder."""
    return _TELL.format(out=str(folder / "told.json"))


@contextmanager
def opened(folder: Path, cells: Sequence[str], viewers: int) -> Iterator[Lab]:
    """JupyterLab with a notebook of some cells, all run, of which one tells into the folder's `told.json`."""
    port, token, out = _free_port(), secrets.token_hex(8), folder / "told.json"
    notebook = nbformat.v4.new_notebook(metadata={"kernelspec": {"name": "python3", "display_name": "Python 3"}})
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
                page.wait(f"{PANEL}.sessionContext.session?.kernel?.status === 'idle'", 60)
                page.js("jupyterapp.commands.execute('notebook:run-all-cells')")
                start = time.monotonic()
                page.wait(f"document.querySelectorAll('.sp-viewer').length === {viewers}", 90)
                yield Lab(page, out, time.monotonic() - start)
        finally:
            server.terminate()


def _free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


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
