"""The widget: frames go out at 60 a second, and keys, styles, speed and drawn paths come in."""

import asyncio
import contextlib
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import anywidget
import numpy as np
import traitlets
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.features.layout import FPS
from stylephase.runtime.player import Player
from stylephase.runtime.viewer.frames import body_shape, frame_layout, frame_numbers

_HERE = Path(__file__).parent
# A view not heard of for so long (s) is gone: its cell was run again or cleared, its page closed or hidden.
_SILENCE = 2.5
# What is late by more than this (s) is left out, not made up for.
_LATE = 0.25
# What tells that a word cannot be followed.
_REFUSED = (InputError, TypeError, ValueError)
# Frames a second of a recording.
RECORDED_FPS = 30
# The speed shown is that of the last so many frames.
_SPEED_FRAMES = 30


class Viewer(anywidget.AnyWidget):
    """A window on a player's character.

    It runs while a view is heard of, from an asyncio task of the kernel, and stops by its button, by `stop`, and when
    the view is gone. `recording` holds frames that are played over and over where no kernel answers.
    """

    _esm = _HERE / "viewer.js"
    _css = _HERE / "viewer.css"
    shape = traitlets.Dict().tag(sync=True)
    styles = traitlets.List().tag(sync=True)
    chosen = traitlets.List().tag(sync=True)
    recording = traitlets.Bytes(b"").tag(sync=True)
    problem = traitlets.Unicode("").tag(sync=True)

    def __init__(self, player: Player, *, recording: Float[ndarray, "frames values"] | None = None):
        self.player, self.sent, self._heard = player, 0, float("-inf")
        self._task: asyncio.Task[None] | None = None
        self._choosing, self._choices = set[asyncio.Task[None]](), 0
        self._track = [player.state.path.root.positions[0]] * _SPEED_FRAMES
        body = player.walker.body
        shape = body_shape(body) | {"layout": frame_layout(len(body.joints)), "speed": player.speed}
        shape |= {"point": player.point.tolist(), "recorded_fps": RECORDED_FPS}
        kept = b"" if recording is None else recording.astype(np.float16).tobytes()
        super().__init__(shape=shape, styles=list(player.walker.styles), chosen=list(player.styles), recording=kept)
        self.on_msg(lambda _, content, buffers: self.receive(content))

    @property
    def running(self) -> bool:
        """Whether frames go out."""
        return self._task is not None and not self._task.done()

    def receive(self, content: Mapping[str, Any]) -> None:
        """What a view says. A word that cannot be followed is shown in `problem`, and nothing else changes."""
        try:
            self._answer(str(content.get("kind")), content.get("value"))
        except _REFUSED as error:
            self.problem = str(error)
        else:
            # A view says that it is there twice a second, which answers no problem.
            if content.get("kind") != "alive":
                self.problem = ""

    def _answer(self, kind: str, value: Any) -> None:
        answers: dict[str, Callable[[Any], None]] = {
            "alive": lambda _: self._alive(),
            "stop": lambda _: self.stop(),
            "keys": self.player.hold,
            "mix": self.player.mix,
            "speed": lambda speed: setattr(self.player, "speed", speed),
            "styles": self._choose,
            "path": self.player.follow,
            "reset": lambda _: self.player.reset(),
        }
        if kind not in answers:
            raise InputError(f"no message {kind!r}; there are {', '.join(answers)}")
        answers[kind](value)

    def _alive(self) -> None:
        self._heard = time.monotonic()
        if not self.running:
            self._task = asyncio.get_running_loop().create_task(self._run())

    def _choose(self, styles: Any) -> None:
        """Measure new styles on a thread while the character walks on, then take them, unless others are chosen since.

        What goes wrong while they are measured is shown in `problem`.
        """
        styles, self._choices = self.player.three(styles), self._choices + 1
        choice = self._choices

        async def measured() -> None:
            try:
                await asyncio.to_thread(self.player.measure, styles)
                if choice != self._choices:
                    return
                self.player.choose(styles)
            except _REFUSED as error:
                if choice == self._choices:
                    self.problem = str(error)
            else:
                self.chosen = list(styles)

        # A task that nothing refers to may be dropped before its end.
        task = asyncio.get_running_loop().create_task(measured())
        self._choosing.add(task)
        task.add_done_callback(self._choosing.discard)

    def stop(self) -> None:
        """Send no more frames, until a view is opened or started again."""
        self._heard = float("-inf")
        self.player.hold(())
        if self._task is not None:
            self._task.cancel()
            self._task = None

    def close(self) -> None:
        """Stop for good."""
        self.stop()
        super().close()

    async def _run(self) -> None:
        """A frame every 1/60 s by the clock; what takes too long is left out."""
        due = time.monotonic()
        with contextlib.suppress(asyncio.CancelledError):
            while time.monotonic() - self._heard < _SILENCE:
                self.tick()
                due = max(due + 1 / FPS, time.monotonic() - _LATE)
                await asyncio.sleep(max(0.0, due - time.monotonic()))
            self.player.hold(())

    def tick(self) -> None:
        """Make a frame and send it."""
        state = self.player.step()
        self._track = [*self._track[1:], state.path.root.positions[0]]
        speed = float(np.linalg.norm(self._track[-1] - self._track[0])) * FPS / (_SPEED_FRAMES - 1)
        numbers = frame_numbers(state, speed)
        self.send({"kind": "frame", "number": self.sent}, buffers=[numbers.tobytes()])
        self.sent += 1
