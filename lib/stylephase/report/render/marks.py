"""Flat marks without light: discs under standing feet, the trajectory on the ground, rings around joints."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray

from stylephase.report import palette

_AROUND = 32
# Heights above the ground (m), one above the other so that none shows through.
SHADOW_HEIGHT, _PATH_HEIGHT, _CONTACT_HEIGHT = 0.002, 0.004, 0.006
_LIGHT = np.array([0.2, 1.0, -0.1])
_CONTACT_RADIUS, _ARROW = 0.17, 0.13
_RING = (0.10, 0.122)
_RING_NEARER = 0.6


class Flat(NamedTuple):
    """Triangles with one colour per corner."""

    points: Float[ndarray, "points 3"]
    triangles: Int[ndarray, "triangles 3"]
    colours: UInt8[ndarray, "points 3"]


def joined(flats: list[Flat]) -> Flat:
    """All marks as one. A triangle without extent comes first, since a mesh without points can carry no colours."""
    flats = [_fan(np.zeros((3, 3)), palette.BACKGROUND), *flats]
    starts = np.cumsum([0, *(len(flat.points) for flat in flats)])
    return Flat(
        np.concatenate([flat.points for flat in flats]),
        np.concatenate([flat.triangles + start for flat, start in zip(flats, starts, strict=False)]),
        np.concatenate([flat.colours for flat in flats]),
    )


def shadow(points: Float[ndarray, "points 3"]) -> Float[ndarray, "points 3"]:
    """The points thrown onto the ground by a light from above, a little aside so that a raised foot parts from it."""
    thrown = points - points[:, 1:2] * _LIGHT
    thrown[:, 1] = SHADOW_HEIGHT
    return thrown


def contact_discs(feet: Float[ndarray, "2 3"], contacts: Float[ndarray, " 2"]) -> list[Flat]:
    """A disc in the colour of the side under each foot that stands. Feet and contacts are (right, left)."""
    colours = (palette.RIGHT, palette.LEFT)
    return [
        _disc(foot[[0, 2]], _CONTACT_RADIUS, _CONTACT_HEIGHT, palette.lighter(colour, 0.45))
        for foot, contact, colour in zip(feet, contacts, colours, strict=True)
        if contact > 0.5
    ]


def trajectory(path: Float[ndarray, "points 4"]) -> list[Flat]:
    """An arrowhead along the facing at each point of the trajectory, the past quiet and the future dark."""
    flats = []
    for k, (x, z, facing_x, facing_z) in enumerate(path):
        colour = palette.QUIET if k < len(path) // 2 else palette.INK
        ground, ahead, aside = np.array([x, z]), np.array([facing_x, facing_z]), np.array([facing_z, -facing_x])
        corners = ground + _ARROW * np.array([ahead / 2, -ahead / 2 - aside / 3, -ahead / 2 + aside / 3])
        flats.append(_fan(_raised(corners, _PATH_HEIGHT), colour))
    return flats


def rings(points: Float[ndarray, "rings 3"], toward: Float[ndarray, " 3"]) -> list[Flat]:
    """A ring around each point that faces the eye, drawn nearer to it so that no limb hides it."""
    beside = np.cross([0.0, 1.0, 0.0], toward)
    beside /= np.linalg.norm(beside)
    plane = np.stack([beside, np.cross(toward, beside)])
    return [_ring(point + _RING_NEARER * toward, plane) for point in points]


def _circle(count: int = _AROUND) -> Float[ndarray, "corners 2"]:
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def _raised(ground: Float[ndarray, "points 2"], height: float) -> Float[ndarray, "points 3"]:
    """Points (x, z) at a height above the ground."""
    return np.stack([ground[:, 0], np.full(len(ground), height), ground[:, 1]], axis=1)


def _disc(ground: Float[ndarray, " 2"], radius: float, height: float, colour: str) -> Flat:
    return _fan(_raised(ground + radius * _circle(), height), colour)


def _fan(corners: Float[ndarray, "corners 3"], colour: str) -> Flat:
    """A convex polygon."""
    later = np.arange(1, len(corners) - 1)
    return _flat(corners, np.stack([np.zeros_like(later), later, later + 1], axis=1), colour)


def _ring(centre: Float[ndarray, " 3"], plane: Float[ndarray, "2 3"]) -> Flat:
    inner, outer = (centre + radius * _circle() @ plane for radius in _RING)
    k = np.arange(_AROUND)
    after = (k + 1) % _AROUND
    triangles = np.concatenate(
        [np.stack([k, after, k + _AROUND], 1), np.stack([after, after + _AROUND, k + _AROUND], 1)]
    )
    return _flat(np.concatenate([inner, outer]), triangles, palette.HIGHLIGHT)


def _flat(points: ndarray, triangles: ndarray, colour: str) -> Flat:
    return Flat(points, triangles, np.tile(np.array(palette.rgb(colour), dtype=np.uint8), (len(points), 1)))
