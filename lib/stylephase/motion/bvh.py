"""BVH files, read strictly and written so that they come back the same.

Numbers in a file are degrees and the file's own unit of length; a `Clip` holds quaternions and metres.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.files import check_regular, write_text
from stylephase.motion.clip import Clip
from stylephase.motion.rotations import from_euler, from_matrix, to_euler, to_matrix
from stylephase.motion.skeleton import Skeleton, with_effectors

CENTIMETRE = 0.01
# Units met in BVH files: metre, centimetre, millimetre, inch, and that of the CMU skeleton (2.54 cm / 0.45).
_UNITS = (1.0, CENTIMETRE, 0.001, 0.0254, 0.0254 / 0.45)
_LEG_LENGTH = 0.95
_POSITION = {"Xposition": 0, "Yposition": 1, "Zposition": 2}
_ROTATION = {"Xrotation": "X", "Yrotation": "Y", "Zrotation": "Z"}
# A joint other than the hips may carry position channels, but its bone must keep its length within this (m).
_STRETCH = 0.01
# The hips move against what carries them by more than this share of the longest bone.
_CARRIED = 0.05
# What a file may say of its frames: seconds of one, and the largest value of a channel, in units or degrees.
_SHORTEST_FRAME, _LONGEST_FRAME, _LARGEST = 0.001, 1.0, 1e7


@dataclass
class _Node:
    """One joint of the file's hierarchy, as it stands there."""

    name: str
    parent: int
    line: int
    offset: tuple[float, ...] | None = None
    channels: list[str] = field(default_factory=list)
    site: bool = False
    first_channel: int = 0


class _Lines:
    """The file's lines as words, one after the other, with the line number for messages."""

    def __init__(self, path: Path):
        self.path, self.number = path, 0
        check_regular(path)
        try:
            self.lines = path.read_text(encoding="utf-8-sig").splitlines()
        except UnicodeDecodeError as error:
            raise InputError("not a BVH file: it is no text in UTF-8", path) from error
        except OSError as error:
            raise InputError(f"cannot read: {error.strerror or error}", path) from error

    def next(self, expected: str) -> list[str]:
        """Words of the next line that has any; raises InputError at the end of the file."""
        while self.number < len(self.lines):
            self.number += 1
            words = self.lines[self.number - 1].split()
            if words:
                return words
        raise InputError(f"the file ends where {expected} should stand", self.path, self.number or None)

    def error(self, reason: str) -> InputError:
        return InputError(reason, self.path, self.number or None)

    def numbers(self, words: list[str], what: str) -> list[float]:
        """Finite numbers; raises InputError."""
        try:
            values = [float(word) for word in words]
        except ValueError as error:
            raise self.error(f"{what}: expected numbers, found {_short(words)}") from error
        if not np.isfinite(values).all():
            raise self.error(f"{what}: a number is not finite")
        return values


def _short(words: list[str]) -> str:
    text = " ".join(words)
    return repr(text if len(text) <= 40 else text[:37] + "...")


def read_bvh(path: str | Path, *, metres_per_unit: float | None = None, effectors: Sequence[str] | None = None) -> Clip:
    """Read a BVH file.

    `metres_per_unit` is the file's unit of length (m); left out, it is guessed from the length of the legs.
    `effectors` name the joints of LeftHand, RightHand, LeftFoot and RightFoot where they are called otherwise.
    Joints above the hips (such as `joint_Root` over `Hips`) are composed into the hips, and what else hangs on them
    (a camera, targets of inverse kinematics) is left out. A constant position channel of another joint replaces its
    offset.

    Raises InputError with file, line and reason: no BVH, cut off, fewer or more frames than announced, a wrong
    number of values, a value that is no finite number, a bone that changes its length.
    """
    return read_with_unit(path, metres_per_unit=metres_per_unit, effectors=effectors)[0]


def read_with_unit(
    path: str | Path, *, metres_per_unit: float | None = None, effectors: Sequence[str] | None = None
) -> tuple[Clip, float]:
    """The same as `read_bvh`, with the file's unit of length (m), given or guessed."""
    lines = _Lines(Path(path))
    nodes = _read_hierarchy(lines)
    frame_time, values = _read_motion(lines, sum(len(node.channels) for node in nodes))
    try:
        return _to_clip(lines.path, nodes, 1.0 / frame_time, values, metres_per_unit, effectors)
    except InputError as error:
        raise InputError(error.reason, lines.path, error.line) from error


