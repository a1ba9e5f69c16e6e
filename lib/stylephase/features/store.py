"""Vectors of a whole data set, one file per style, kept in the cache under a key of data, settings and source."""

import hashlib
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int
from numpy import ndarray

import stylephase
from stylephase.data.archive import cache_folder, fetch
from stylephase.data.catalogue import Catalogue, cut_frames, load_clip, usable
from stylephase.data.layouts import Entry, find_entries
from stylephase.data.registry import OWN, Dataset
from stylephase.data.split import PARTS, split
from stylephase.errors import InputError
from stylephase.features.body import Body, body_from_json, body_of
from stylephase.features.layout import FPS, GLOBAL, LOCAL, Layout
from stylephase.features.vectors import vectors
from stylephase.files import read_json, sha256, write_arrays, write_json
from stylephase.motion.clip import forward_kinematics
from stylephase.phase.local import PhaseVariant, variant
from stylephase.phase.source import Movement, sourcing
from stylephase.phase.take import TakePhases, movement_of, movement_phases

# The split is drawn once for a data set; another seed would let a model see another's test frames.
_SPLIT_SEED = 0
_NO_PART = -1
_ARRAYS = ("x", "p", "y", "phase", "phase_update", "take", "part")
# The modules that decide what the vectors are.
_SOURCES = ("motion/*.py", "phase/*.py", "data/layouts.py", "data/split.py", "features/[!cn]*.py")


@dataclass(frozen=True)
class StyleVectors:
    """Vectors of all usable takes of one style, in the order of the catalogue.

    p and y are those of one gate: of local phases, unless `for_gate` has made them another's. `phase` is the global
    phase (rad) and `phase_update` its change to the next frame. `take` numbers each row's take within the style, `part`
    its part of the split (an index of PARTS, -1 for a guard or for a last row whose next frame lies in another part),
    `gaits` names the gait of each take.
    """

    style: str
    symmetric: bool
    gaits: tuple[str, ...]
    x: Float[ndarray, "rows inputs"]
    p: Float[ndarray, "rows gate_inputs"]
    y: Float[ndarray, "rows outputs"]
    phase: Float[ndarray, " rows"]
    phase_update: Float[ndarray, " rows"]
    take: Int[ndarray, " rows"]
    part: Int[ndarray, " rows"]

    def rows(self, part: str, gait: str | None = None) -> Int[ndarray, " chosen"]:
        """Rows of a part of the split, of all gaits or of one."""
        chosen = self.part == PARTS.index(part)
        if gait is not None:
            chosen &= np.array([g == gait for g in self.gaits])[self.take]
        return np.flatnonzero(chosen)


def for_gate(style: StyleVectors, layout: Layout) -> StyleVectors:
    """The same rows for a network whose gate sees what `layout` says, from vectors of local phases.

    MANN looks at velocities in x and predicts no phase, PFNN at the global phase, whose change it predicts ([M22] 5.2).
    """
    if layout.gate == LOCAL:
        return style
    p, between = style.x[:, layout.x_velocities], np.zeros((len(style.x), 0), np.float32)
    if layout.gate == GLOBAL:
        p, between = style.phase[:, None], style.phase_update[:, None]
    joined = np.concatenate([style.y[:, : layout.y_pose.stop], between, style.y[:, -2:]], axis=1)
    return replace(style, p=p, y=joined)


class VectorStore:
    """The vectors of one data set under one phase variant, computed at the first call for each style."""

    def __init__(self, catalogue: Catalogue, phases: str):
        self.catalogue, self.phases, self.how = catalogue.without_idle(), phases, variant(phases)
        # Cache and body belong to the whole data set, whichever of its styles are asked for.
        dataset = catalogue.dataset
        self._whole = Catalogue(dataset, find_entries(dataset.layout, fetch(dataset))).without_idle()
        self.folder = cache_folder() / "vectors" / f"{_safe(dataset.name)}-{phases}-{_key(self._whole)[:12]}"

    @property
    def body(self) -> Body:
        """The data set's body."""
        path = self.folder / "body.json"
        if not path.exists():
            write_json(path, body_of(self._whole).to_json())
        return body_from_json(read_json(path))

    def path(self, style: str) -> Path:
        """The cached file of one style."""
        plain = _safe(style)
        # Two styles may come out alike.
        return self.folder / f"{plain if plain == style else f'{plain}-{zlib.crc32(style.encode()):08x}'}.npz"

    def load(self, style: str) -> StyleVectors:
        """The vectors of one style, from the cache or computed."""
        path = self.path(style)
        if not path.exists():
            made = style_vectors(self.catalogue, style, self.body, self.phases)
            arrays = {name: getattr(made, name) for name in _ARRAYS}
            write_arrays(path, gaits=np.array(made.gaits), symmetric=np.array(made.symmetric), **arrays)
        with np.load(path, allow_pickle=False) as found:
            gaits = tuple(str(gait) for gait in found["gaits"])
            arrays = {name: found[name] for name in _ARRAYS}
            return StyleVectors(style, bool(found["symmetric"]), gaits, **arrays)


