"""Pictures of blends and of new styles: what is drawn is what was found."""

import numpy as np
import tiny_walker as tiny

from stylephase.evaluation.interpolation import SHARES, blend_of
from stylephase.report.blends import along_motion, along_plot, triangle_plot
from stylephase.report.new_styles import code_maps
from stylephase.report.show import markdown_table
from stylephase.runtime.rollout import Rollout


def walked() -> Rollout:
    """The walker and one that stands in the same pose: right foot down from frame 200 on, and never."""
    take = tiny.take("Plain")
    joints = list(tiny.BODY.joints)
    positions = np.repeat(take.pose.positions[:300, None, joints], 2, axis=1)
    rotations = np.repeat((take.pose.rotations[:300, joints] @ tiny.BODY.rest[joints])[:, None], 2, axis=1)
    contacts = np.zeros((300, 2, 2))
    contacts[200:, 0, 0] = 1
    return Rollout(positions, rotations, positions[:, :, 0, ::2], np.zeros((300, 2)), contacts, np.zeros((300, 2, 8)))


def test_each_character_is_shown_where_its_right_foot_came_down_last():
    run = walked()
    motion = along_motion(run, range(2), tiny.BODY, "two")
    assert len(motion) == 2 and motion.label == "two"
    pose = tiny.take("Plain").pose.positions
    for shown, frame in zip(motion.positions, (200, 299), strict=True):
        expected = pose[frame] - pose[frame, 0] * [1, 0, 1]
        np.testing.assert_allclose(shown, expected, atol=1e-6)


def test_every_pair_has_its_line_and_every_model_its_panel():
    blends = [blend_of(share[:, None] * np.ones(3), SHARES, SHARES) for share in (SHARES, SHARES**2)]
    panels = along_plot({"lpn-onehot": blends, "lpn-film": blends[:1]})
    assert [axes.get_title(loc="left") for axes in panels] == ["lpn-onehot", "lpn-film"]
    # An even blend, the pairs, their median.
    assert [len(axes.lines) for axes in panels] == [4, 3]
    np.testing.assert_allclose(np.asarray(panels[0].lines[2].get_ydata(), dtype=float), SHARES**2)


def test_the_triangle_leads_from_what_was_asked_to_what_came_out():
    asked, found = np.eye(3), np.full((3, 3), 1 / 3)
    axes = triangle_plot(asked, found, ["a", "b", "c"])
    assert [text.get_text() for text in axes.texts] == ["a", "b", "c"]
    ends = np.array([np.asarray(line.get_xydata())[-1] for line in axes.lines])
    np.testing.assert_allclose(ends, np.tile([0.5, np.sqrt(0.75) / 3], (3, 1)))


def test_new_styles_stand_out_and_known_ones_share_a_name():
    places, labels = np.random.default_rng(0).normal(size=(6, 2)), ["Old", "Old", "Sad", "Sad", "New", "New"]
    panels = code_maps({"before": (places, labels), "after": (places[::-1], labels)}, ["New"])
    assert len(panels) == 2
    _, names = panels[0].get_legend_handles_labels()
    assert names == ["known styles", "New"]
    drawn = panels[0].collections[-1].get_offsets()
    np.testing.assert_allclose(np.asarray(drawn), places[4:])


def test_a_table_has_a_row_for_each_name():
    lines = markdown_table(["one", "two"], {"a": [1.23456, "word"], "b": [0.001, 20.0]}).splitlines()
    assert lines == ["| | one | two |", "|---|---|---|", "| a | 1.23 | word |", "| b | 0.001 | 20 |"]
