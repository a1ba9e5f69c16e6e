"""The stage: camera, light, ground and characters, drawn off screen by pyvista.

pyvista is imported where it is first needed, as it takes about a second.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float, UInt8
from matplotlib.font_manager import findfont
from numpy import ndarray
from PIL import Image
from scipy.spatial import KDTree

from stylephase.errors import InputError
from stylephase.report import palette
from stylephase.report.render.anatomy import find_anatomy
from stylephase.report.render.body import body_parts
from stylephase.report.render.landmarks import added, landmarks
from stylephase.report.render.marks import Flat, contact_discs, joined, rings, shadow, trajectory
from stylephase.report.render.motion import Motion
from stylephase.report.render.surface import Surface

if TYPE_CHECKING:
    import pyvista

# Angle (rad) from the character's facing round to its right, where the eye stands.
_AZIMUTH = {"side": np.pi / 2, "three-quarter": np.radians(50), "front": 0.0}
_GROUND_FADES = 7.0
_VIEW_ANGLE = 24.0
_AMBIENT, _DIFFUSE = 0.38, 0.62


def toward_eye(view: str, *, elevation: float, facing: float = 0.0) -> Float[ndarray, " 3"]:
    """Unit vector from the character to the eye.

    `elevation` (rad) is the eye's angle above the ground, `facing` (rad) the character's turn from +z.
    """
    if view not in _AZIMUTH:
        raise InputError(f"no view {view!r}; there are {', '.join(_AZIMUTH)}")
    angle = facing - _AZIMUTH[view]
    level = np.cos(elevation)
    return np.array([np.sin(angle) * level, np.sin(elevation), np.cos(angle) * level])


def add_label(plotter: "pyvista.Plotter", label: str, *, place: tuple[float, float], size: int) -> Any:
    """Write a label at a place (shares of the window), in the font of the plots; gives VTK's actor of the text."""
    how = {"viewport": True, "color": palette.INK, "font_file": findfont("DejaVu Sans")}
    return plotter.add_text(label, position=place, font_size=size, **how)


@contextmanager
def stage(size: tuple[int, int], *, finer: int) -> "Iterator[pyvista.Plotter]":
    """A plotter for a picture of `size` pixels, closed at the end.

    It draws `finer` times as many pixels each way, to be averaged by `reduced`: on a machine without a graphics card
    that takes half the time of the smoothing built into VTK.
    """
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    # Without a display VTK first says so, and then draws all the same.
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    window = [size[0] * finer, size[1] * finer]
    plotter = pyvista.Plotter(off_screen=True, window_size=window, lighting="none")
    try:
        plotter.disable_anti_aliasing()
        plotter.background_color = pyvista.Color(palette.BACKGROUND)
        yield plotter
    finally:
        plotter.close()


def add_lights(plotter: "pyvista.Plotter", toward: Float[ndarray, " 3"]) -> None:
    """A main light from above on the eye's left and a weak one from its right."""
    import pyvista

    right = np.cross([0.0, 1.0, 0.0], toward)
    for beside, above, strength in ((-0.6, 1.0, 0.85), (1.2, 0.2, 0.3)):
        place = toward + beside * right + above * np.array([0.0, 1.0, 0.0])
        plotter.add_light(pyvista.Light(position=tuple(place), focal_point=(0, 0, 0), intensity=strength))


