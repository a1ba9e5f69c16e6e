"""From parts to one mesh: tapered shapes with round ends whose points are worked out anew for each frame."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int, UInt8
from numpy import ndarray

from stylephase.report import palette
from stylephase.report.render.body import Part

_AROUND = 16
_CAP = np.radians([0.0, 30.0, 60.0, 90.0])


@dataclass(frozen=True)
class Tube:
    """The unit shape that each part is a copy of, ring by ring.

    For each of its points: the end it belongs to (0 or 1), how far it stands out sideways and along the axis (as a
    share of the radius there), and its place around the axis (cosine, sine).
    """

    end: Int[ndarray, " points"]
    out: Float[ndarray, " points"]
    along: Float[ndarray, " points"]
    around: Float[ndarray, "points 2"]
    triangles: Int[ndarray, "triangles 3"]


def unit_tube() -> Tube:
    """A tube with hemispheres at both ends."""
    latitudes = np.concatenate([-_CAP[::-1], _CAP])
    angles = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)
    ring, turn = (grid.ravel() for grid in np.meshgrid(np.arange(len(latitudes)), np.arange(_AROUND), indexing="ij"))
    low = ring < len(latitudes) - 1
    here, beside = ring[low] * _AROUND + turn[low], ring[low] * _AROUND + (turn[low] + 1) % _AROUND
    triangles = np.concatenate(
        [np.stack([here, here + _AROUND, beside], 1), np.stack([beside, here + _AROUND, beside + _AROUND], 1)]
    )
    return Tube(
        end=(ring >= len(_CAP)).astype(int),
        out=np.cos(latitudes[ring]),
        along=np.sin(latitudes[ring]),
        around=np.stack([np.cos(angles[turn]), np.sin(angles[turn])], axis=1),
        triangles=triangles,
    )


class Surface:
    """One mesh for a whole body: triangles and colours once, points and normals for each frame."""

    def __init__(self, parts: list[Part]):
        tube = unit_tube()
        self._tube, size = tube, len(tube.end)
        self._ends = np.array([(part.start, part.stop) for part in parts])
        self._radii = np.array([part.radii for part in parts])
        self._axes = np.array([part.axis for part in parts])
        offsets = np.arange(len(parts))[:, None, None] * size
        self.triangles: Int[ndarray, "triangles 3"] = (tube.triangles + offsets).reshape(-1, 3)
        self.colours: UInt8[ndarray, "points 3"] = np.repeat(
            np.array([palette.rgb(part.colour) for part in parts], dtype=np.uint8), size, axis=0
        )

    def shape(
        self, points: Float[ndarray, "landmarks 3"], sideways: Float[ndarray, "axes 3"]
    ) -> tuple[Float[ndarray, "points 3"], Float[ndarray, "points 3"]]:
        """Points (m) and normals of the mesh over one frame's landmarks."""
        tube, ends = self._tube, points[self._ends]
        across, deep, axis = _frames(ends, sideways[self._axes])
        radii = self._radii[:, tube.end]
        cap = self._radii.min(axis=2)[:, tube.end] * tube.along
        ring = radii * tube.out[:, None] * tube.around
        surface = (
            ends[:, tube.end]
            + ring[..., :1] * across[:, None]
            + ring[..., 1:] * deep[:, None]
            + cap[..., None] * axis[:, None]
        )
        lean = tube.out[:, None] * tube.around * radii.min(axis=2, keepdims=True) / radii
        rise = tube.along + tube.out * self._slopes(ends)[:, None]
        normals = lean[..., :1] * across[:, None] + lean[..., 1:] * deep[:, None] + rise[..., None] * axis[:, None]
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        return surface.reshape(-1, 3), normals.reshape(-1, 3)

    def _slopes(self, ends: Float[ndarray, "parts 2 3"]) -> Float[ndarray, " parts"]:
        """How much each part narrows per metre; its normals lean that much towards its thinner end."""
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        narrowing = (self._radii[:, 0] - self._radii[:, 1]).mean(axis=1)
        return np.clip(narrowing / np.maximum(lengths, 1e-6), -1.0, 1.0)


def _frames(ends: Float[ndarray, "parts 2 3"], sideways: Float[ndarray, "parts 3"]) -> tuple[ndarray, ndarray, ndarray]:
    """Across, deep and axis of each part, at right angles. A part that runs sideways takes ahead as across."""
    axis = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    axis = np.where(length > 1e-6, axis / np.maximum(length, 1e-6), [0.0, 1.0, 0.0])
    ahead = np.cross(sideways, [0.0, 1.0, 0.0])
    aligned = np.abs((axis * sideways).sum(axis=1, keepdims=True)) > 0.97
    start = np.where(aligned, ahead + 0.1 * sideways, sideways)
    across = start - (start * axis).sum(axis=1, keepdims=True) * axis
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(across, axis), axis