def _read_hierarchy(lines: _Lines) -> list[_Node]:
    if lines.next("HIERARCHY") != ["HIERARCHY"]:
        raise lines.error("not a BVH file: the first word should be HIERARCHY")
    nodes: list[_Node] = []
    stack: list[int] = []
    while True:
        words = lines.next("a joint, '}' or MOTION")
        if words[0] in ("ROOT", "JOINT") or words[0].lower() == "end":
            _open_node(lines, words, nodes, stack)
        elif words[0] == "OFFSET" and stack:
            nodes[stack[-1]].offset = _offset(lines, words)
        elif words[0] == "CHANNELS" and stack:
            _set_channels(lines, words, nodes, stack[-1])
        elif words[0] == "}" and stack:
            _close_node(lines, nodes[stack.pop()])
        elif words[0] == "MOTION" and not stack and nodes:
            return nodes
        else:
            raise lines.error(f"unexpected {_short(words)} in the hierarchy")


def _open_node(lines: _Lines, words: list[str], nodes: list[_Node], stack: list[int]) -> None:
    site = words[0].lower() == "end"
    if words[0] == "ROOT" and nodes:
        raise lines.error("a second root")
    if (words[0] == "ROOT") != (not stack):
        raise lines.error("a joint outside the root")
    if len(words) < 2:
        raise lines.error("a joint without a name")
    parent = stack[-1] if stack else -1
    name = f"{nodes[parent].name}Site" if site else "_".join(words[1:])
    taken = {node.name for node in nodes}
    if name in taken and not site:
        raise lines.error(f"two joints are called {name}")
    name = name if name not in taken else f"{name}{len(nodes)}"
    if lines.next("'{'") != ["{"]:
        raise lines.error("expected '{'")
    nodes.append(_Node(name, parent, lines.number, site=site))
    stack.append(len(nodes) - 1)


def _close_node(lines: _Lines, node: _Node) -> None:
    if node.offset is None or not (node.site or node.channels):
        raise lines.error(f"joint {node.name} ends without {'OFFSET' if node.offset is None else 'CHANNELS'}")


def _offset(lines: _Lines, words: list[str]) -> tuple[float, ...]:
    if len(words) != 4:
        raise lines.error(f"OFFSET: expected 3 numbers, found {len(words) - 1}")
    return tuple(lines.numbers(words[1:], "OFFSET"))


def _set_channels(lines: _Lines, words: list[str], nodes: list[_Node], joint: int) -> None:
    channels = words[2:]
    if len(words) < 2 or words[1] != str(len(channels)):
        raise lines.error(f"CHANNELS: {words[1] if len(words) > 1 else 'none'} announced, {len(channels)} named")
    unknown = [c for c in channels if c not in _POSITION and c not in _ROTATION]
    if unknown or len(set(channels)) != len(channels):
        raise lines.error(f"CHANNELS: {_short(unknown or channels)} is not a set of position and rotation channels")
    nodes[joint].first_channel = sum(len(node.channels) for node in nodes)
    nodes[joint].channels = channels


def _read_motion(lines: _Lines, channels: int) -> tuple[float, Float[ndarray, "frames channels"]]:
    words = lines.next("'Frames:'")
    if words[0] != "Frames:" or len(words) != 2 or not words[1].isdecimal():
        raise lines.error(f"expected 'Frames: N', found {_short(words)}")
    announced = int(words[1])
    words = lines.next("'Frame Time:'")
    if words[:2] != ["Frame", "Time:"] or len(words) != 3:
        raise lines.error(f"expected 'Frame Time: SECONDS', found {_short(words)}")
    (frame_time,) = lines.numbers(words[2:], "Frame Time")
    if frame_time <= 0:
        raise lines.error(f"Frame Time is {frame_time}; it should be above zero")
    if not _SHORTEST_FRAME <= frame_time <= _LONGEST_FRAME:
        raise lines.error(f"Frame Time is {frame_time:g} s; expected {_SHORTEST_FRAME:g} to {_LONGEST_FRAME:g}")
    frames = _read_frames(lines, channels, announced)
    if np.abs(frames).max(initial=0.0) > _LARGEST:
        raise InputError(f"a channel reaches {np.abs(frames).max():g}; no motion does", lines.path)
    return frame_time, frames


