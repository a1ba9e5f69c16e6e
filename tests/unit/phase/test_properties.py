"""What phases of a take should not care about: when it begins, how fast it is played, which side is which, noise."""

from dataclasses import replace
from functools import cache

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from stylephase.motion.clip import Clip
from stylephase.motion.contacts import ContactRule
from stylephase.motion.synthetic import find_style, steady, walk
from stylephase.phase.circular import distance
from stylephase.phase.local import VARIANTS, variant
from stylephase.phase.take import TakePhases, take_phases

RULE, LOOSE = ContactRule(speed=0.03, height=0.02), ContactRule(speed=0.5, height=0.03)
# One that walks as most do, one whose arms have a beat of their own, one with cycles of two seconds, one that drags.
STYLES = st.sampled_from(["Plain", "OffbeatArms", "StoopedOver", "DraggedLeft"])
# Windows reach over the ends.
INSIDE = slice(60, -60)


@cache
def walked(name: str) -> Clip:
    style = find_style(name)
    return walk(style, "FW", plan=steady(7.0, forward=style.speed))[0]


@cache
def found(name: str, how: str, rule: ContactRule = RULE) -> TakePhases:
    return take_phases(walked(name), rule, variant(how))


@given(name=STYLES, dropped=st.integers(1, 90), how=st.sampled_from(sorted(VARIANTS)))
@settings(max_examples=8)
def test_when_a_take_begins_does_not_matter(name, dropped, how):
    """Protects against time counted from the first frame: a fit, a tempo or a window that remembers where it began."""
    clip = walked(name)
    later = take_phases(clip.frames(dropped, len(clip)), RULE, variant(how)).local
    assert distance(found(name, how).local.phase[dropped:], later.phase)[INSIDE].max() < 0.02
    own = found(name, how).local.magnitude[dropped:]
    assert np.median(np.abs(own - later.magnitude)[INSIDE]) < 0.01 * own.max()


@given(name=STYLES, speed=st.floats(0.5, 2.0))
@settings(max_examples=8)
def test_how_fast_a_take_is_played_does_not_matter_at_its_own_tempo(name, speed):
    """Protects the variant `adaptive` against windows of fixed length: a slow walk has the phases of a fast one."""
    played = take_phases(
        replace(walked(name), fps=60 * speed), replace(RULE, speed=RULE.speed * speed), variant("adaptive")
    )
    own = found(name, "adaptive").local
    assert np.percentile(distance(own.phase, played.local.phase)[INSIDE], 99) < 0.02
    moving = own.magnitude[INSIDE] > 0.1
    ratio = played.local.frequency[INSIDE][moving] / own.frequency[INSIDE][moving]
    assert np.allclose(np.median(ratio), speed, rtol=0.02)


@given(speed=st.floats(0.5, 0.75))
@settings(max_examples=4)
def test_how_fast_a_take_is_played_matters_to_the_windows_of_the_release(speed):
    """Protects the check above: a measure that no phase could fail would show nothing."""
    name = "StoopedOver"
    played = take_phases(
        replace(walked(name), fps=60 * speed), replace(RULE, speed=RULE.speed * speed), variant("release")
    )
    apart = distance(found(name, "release").local.phase, played.local.phase)[INSIDE]
    assert np.percentile(apart, 90) > 0.1


def mirrored(clip: Clip) -> Clip:
    partner = clip.skeleton.mirrored
    return replace(
        clip,
        skeleton=replace(clip.skeleton, offsets=clip.skeleton.offsets[partner] * [-1.0, 1.0, 1.0]),
        rotations=clip.rotations[:, partner] * [1.0, 1.0, -1.0, -1.0],
        root_positions=clip.root_positions * [-1, 1, 1],
    )


@given(name=STYLES, how=st.sampled_from(sorted(VARIANTS)), start=st.integers(0, 200))
@settings(max_examples=8)
def test_a_mirrored_take_has_left_and_right_swapped(name, how, start):
    """Protects the training on mirrored takes, whose phases are swapped and not read again."""
    clip, swap = walked(name).frames(start, start + 200), [1, 0, 3, 2]
    own, other = (take_phases(c, RULE, variant(how)) for c in (clip, mirrored(clip)))
    assert np.array_equal(other.contacts, own.contacts[:, ::-1])
    clear = own.local.magnitude > 0.05
    assert distance(other.local.phase[:, swap], own.local.phase)[clear].max() < 1e-6
    assert np.allclose(other.local.magnitude[:, swap], own.local.magnitude, atol=1e-6)


def noisy(clip: Clip, degrees: float, seed: int) -> Clip:
    """The clip with every joint turned a little, anew in every frame."""
    turns = np.random.default_rng(seed).normal(0, np.radians(degrees), (*clip.rotations.shape[:2], 3))
    own = Rotation.from_quat(clip.rotations.reshape(-1, 4), scalar_first=True)
    turned = Rotation.from_rotvec(turns.reshape(-1, 3)) * own
    return replace(clip, rotations=turned.as_quat(scalar_first=True).reshape(clip.rotations.shape))


@given(name=STYLES, how=st.sampled_from(["adaptive", "release"]), seed=st.integers(0, 99))
@settings(max_examples=6)
def test_noise_moves_phases_a_little(name, how, seed):
    """Protects against sources that blow small errors up: a degree for hands, a twentieth for feet.

    Feet bear less: noise of a degree is a speed of a metre a second at the toes, and leaves no contact to be found.
    """
    own = found(name, how, LOOSE).local
    for degrees, part in ((1.0, slice(0, 2)), (0.05, slice(2, 4))):
        other = take_phases(noisy(walked(name), degrees, seed), LOOSE, variant(how)).local
        clear = own.magnitude[INSIDE, part] > 0.3
        apart = distance(own.phase[INSIDE, part], other.phase[INSIDE, part])[clear]
        assert np.median(apart) < 0.02 and np.percentile(apart, 90) < 0.06
