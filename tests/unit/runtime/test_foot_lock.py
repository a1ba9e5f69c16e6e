"""A foot in contact stays put, and finds back smoothly."""

import numpy as np
import pytest

from stylephase.runtime.foot_lock import Feet, LockSettings, free_feet, step_feet

_FPS = 60.0


def _run(places: np.ndarray, contacts: np.ndarray, settings: LockSettings | None = None) -> list[Feet]:
    """Feet over frames; `places` are (frames, characters, 2, 2)."""
    feet = [free_feet(places[0])]
    for place, contact in zip(places[1:], contacts[1:], strict=True):
        feet.append(step_feet(feet[-1], place, contact, settings or LockSettings()))
    return feet


@pytest.fixture(scope="module")
def sliding(frozen) -> tuple[np.ndarray, np.ndarray]:
    """Two characters whose feet slide at 0.2 m/s, in contact from frame 40 to 80."""
    frames = np.arange(140)
    places = np.zeros((140, 2, 2, 2))
    places[..., 1] = (0.2 * frames / _FPS)[:, None, None]
    places[:, 1, :, 0] = 5.0
    contacts = np.zeros((140, 2, 2))
    contacts[40:80] = 1.0
    return frozen(places), frozen(contacts)


def _places(feet: list[Feet]) -> np.ndarray:
    return np.stack([f.places for f in feet])


def test_free_feet_are_the_predicted_ones(sliding):
    places, contacts = sliding
    np.testing.assert_allclose(_places(_run(places, 0 * contacts)), places, atol=1e-12)


def test_a_foot_in_contact_stays_put(sliding):
    places = _places(_run(*sliding))
    speed = np.linalg.norm(np.diff(places[40:80], axis=0), axis=-1) * _FPS
    assert speed[5:].max() < 1e-3 and speed.mean() < 0.02


def test_held_and_released_feet_do_not_jump(sliding):
    """The way back of 13 cm is made in a few tenths of a second; in one frame it would be at 8 m/s."""
    places = _places(_run(*sliding))
    speed = np.linalg.norm(np.diff(places, axis=0), axis=-1) * _FPS
    late = sliding[0] - places
    assert speed.max() < 1.5 and np.abs(np.diff(speed, axis=0)).max() < 0.6
    assert np.linalg.norm(late[79], axis=-1).min() > 0.1
    assert np.linalg.norm(late[79 + 50], axis=-1).max() < 0.002


def test_a_foot_is_not_held_beyond_its_stretch(sliding):
    places = _places(_run(*sliding, LockSettings(stretch=0.05)))
    assert np.linalg.norm(sliding[0] - places, axis=-1).max() < 0.06


def test_a_contact_that_wavers_between_the_thresholds_lets_nothing_go(sliding):
    places, contacts = sliding
    wavering = np.where(np.arange(140)[:, None, None] % 2, contacts, 0.45 * contacts)
    held = np.stack([feet.held for feet in _run(places, wavering)])
    assert held[42:80].all() and not held[80:].any()


def test_characters_do_not_disturb_each_other(sliding):
    places, contacts = sliding
    alone = _places(_run(places[:, 1:], contacts[:, 1:]))
    np.testing.assert_array_equal(_places(_run(places, contacts))[:, 1:], alone)


def test_mirrored_feet_are_held_as_in_a_mirror(sliding):
    places, contacts = sliding
    uneven = contacts * np.array([1.0, 0.0])
    image = _places(_run(places[:, :, ::-1] * [-1, 1], uneven[:, :, ::-1]))
    np.testing.assert_allclose(image[:, :, ::-1] * [-1, 1], _places(_run(places, uneven)), atol=1e-12)
