"""Pictures of style transfer: whole skeletons from feature joints, and the plots."""

import numpy as np
from tiny_walker import BODY, take

from stylephase.report.transferred import distances_plot, motion_of, paths_plot


def test_end_sites_lie_in_line_with_their_bone_as_far_as_they_are():
    joints = take().pose.positions[:10, list(BODY.joints)]
    motion = motion_of(joints, BODY, "walk")
    np.testing.assert_array_equal(motion.positions[:, list(BODY.joints)], joints)
    sites = [joint for joint in range(len(BODY.skeleton)) if joint not in BODY.joints]
    assert sites
    for site in sites:
        bone = motion.positions[:, site] - motion.positions[:, BODY.skeleton.parents[site]]
        np.testing.assert_allclose(np.linalg.norm(bone, axis=1), np.linalg.norm(BODY.skeleton.offsets[site]))


def test_styles_stand_in_the_order_of_the_first_motion():
    axes = distances_plot({"a": np.array([3.0, 1.0]), "b": np.array([2.0, 2.0])}, ["far", "near"])
    assert [label.get_text() for label in axes.get_yticklabels()] == ["near", "far"]


def test_paths_have_a_panel_each():
    path = np.stack([np.linspace(0, 1, 5), np.linspace(0, 2, 5)], axis=1)
    panels = paths_plot({"one": (path, path), "two": (path, 2 * path)}, ("asked", "walked"))
    assert [axes.get_title(loc="left") for axes in panels] == ["one", "two"]
    # The character's left, +x, is drawn at the left.
    np.testing.assert_allclose(np.asarray(panels[0].lines[0].get_xdata()), -path[:, 0])