def _read_frames(lines: _Lines, channels: int, announced: int) -> Float[ndarray, "frames channels"]:
    """All frames at once where they are as announced; otherwise line by line, to name the line that is wrong."""
    table = [line for line in lines.lines[lines.number :] if line.strip()]
    if len(table) == announced > 0:
        try:
            values = np.loadtxt(table, comments=None, ndmin=2)
        except ValueError:
            return _read_rows(lines, channels, announced)
        if values.shape[1] == channels and np.isfinite(values).all():
            return values
    return _read_rows(lines, channels, announced)


def _read_rows(lines: _Lines, channels: int, announced: int) -> Float[ndarray, "frames channels"]:
    rows = []
    for number in range(lines.number + 1, len(lines.lines) + 1):
        lines.number, words = number, lines.lines[number - 1].split()
        if not words:
            continue
        if len(rows) == announced:
            raise lines.error(f"more frames than the {announced} announced")
        if len(words) != channels:
            raise lines.error(f"frame {len(rows)}: expected {channels} values, found {len(words)}")
        rows.append(lines.numbers(words, f"frame {len(rows)}"))
    if len(rows) != announced:
        raise lines.error(f"the file ends after {len(rows)} of {announced} frames")
    if not rows:
        raise lines.error("the file has no frames")
    return np.array(rows)


def _to_clip(
    path: Path,
    nodes: list[_Node],
    fps: float,
    values: ndarray,
    metres_per_unit: float | None,
    effectors: Sequence[str] | None,
) -> tuple[Clip, float]:
    positions, rotations = [_positions(node, values) for node in nodes], _rotations(nodes, values)
    top = _hips_node(nodes, positions)
    root_positions, root_rotations = positions[0], rotations[:, 0]
    for node in _above(nodes, top)[1:]:
        matrices = to_matrix(root_rotations)
        root_positions = root_positions + np.einsum("tij,tj->ti", matrices, positions[node])
        root_rotations = from_matrix(matrices @ to_matrix(rotations[:, node]))
    kept = _below(nodes, top)
    place = {n: k for k, n in enumerate(kept)}
    skeleton = Skeleton(
        names=tuple(nodes[n].name for n in kept),
        parents=tuple(-1 if n == top else place[nodes[n].parent] for n in kept),
        offsets=np.array([np.zeros(3) if n == top else np.median(positions[n], axis=0) for n in kept]),
        sites=tuple(nodes[n].site for n in kept),
    )
    skeleton = skeleton if effectors is None else with_effectors(skeleton, effectors)
    scale = guess_unit(skeleton) if metres_per_unit is None else metres_per_unit
    for n in kept[1:]:
        if np.ptp(positions[n], axis=0).max() * scale > _STRETCH:
            raise InputError(f"joint {nodes[n].name} moves against its parent; only the hips may", line=nodes[n].line)
    clip = Clip(
        skeleton=replace(skeleton, offsets=skeleton.offsets * scale),
        fps=round(fps, 2),
        rotations=np.concatenate([root_rotations[:, None], rotations[:, kept[1:]]], axis=1),
        root_positions=root_positions * scale,
        name=path.stem,
    )
    return clip, scale


def _hips_node(nodes: list[_Node], positions: list[Float[ndarray, "frames 3"]]) -> int:
    """The first node from the top with more than one child: what stands above it only carries it.

    Where one of its children moves against it and branches, too, that one is the hips, and the rest helpers.
    """
    top, reach = 0, max(float(np.linalg.norm(node.offset or (0.0,))) for node in nodes[1:] or nodes)
    while True:
        children = [n for n, node in enumerate(nodes) if node.parent == top and not node.site]
        moving = [n for n in children if np.ptp(positions[n], axis=0).max() > _CARRIED * reach and _branches(nodes, n)]
        if len(children) == 1 and not any(node.site and node.parent == top for node in nodes):
            top = children[0]
        elif moving:
            top = max(moving, key=lambda n: len(_below(nodes, n)))
        else:
            return top


def _branches(nodes: list[_Node], parent: int) -> bool:
    return sum(node.parent == parent for node in nodes) > 1


