"""How the notebook of the played character shows what it measured: tables, tracks, motions."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy import ndarray

from stylephase.evaluation.crowd import Crowd
from stylephase.evaluation.looks import Looks
from stylephase.evaluation.steered import NEAR, Aside, Going
from stylephase.features.body import Body
from stylephase.features.layout import FPS
from stylephase.models.bundle import Bundle
from stylephase.report import palette, plots
from stylephase.report.render.motion import Motion
from stylephase.report.walks import walking_motion
from stylephase.runtime.controller import State
from stylephase.runtime.mixtures import around
from stylephase.runtime.plans import heading
from stylephase.runtime.player import Player
from stylephase.runtime.rollout import as_rollout
from stylephase.runtime.viewer.frames import frame_numbers
from stylephase.runtime.viewer.widget import RECORDED_FPS

# Length (m) of the stroke that says where a character faces.
_STROKE = 0.6
# Keys that are held, and for how many seconds.
Script = Sequence[tuple[str | list[str], float | int]]


def scripted(player: Player, script: Script) -> list[State]:
    """States while keys are held, each group for some seconds."""
    states = []
    for keys, seconds in script:
        player.hold(list(keys))
        states += [player.step() for _ in range(int(seconds * FPS))]
    player.hold(())
    return states


def held_at_each(script: Script) -> list[str]:
    """What is held in each frame of `scripted`, as one writes it: `Shift W`, and `no key`."""
    words = [" ".join(key.title() for key in sorted(keys, key=len, reverse=True)) or "no key" for keys, _ in script]
    return [word for word, (_, seconds) in zip(words, script, strict=True) for _ in range(int(seconds * FPS))]


def track_plot(states: Sequence[State], held: Sequence[str]) -> Axes:
    """The way from above, one colour for what is held, and every half second a stroke as the character faces."""
    run = as_rollout(states)
    places, angles = run.root_positions[:, 0], run.root_angles[:, 0]
    changes = [0, *(k for k in range(1, len(held)) if held[k] != held[k - 1]), len(held)]
    with plots.style():
        axes = Figure(figsize=(7.2, 3.2)).subplots()
        for k, (first, last) in enumerate(pairwise(changes)):
            colour = palette.SEQUENCE[k % len(palette.SEQUENCE)]
            part = places[first : last + 1]
            # Ahead is to the right, so that a long way fits; the character's left is then above.
            axes.plot(part[:, 1], part[:, 0], color=colour, linewidth=2.4, label=held[first])
            at = slice(first, last, int(FPS / 2))
            ends = places[at] + _STROKE * heading(angles[at])
            axes.plot(places[at, 1], places[at, 0], "o", color=colour, markersize=4)
            axes.plot(*np.stack([places[at], ends])[..., ::-1].transpose(2, 0, 1), color=palette.INK, linewidth=0.9)
        axes.plot(*places[0, ::-1], "o", color=palette.INK, markersize=6, label="start")
        axes.set(xlabel="ahead (m)", ylabel="to the left (m)")
        axes.set_aspect("equal")
        axes.legend(loc="upper left", bbox_to_anchor=(1.02, 1))
    return axes


def round_trip(player: Player, styles: Sequence[str], seconds: float) -> list[State]:
    """States of a walk ahead while the mixture goes round the triangle once, corner by corner."""
    player.choose(styles)
    player.hold("w")
    states, frames = [], int(seconds * FPS)
    for frame in range(frames):
        player.mix(around(3 * frame / frames))
        states.append(player.step())
    player.hold(())
    return states


def motion_of(states: Sequence[State], body: Body, label: str) -> Motion:
    """States of one character as a motion to draw."""
    return walking_motion(as_rollout(states), 0, body, label)


def crowd_motions(crowd: Crowd, bundle: Bundle) -> list[Motion]:
    """The last second of each style of a crowd that stays finite, to draw."""
    last = int(FPS)
    walks = [walking_motion(crowd.run, k, bundle.body, s) for k, s in enumerate(bundle.styles) if crowd.run.finite[k]]
    return [walk.frames(len(walk) - last, len(walk)) for walk in walks]


def recording(states: Sequence[State], seconds: float = 6.0) -> Float[ndarray, "frames values"]:
    """Frames for the viewer to play when no kernel answers."""
    step = int(FPS / RECORDED_FPS)
    shown, roots = states[: int(seconds * FPS)], as_rollout(states).root_positions[:, 0]
    speeds = np.linalg.norm(np.gradient(roots, axis=0), axis=1) * FPS
    return np.stack([frame_numbers(state, float(v)) for state, v in zip(shown, speeds, strict=False)][::step])


def speed_table(styles: Sequence[str], wanted: ndarray, gains: ndarray, reached: ndarray) -> str:
    """A Markdown table of speeds."""
    lines = ["| style | wanted m/s | gain | reached m/s | off % |", "|---" * 5 + "|"]
    for style, w, g, r in zip(styles, wanted, gains, reached, strict=True):
        lines.append(f"| {style} | {w:.2f} | {g:.2f} | {r:.2f} | {100 * (r / w - 1):+.0f} |")
    return "\n".join(lines)


def looks_table(looks: Mapping[str, Looks], recorded: Float[ndarray, " styles"]) -> str:
    """A Markdown table of what is seen of each way of finishing: median and most over the styles."""
    heads = "| | slide in contact m/s | largest acceleration, of the recorded | bones off mm |"
    lines = [heads, "|---" * 4 + "|"]
    for name, found in looks.items():
        parts = found.skate, found.acceleration / recorded
        cells = [f"{np.median(part):.3f}, at most {part.max():.3f}" for part in parts]
        lines.append(f"| {name} | {cells[0]} | {cells[1]} | at most {found.bones.max():.1f} |")
    return "\n".join(lines)


def reached_by_gait(gaits: Sequence[str], ratios: Float[ndarray, " speeds"]) -> dict[str, tuple[int, int]]:
    """Of each gait, how many speeds are reached within NEAR, and how many there are; ratios are reached over wanted."""
    near, names = np.abs(ratios - 1) <= NEAR, np.array(gaits)
    return {gait: (int(near[names == gait].sum()), int((names == gait).sum())) for gait in dict.fromkeys(gaits)}


def aside_table(found: Sequence[Aside]) -> str:
    """A Markdown table, a row for each gait: medians over styles of angles (degrees to the left) and speeds (m/s)."""
    lines = ["| gait | takes | ours | led ahead | as the takes go |", "|---" * 5 + "|"]
    for gait in dict.fromkeys(one.gait for one in found):
        rows = [one for one in found if one.gait == gait]
        cells = [_median([getattr(one, part) for one in rows]) for part in ("data", "ours", "ahead")]
        lines.append(f"| {gait} | {' | '.join(cells)} | {sum(one.reached for one in rows)} of {len(rows)} |")
    return "\n".join(lines)


def _median(goings: Sequence[Going]) -> str:
    angle = np.degrees(np.median([abs(how.angle) for how in goings]))
    return f"{angle:.0f}° aside at {np.median([how.speed for how in goings]):.2f} m/s"


def triples(styles: Sequence[str], most: int = 7, seed: int = 0) -> list[tuple[str, str, str]]:
    """Threes of styles without one twice, drawn by chance; one of repeated styles where there are fewer than three."""
    drawn = [styles[int(k)] for k in np.random.default_rng(seed).permutation(len(styles))]
    found = [(drawn[k], drawn[k + 1], drawn[k + 2]) for k in range(0, len(drawn) - 2, 3)]
    return found[:most] or [(drawn[0], drawn[-1], drawn[0])]
