"""Tables, tracks and motions of the played character."""

import numpy as np
import tiny_walker as tiny

from stylephase.evaluation.crowd import Crowd
from stylephase.evaluation.looks import Looks
from stylephase.report.played import (
    crowd_motions,
    held_at_each,
    looks_table,
    reached_by_gait,
    scripted,
    track_plot,
    triples,
)
from stylephase.runtime.plans import Steady
from stylephase.runtime.player import Player
from stylephase.runtime.rollout import roll_out
from stylephase.runtime.speeds import SpeedCurve

ROWS = 8


LINE = SpeedCurve(np.array([0.5, 2.0]), np.array([0.5, 2.0]))


def looks(skate: float, acceleration: float, bones: float = 0.0) -> Looks:
    steady = np.full(ROWS, 1.0) + 0.01 * np.arange(ROWS)
    return Looks(skate * steady, acceleration * steady, np.full(ROWS, bones), steady)


def test_speeds_are_counted_by_gait():
    found = reached_by_gait(["walk", "run", "walk"], np.array([1.05, 0.5, 1.2]))
    assert found == {"walk": (1, 2), "run": (0, 1)}


def test_a_table_has_a_row_for_each_way():
    seen = {"raw": looks(0.15, 30, 16.0), "finished": looks(0.001, 35)}
    lines = looks_table(seen, np.full(ROWS, 50.0)).splitlines()
    assert len(lines) == 4 and lines[2].startswith("| raw | 0.155, at most 0.161 | 0.621")


def test_threes_share_no_style_and_few_styles_make_one():
    found = triples([f"s{k}" for k in range(22)])
    assert len(found) == 7 and len({style for three in found for style in three}) == 21
    assert len(triples(["a", "b"])) == 1


def test_the_way_from_above_has_a_colour_for_what_is_held():
    script = [("w", 0.5), (["w", "shift"], 0.5), ("", 0.25)]
    player = Player(tiny.bundle(network=tiny.Obedient()), tiny.STYLES[:3], curves=dict.fromkeys(tiny.STYLES[:3], LINE))
    states, held = scripted(player, script), held_at_each(script)
    assert [held[k] for k in (0, 29, 30, 59, 60)] == ["W", "W", "Shift W", "Shift W", "no key"]
    assert len(held) == len(states) == 75
    axes = track_plot(states, held)
    names = [text.get_text() for text in axes.get_legend().get_texts()]
    assert names == ["W", "Shift W", "no key", "start"]


def test_of_a_crowd_the_last_second_of_each_is_drawn():
    bundle = tiny.bundle(network=tiny.Obedient())
    count = len(bundle.styles)
    run = roll_out(bundle, tiny.codes(count), tiny.start([0] * count), 90, Steady(np.ones(count)))
    run.positions[-1, 0] = np.nan
    drawn = crowd_motions(Crowd(0, 0, count, run), bundle)
    assert [len(motion) for motion in drawn] == [60] * (count - 1)