def _below(nodes: list[_Node], top: int) -> list[int]:
    """A node and all that hangs on it, in the order of the file: parents come first."""
    inside = {top}
    for n in range(top + 1, len(nodes)):
        if nodes[n].parent in inside:
            inside.add(n)
    return sorted(inside)


def _above(nodes: list[_Node], node: int) -> list[int]:
    """The way from the root down to a node, itself included."""
    way = [node]
    while nodes[way[-1]].parent != -1:
        way.append(nodes[way[-1]].parent)
    return way[::-1]


def _positions(node: _Node, values: Float[ndarray, "frames channels"]) -> Float[ndarray, "frames 3"]:
    """A node's translation against its parent (file units), per frame.

    The position channels count if they are not all zero, else the offset does ([M22] release).
    """
    position = np.tile(np.array(node.offset, dtype=float), (len(values), 1))
    moving = {_POSITION[c]: node.first_channel + k for k, c in enumerate(node.channels) if c in _POSITION}
    columns = list(moving.values())
    if node.parent == -1 or np.any(values[:, columns]):
        position[:, list(moving)] = values[:, columns]
    return position


def _rotations(nodes: list[_Node], values: Float[ndarray, "frames channels"]) -> Float[ndarray, "frames nodes 4"]:
    """Rotations against the parents (wxyz), per frame; nodes of the same channel order go in one call, for speed."""
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(values), len(nodes), 1))
    alike: dict[str, dict[int, list[int]]] = {}
    for n, node in enumerate(nodes):
        turning = {node.first_channel + k: _ROTATION[c] for k, c in enumerate(node.channels) if c in _ROTATION}
        if turning:
            alike.setdefault("".join(turning.values()), {})[n] = list(turning)
    for order, columns in alike.items():
        rotations[:, list(columns)] = from_euler(order, values[:, list(columns.values())])
    return rotations


def guess_unit(skeleton: Skeleton) -> float:
    """Metres per unit of length: the usual unit under which the left leg comes closest to an adult's."""
    length = skeleton.length_to(skeleton.roles.toes[0])
    if length < 1e-9:
        raise InputError("the legs have no length: the unit cannot be guessed")
    return min(_UNITS, key=lambda unit: abs(np.log(length * unit / _LEG_LENGTH)))


def write_bvh(path: str | Path, clip: Clip, *, metres_per_unit: float = CENTIMETRE, order: str = "YXZ") -> None:
    """Write a clip as BVH, whole or not at all, with rotation channels in `order` (default: that of 100STYLE).

    Raises InputError, and writes nothing, if a number is not finite.
    """
    if not (np.isfinite(clip.rotations).all() and np.isfinite(clip.root_positions).all()):
        raise InputError("not written: a number of the clip is not finite", path)
    degrees = to_euler(order, clip.rotations)
    moving = [j for j in range(len(clip.skeleton)) if not clip.skeleton.sites[j]]
    columns = np.concatenate([clip.root_positions / metres_per_unit, degrees[:, moving].reshape(len(clip), -1)], axis=1)
    lines = ["HIERARCHY", *_hierarchy_lines(clip.skeleton, 0, 0, metres_per_unit, order)]
    lines += ["MOTION", f"Frames: {len(clip)}", f"Frame Time: {1 / clip.fps:.9f}"]
    lines += [" ".join(f"{value:.6f}" for value in row) for row in columns]
    write_text(path, "\n".join(lines) + "\n")


def _hierarchy_lines(skeleton: Skeleton, joint: int, depth: int, unit: float, order: str) -> list[str]:
    indent, site = "  " * depth, skeleton.sites[joint]
    kind = "End Site" if site else f"{'JOINT' if joint else 'ROOT'} {skeleton.names[joint]}"
    offset = " ".join(f"{value / unit:.6f}" for value in skeleton.offsets[joint])
    lines = [f"{indent}{kind}", f"{indent}{{", f"{indent}  OFFSET {offset}"]
    if not site:
        positions = " Xposition Yposition Zposition" if joint == 0 else ""
        rotations = " ".join(f"{axis}rotation" for axis in order)
        lines.append(f"{indent}  CHANNELS {6 if joint == 0 else 3}{positions} {rotations}")
    for child in skeleton.children(joint):
        lines += _hierarchy_lines(skeleton, child, depth + 1, unit, order)
    return [*lines, f"{indent}}}"]