def _safe(name: str) -> str:
    """A name that is a plain file name."""
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name.removeprefix(OWN).rstrip("/").split("/")[-1])


def _key(catalogue: Catalogue) -> str:
    """Hash of the data, what the registry says of them, and the source that makes vectors, so that none is stale."""
    if catalogue.dataset.name.startswith(OWN):
        data = "\n".join(f"{sha256(entry.path)} {entry.style}/{entry.path.name}" for entry in catalogue.entries)
    else:
        data = fetch(catalogue.dataset).name
    dataset = catalogue.dataset
    told = repr((dataset.contact, sorted(dataset.contact_free.items()), dataset.fps, dataset.metres_per_unit))
    library = Path(stylephase.__file__).parent
    sources = [path for pattern in _SOURCES for path in sorted(library.glob(pattern))]
    return hashlib.sha256(
        (data + told).encode(errors="surrogateescape") + b"".join(path.read_bytes() for path in sources)
    ).hexdigest()


def style_vectors(catalogue: Catalogue, style: str, body: Body, phases: str) -> StyleVectors:
    """Compute the vectors of one style. Raises InputError where no take is long enough."""
    takes, entries = [], []
    for entry in catalogue.of(style):
        clip = load_clip(entry, catalogue.dataset, fps=FPS, skeleton=body.skeleton)
        clip = clip.frames(*cut_frames(entry, catalogue.dataset, clip))
        if usable(len(clip)):
            takes.append(clip)
            entries.append(entry)
    if not takes:
        raise InputError(f"style {style!r} has no take that is long enough to learn from")
    poses = [forward_kinematics(clip) for clip in takes]
    movements = [movement_of(pose, body.skeleton, FPS, catalogue.dataset.contact) for pose in poses]
    found = _phases(catalogue.dataset, entries, movements, variant(phases))
    parts = _parts(split(entries, [len(clip) for clip in takes], seed=_SPLIT_SEED), [len(clip) for clip in takes])
    rows = [
        vectors(pose, body.skeleton, body.rest, FPS, take.local.vectors, take.contacts, take.global_phase)
        for pose, take in zip(poses, found, strict=True)
    ]
    kinds = ("x", "p", "y", "phase", "phase_update")
    arrays = {kind: np.concatenate([getattr(row, kind) for row in rows]).astype(np.float32) for kind in kinds}
    return StyleVectors(
        style=style,
        symmetric=all(entry.symmetric for entry in entries),
        gaits=tuple(entry.gait for entry in entries),
        **arrays,
        take=np.repeat(np.arange(len(takes)), [len(part) for part in parts]),
        part=np.concatenate(parts),
    )


def _phases(dataset: Dataset, entries: list[Entry], movements: list[Movement], how: PhaseVariant) -> list[TakePhases]:
    """Phases of the takes of one style, read from source functions chosen for each gait."""
    chosen = {
        gait: sourcing(
            [movement for movement, entry in zip(movements, entries, strict=True) if entry.gait == gait],
            contact_free=dataset.contact_free_feet(entries[0].style, gait),
        )
        for gait in {entry.gait for entry in entries}
    }
    return [
        movement_phases(movement, chosen[entry.gait], how) for movement, entry in zip(movements, entries, strict=True)
    ]


def _parts(segments, lengths: list[int]) -> list[Int[ndarray, " rows"]]:
    """For each take the part of every row; a row needs its frame and the next one in the same part."""
    frames = [np.full(length, _NO_PART) for length in lengths]
    for segment in segments:
        frames[segment.entry][segment.start : segment.stop] = PARTS.index(segment.part)
    return [np.where(part[:-1] == part[1:], part[:-1], _NO_PART) for part in frames]
