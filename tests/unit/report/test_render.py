"""Pictures and movies of a tiny skeleton: what must be seen is seen, and what fails leaves nothing behind."""

import io
import subprocess
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from stylephase.errors import InputError
from stylephase.motion.skeleton import Skeleton
from stylephase.report import palette
from stylephase.report.render import Layout, Motion, facing_angles, grid, ground_path, movie, strip
from stylephase.report.render.anatomy import find_anatomy
from stylephase.report.render.body import body_parts
from stylephase.report.render.landmarks import added, landmarks
from stylephase.report.render.surface import Surface

_JOINTS = (
    ("Hips", -1, (0.0, 0.0, 0.0)),
    ("Spine", 0, (0.0, 0.2, 0.0)),
    ("Chest", 1, (0.0, 0.15, 0.0)),
    ("Neck", 2, (0.0, 0.15, 0.0)),
    ("Head", 3, (0.0, 0.07, 0.0)),
    *((f"{s}Arm", 2, (x * 0.18, 0.1, 0.0)) for s, x in (("Left", 1), ("Right", -1))),
    *((f"{s}ForeArm", 5 + k, (x * 0.05, -0.25, 0.0)) for k, (s, x) in enumerate((("Left", 1), ("Right", -1)))),
    *((f"{s}Hand", 7 + k, (0.0, -0.22, 0.05)) for k, s in enumerate(("Left", "Right"))),
    *((f"{s}UpLeg", 0, (x * 0.09, -0.05, 0.0)) for s, x in (("Left", 1), ("Right", -1))),
    *((f"{s}Leg", 11 + k, (0.0, -0.4, 0.0)) for k, s in enumerate(("Left", "Right"))),
    *((f"{s}Foot", 13 + k, (0.0, -0.4, 0.0)) for k, s in enumerate(("Left", "Right"))),
    *((f"{s}Toe", 15 + k, (0.0, -0.06, 0.13)) for k, s in enumerate(("Left", "Right"))),
)
_SMALL = Layout(frames=2, scale=60)


def _skeleton() -> Skeleton:
    names, parents, offsets = zip(*_JOINTS, strict=True)
    return Skeleton(names, parents, np.array(offsets), (False,) * len(names))


def _walker(frames: int = 12, *, turn: float = 0.0, label: str = "walk") -> Motion:
    """Someone who glides straight ahead at 1 m/s with one leg swinging; `turn` is the way faced (rad from +z)."""
    skeleton = _skeleton()
    rest = np.zeros((len(skeleton), 3))
    for joint, parent in list(enumerate(skeleton.parents))[1:]:
        rest[joint] = rest[parent] + skeleton.offsets[joint]
    positions = np.tile(rest + np.array([0.0, 0.95, 0.0]), (frames, 1, 1))
    for name, reach in (("RightLeg", 0.1), ("RightFoot", 0.25), ("RightToe", 0.25)):
        positions[:, skeleton.index(name), 2] += reach * np.sin(np.linspace(0, np.pi, frames))
    positions[:, :, 2] += np.arange(frames)[:, None] / 60
    cos, sin = np.cos(turn), np.sin(turn)
    return Motion(skeleton, positions @ np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]]), label=label)


