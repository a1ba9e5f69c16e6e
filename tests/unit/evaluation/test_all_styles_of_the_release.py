"""All styles of the release walk as was measured of them, but for the four that do not."""

import numpy as np
import pytest

from stylephase.evaluation.bench.frames import made_bundle
from stylephase.evaluation.motion import Bones, Steps
from stylephase.evaluation.release_walks import ReleaseWalk, own_contacts, release_walks
from stylephase.models.lpn import NetworkSettings
from stylephase.models.released import release_bundle

# Styles that stand, glide or tremble when asked to walk from the mean pose.
FAULTY = {"Drunk", "LeftHop", "RightHop", "TwoFootJump"}
# Speed (m/s), contact period (frames) and correlation of both feet, from another implementation of the release.
MEASURED = {
    "Neutral": (0.94, 79, -0.85),
    "Zombie": (1.05, 72, -0.85),
    "Swimming": (1.26, 61, -0.68),
    "PendulumHands": (1.21, 53, -0.66),
    "Proud": (1.34, 54, -0.70),
}


@pytest.fixture(scope="module")
def walks(mirror, tmp_path_factory) -> dict[str, ReleaseWalk]:
    """Every style's walk by name."""
    if not all((mirror / name).exists() for name in ("local-phases-release.tar.xz", "100style-excerpts.tar.xz")):
        pytest.skip("needs the release and a skeleton of 100STYLE: their archives are not in the mirror")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STYLEPHASE_MIRROR", str(mirror))
        patch.setenv("STYLEPHASE_CACHE", str(tmp_path_factory.mktemp("cache")))
        return {walk.style: walk for walk in release_walks(release_bundle())}


def test_four_styles_do_not_walk(walks):
    assert len(walks) == 100
    assert {name for name, walk in walks.items() if not walk.walks} == FAULTY


def test_the_others_walk_as_was_measured(walks):
    walking = [walk for name, walk in walks.items() if name not in FAULTY]
    assert all(walk.correlation < -0.3 and walk.finite for walk in walking)
    assert np.median([walk.speed for walk in walking]) == pytest.approx(1.15, abs=0.05)
    assert np.median([60 * walk.steps.cycle for walk in walking]) == pytest.approx(61.5, abs=3)
    assert np.median([walk.bones.median for walk in walking]) < 1.6
    assert np.median([walk.bones.drift for walk in walking]) < 3
    for name, (speed, frames, together) in MEASURED.items():
        assert walks[name].speed == pytest.approx(speed, rel=0.05)
        assert 60 * walks[name].steps.cycle == pytest.approx(frames, abs=3)
        assert walks[name].correlation == pytest.approx(together, abs=0.05)


def test_a_foot_is_down_by_the_range_of_its_own_values():
    values = np.stack([np.tile([0.6, 0.9], 10), np.tile([0.02, 0.05], 10)], axis=1)
    found = own_contacts(values)
    assert found[:, 0].tolist() == [False, True] * 10 and not found[:, 1].any()


def test_walking_is_taking_turns_in_cycles_as_long_as_a_persons():
    bones = Bones(1.0, 2.0, 3.0, 1.0)
    walk = ReleaseWalk("made", 1.0, Steps(10, 1.0, 1.0), -0.8, bones, True)
    assert walk.walks
    assert not ReleaseWalk("made", 1.0, Steps(10, 1.0, 0.2), -0.8, bones, True).walks
    assert not ReleaseWalk("made", 1.0, Steps(10, 1.0, 1.0), 0.5, bones, True).walks
    assert not ReleaseWalk("made", 1.0, Steps(10, 1.0, 1.0), -0.8, bones, False).walks


def test_any_bundle_can_be_watched():
    bundle = made_bundle(NetworkSettings(experts=2, units=8, gating_units=4))
    assert [walk.style for walk in release_walks(bundle, frames=200)] == list(bundle.styles)