class Character:
    """One motion on the stage; `show` moves it to a frame."""

    def __init__(
        self,
        plotter: "pyvista.Plotter",
        motion: Motion,
        *,
        toward: Float[ndarray, " 3"],
        highlights: Sequence[str] = (),
    ):
        import pyvista

        anatomy = find_anatomy(motion.skeleton)
        self._motion, self._toward = motion, toward
        self._marked = [motion.skeleton.index(name) for name in highlights]
        self._feet = [added(anatomy, name) for name in ("RightHeel", "RightBall", "LeftHeel", "LeftBall")]
        self._landmarks = landmarks(anatomy, motion.positions)
        self._surface = Surface(body_parts(anatomy))
        nothing = np.zeros((len(self._surface.colours), 3))
        self._body = pyvista.PolyData.from_regular_faces(nothing, self._surface.triangles)
        self._shadow = pyvista.PolyData.from_regular_faces(nothing, self._surface.triangles)
        self._marks = pyvista.PolyData()
        self._body.point_data["colour"] = self._surface.colours
        self.show(0)
        body = plotter.add_mesh(self._body, scalars="colour", rgb=True, ambient=_AMBIENT, diffuse=_DIFFUSE)
        body.prop.interpolation = "gouraud"
        plotter.add_mesh(self._shadow, color=palette.SHADOW, lighting=False)
        plotter.add_mesh(self._marks, scalars="colour", rgb=True, lighting=False)

    def show(self, frame: int) -> None:
        """Move the character and its marks to a frame."""
        points, normals = self._surface.shape(self._landmarks.points[frame], self._landmarks.sideways[frame])
        self._body.points = points
        self._body.point_data.active_normals = normals
        self._shadow.points = shadow(points)
        _draw(self._marks, self._flat(frame))

    def _flat(self, frame: int) -> Flat:
        points, motion = self._landmarks.points[frame], self._motion
        flats = rings(points[self._marked], self._toward)
        if motion.contacts is not None:
            feet = points[self._feet].reshape(2, 2, 3).mean(axis=1)
            flats += contact_discs(feet, motion.contacts[frame].astype(float))
        if motion.path is not None:
            flats += trajectory(motion.path[frame])
        return joined(flats)


def _draw(mesh: "pyvista.PolyData", flat: Flat) -> None:
    """Put these triangles in the mesh's place."""
    import pyvista

    drawn = pyvista.PolyData.from_regular_faces(flat.points, flat.triangles)
    drawn.point_data["colour"] = flat.colours
    mesh.copy_from(drawn)


def add_ground(plotter: "pyvista.Plotter", tracks: Float[ndarray, "points 2"], *, line_width: float) -> None:
    """Lines (width in pixels) at every metre around the tracks (x, z), fading with the distance from them."""
    import pyvista

    low, high = np.floor(tracks.min(axis=0) - _GROUND_FADES), np.ceil(tracks.max(axis=0) + _GROUND_FADES)
    xs, zs = (np.arange(low[k], high[k] + 0.5) for k in (0, 1))
    x, z = np.meshgrid(xs, zs, indexing="ij")
    corners = np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)
    number = np.arange(x.size).reshape(x.shape)
    pairs = ((number[:-1], number[1:]), (number[:, :-1], number[:, 1:]))
    lines = np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in pairs])
    distance, _ = KDTree(tracks).query(corners[:, [0, 2]])
    share = np.clip(distance / _GROUND_FADES, 0, 1)[:, None] ** 0.8
    line, background = (np.array(palette.rgb(c)) for c in (palette.GROUND_LINE, palette.BACKGROUND))
    grid = pyvista.PolyData(corners, lines=np.insert(lines, 0, 2, axis=1).ravel())
    grid.point_data["colour"] = np.round(line + share * (background - line)).astype(np.uint8)
    plotter.add_mesh(grid, scalars="colour", rgb=True, lighting=False, line_width=line_width)


def look(
    plotter: "pyvista.Plotter",
    at: Float[ndarray, " 3"],
    toward: Float[ndarray, " 3"],
    *,
    height_shown: float | None = None,
    distance: float = 6.0,
) -> None:
    """Point the camera at a place, from the direction `toward`.

    With `height_shown` (m) the projection is parallel, so that equal lengths look equal; else it is in perspective
    from `distance` (m).
    """
    camera = plotter.camera
    camera.position, camera.focal_point, camera.up = tuple(at + distance * toward), tuple(at), (0.0, 1.0, 0.0)
    camera.clipping_range = (0.1, 100.0)
    if height_shown is not None:
        camera.parallel_projection, camera.parallel_scale = True, height_shown / 2
    else:
        camera.view_angle = _VIEW_ANGLE


def picture(plotter: "pyvista.Plotter") -> UInt8[ndarray, "height width 3"]:
    """The stage as it is now."""
    plotter.render()
    return np.asarray(plotter.screenshot(return_img=True))


def reduced(pixels: UInt8[ndarray, "height width 3"], finer: int) -> UInt8[ndarray, "low narrow 3"]:
    """The picture with each square of `finer` x `finer` pixels averaged."""
    return np.asarray(Image.fromarray(pixels).reduce(finer))