def _read(path: Path) -> list[np.ndarray]:
    """All frames of a movie, read by ffmpeg itself."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "image2pipe", "-c:v", "ppm", "-"]
    pictures = io.BytesIO(subprocess.run(command, capture_output=True, check=True).stdout)
    frames = []
    while pictures.tell() < len(pictures.getvalue()):
        _, width, height, _ = pictures.readline(), *map(int, pictures.readline().split()), pictures.readline()
        frames.append(np.frombuffer(pictures.read(width * height * 3), np.uint8).reshape(height, width, 3))
    return frames


def _share(pixels: np.ndarray, colour: str) -> float:
    """Share of the pixels whose hue is that of `colour`."""
    wanted = np.array(palette.rgb(colour), dtype=float)
    lengths = np.linalg.norm(pixels, axis=2)
    alike = (pixels @ (wanted / np.linalg.norm(wanted))) / np.maximum(lengths, 1) > 0.985
    return float((alike & (lengths > 20)).mean())


@pytest.fixture(scope="module")
def side_view() -> np.ndarray:
    return strip(_walker(), _SMALL)


def test_strip_shows_a_person_with_two_sides_on_white(side_view):
    """A blank picture, one colour for all limbs, or a background that is not white would fail."""
    assert 0.02 < (side_view.min(axis=2) < 200).mean() < 0.5
    assert _share(side_view, palette.LEFT) > 0.001
    assert _share(side_view, palette.RIGHT) > 0.005
    assert (side_view[0] == 255).all()


def test_strip_twice_gives_the_same_pixels(side_view):
    np.testing.assert_array_equal(strip(_walker(), _SMALL), side_view)


def test_moved_joint_changes_the_picture_there_only(side_view):
    """A moved hand in the second frame leaves the first character as it was."""
    motion = _walker()
    positions = motion.positions.copy()
    positions[-1, motion.skeleton.index("RightHand"), 1] += 0.3
    changed = (strip(replace(motion, positions=positions), _SMALL) != side_view).any(axis=(0, 2))
    first, last = np.flatnonzero(changed)[[0, -1]]
    assert first > side_view.shape[1] // 2
    assert last - first < 40


def test_view_follows_the_facing(side_view):
    """However the walker is turned in the world, the picture is the same to within rounding."""
    turned = strip(_walker(turn=2.0), _SMALL)
    assert turned.shape == side_view.shape
    assert (np.abs(turned.astype(int) - side_view) > 16).mean() < 0.002


def test_views_differ():
    """From the front both sides show alike; from its right the right side hides the left."""
    front = strip(_walker(1), replace(_SMALL, frames=1, view="front"))
    side = strip(_walker(1), replace(_SMALL, frames=1))
    ratios = [_share(picture, palette.RIGHT) / _share(picture, palette.LEFT) for picture in (front, side)]
    assert 0.5 < ratios[0] < 2.0
    assert ratios[1] > 3.0


def test_contacts_and_highlights_are_drawn(side_view):
    """Marks appear only where they are asked for."""
    motion = replace(_walker(), contacts=np.array([[True, False]] * 12))
    marked = strip(motion, replace(_SMALL, highlights=("LeftHand",)))
    assert _share(side_view, palette.HIGHLIGHT) == 0
    assert _share(marked, palette.HIGHLIGHT) > 0.001
    below = slice(int(marked.shape[0] * 0.9), None)
    disc = palette.lighter(palette.RIGHT, 0.45)
    assert _share(marked[below], disc) > _share(side_view[below], disc) + 0.01


def test_travelled_strip_keeps_the_distance():
    """Two seconds at 1 m/s take two metres more room than standing on the spot."""
    motion = _walker(121)
    near = strip(motion, replace(_SMALL, spacing=0.5))
    far = strip(motion, replace(_SMALL, travelled=True))
    assert far.shape[1] - near.shape[1] == pytest.approx(1.5 * _SMALL.scale, abs=2)


def test_grid_has_a_row_for_each_motion():
    """Rows keep their scale, and labels their place at the left."""
    both = grid([_walker(), _walker(label="the same walk once more")], _SMALL)
    one = strip(_walker(label="the same walk once more"), _SMALL)
    assert both.shape == (2 * one.shape[0], one.shape[1], 3)
    np.testing.assert_array_equal(both[one.shape[0] :], one)


def test_captions_stand_below_each_frame_and_change_nothing_else():
    plain, told = (strip(_walker(), replace(_SMALL, captions=c)) for c in ((), ("one",) * _SMALL.frames))
    assert told.shape[0] > plain.shape[0] and told.shape[1] == plain.shape[1]
    # Label and note move down with the middle of the picture, so only the frames are compared.
    across = plain.shape[1] // 2
    np.testing.assert_array_equal(told[: plain.shape[0], across:], plain[:, across:])
    below = (told[plain.shape[0] :] < 128).any(axis=(0, 2))
    assert below[across:].any() and below[: plain.shape[1]].any()
    with pytest.raises(InputError, match="a caption for each"):
        strip(_walker(), replace(_SMALL, captions=("one", "two", "three", "four", "five", "six", "seven")))


def test_sole_rests_on_the_ground():
    """Heel, ball and tip of a standing foot end at the ground, whatever the height of the ankle joint."""
    motion = _walker()
    points, _ = _standing(motion)
    assert points[:, 1].min() == pytest.approx(0.0, abs=0.015)
    anatomy = find_anatomy(motion.skeleton)
    marks = landmarks(anatomy, motion.positions).points[0]
    assert marks[added(anatomy, "LeftTip"), 2] > marks[added(anatomy, "LeftBall"), 2]
    assert marks[added(anatomy, "LeftHeel"), 2] < marks[motion.skeleton.index("LeftFoot"), 2]


def test_body_normals_point_outwards():
    """Normals that point inwards would light the character from the wrong side."""
    points, normals = _standing(_walker())
    size = len(points) // len(body_parts(find_anatomy(_skeleton())))
    centres = np.repeat(points.reshape(-1, size, 3).mean(axis=1), size, axis=0)
    assert ((points - centres) * normals).sum(axis=1).min() > -1e-3
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)


def _standing(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    anatomy = find_anatomy(motion.skeleton)
    points, sideways = landmarks(anatomy, motion.positions)
    return Surface(body_parts(anatomy)).shape(points[0], sideways[0])


def test_facing_and_ground_path():
    """Facing is measured from +z towards +x, and the present is the middle of the path."""
    motion = _walker(60, turn=0.5)
    np.testing.assert_allclose(facing_angles(motion), 0.5, atol=1e-9)
    path = ground_path(motion, seconds=0.5, points=5)
    np.testing.assert_allclose(path[20, 2, :2], motion.positions[20, 0, [0, 2]])
    np.testing.assert_allclose(path[20, 4, :2] - path[20, 3, :2], 0.25 * path[20, 3, 2:], atol=1e-9)


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_movie_has_the_announced_frames(tmp_path: Path, suffix: str):
    """Twelve frames at 60 a second make six at 30, twice as wide with two characters, and they move."""
    path = tmp_path / f"walk{suffix}"
    motion = replace(_walker(), path=ground_path(_walker()))
    assert movie(path, [motion, _walker(4)], size=(64, 48)) == 6
    frames = _read(path)
    assert [frame.shape[:2] for frame in frames] == [(48, 128)] * 6
    assert (np.abs(frames[0].astype(int) - frames[3]) > 30).mean() > 0.003
    assert list(tmp_path.iterdir()) == [path]


def test_movie_twice_gives_the_same_bytes(tmp_path: Path):
    """Neither dates nor chance get into the file."""
    for name in ("one.mp4", "two.mp4"):
        movie(tmp_path / name, _walker(4), size=(64, 48))
    assert (tmp_path / "one.mp4").read_bytes() == (tmp_path / "two.mp4").read_bytes()


def test_ground_stays_in_the_world(tmp_path: Path):
    """Under a walker the lines move, under one who stands they do not."""
    walking = _walker(14)
    standing = replace(walking, positions=walking.positions - walking.positions[:, :1] * [0, 0, 1])
    moved = []
    for name, motion in (("walking", walking), ("standing", standing)):
        movie(tmp_path / f"{name}.gif", replace(motion, label=""), size=(112, 80))
        frames = [frame[-24:].astype(int) for frame in _read(tmp_path / f"{name}.gif")]
        moved.append((np.abs(frames[6] - frames[1]) > 8).mean())
    assert moved[0] > 5 * moved[1]


def test_interrupted_movie_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """An error in the middle of writing keeps the movie of before and nothing else."""
    path = tmp_path / "walk.mp4"
    path.write_bytes(b"earlier")

    def fail(_pixels, _finer):
        raise RuntimeError("in the middle")

    monkeypatch.setattr("stylephase.report.render.movies.reduced", fail)
    with pytest.raises(RuntimeError, match="in the middle"):
        movie(path, _walker(4), size=(64, 48))
    assert path.read_bytes() == b"earlier"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("name", "options", "reason"),
    [
        ("walk.avi", {}, r"end in \.mp4 or \.gif"),
        ("walk.mp4", {"size": (100, 48)}, "multiples of 16"),
        ("walk.mp4", {"fps": 25}, "25 frames a second cannot be taken from motion at 60"),
        ("walk.mp4", {"view": "above", "size": (64, 48)}, "no view 'above'"),
        ("walk.mp4", {"highlights": ["Tail"], "size": (64, 48)}, "no joint 'Tail'"),
    ],
)
def test_bad_movie_is_refused(tmp_path: Path, name: str, options: dict, reason: str):
    with pytest.raises(InputError, match=reason):
        movie(tmp_path / name, _walker(4), **options)
    assert not list(tmp_path.iterdir())


def test_bad_motion_is_refused():
    """Another skeleton's positions, a position that is no number, a part that lies outside, nothing at all."""
    motion = _walker(4)
    with pytest.raises(InputError, match="walk: expected frames of 19 joints, found 4 frames of 18"):
        replace(motion, positions=motion.positions[:, 1:])
    broken = motion.positions.copy()
    broken[2, 0, 0] = np.nan
    with pytest.raises(InputError, match="walk: frame 2 has a position that is no finite number"):
        replace(motion, positions=broken)
    with pytest.raises(InputError, match="frames 2 to 9"):
        motion.frames(2, 9)
    with pytest.raises(InputError, match="0 and 2"):
        grid([], _SMALL)


def test_skeleton_without_toes_or_head_is_drawn():
    """Feet and head are made up where the skeleton ends at ankle and chest."""
    skeleton = _skeleton()
    kept = [j for j, name in enumerate(skeleton.names) if "Toe" not in name and name not in ("Head", "Neck")]
    bare = Skeleton(
        tuple(skeleton.names[j] for j in kept),
        tuple(-1 if skeleton.parents[j] < 0 else kept.index(skeleton.parents[j]) for j in kept),
        skeleton.offsets[kept],
        (False,) * len(kept),
    )
    pixels = strip(Motion(bare, _walker().positions[:, kept]), replace(_SMALL, frames=1))
    assert _share(pixels, palette.RIGHT) > 0.005


def test_picture_is_a_real_png_of_few_bytes(tmp_path: Path, side_view):
    """The way from pixels to file keeps the pixels."""
    from stylephase.report.png import write_png

    write_png(tmp_path / "walk.png", side_view, alt="a walk")
    with Image.open(tmp_path / "walk.png") as picture:
        np.testing.assert_array_equal(np.asarray(picture), side_view)
        assert picture.info["Description"] == "a walk"
