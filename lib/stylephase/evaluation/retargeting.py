"""Clips of one skeleton carried over to another, joint by joint by name, through the mean pose of both.

The eight styles of Xia et al. are walks on the CMU skeleton, of twenty seconds in all ([M18] 5.1 captured the same
names). Carried over to a base's body they are more new styles, with the error of the carrying stated.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.data.archive import fetch
from stylephase.data.catalogue import Catalogue, load_clip
from stylephase.data.layouts import Entry
from stylephase.data.registry import Archive, Dataset
from stylephase.errors import InputError
from stylephase.evaluation.new_clips import NewStyle
from stylephase.features.captures import clip_vectors
from stylephase.features.clips import WALKS
from stylephase.features.layout import FPS
from stylephase.features.store import VectorStore
from stylephase.models.bundle import Bundle
from stylephase.motion.bvh import read_bvh
from stylephase.motion.clip import Clip, forward_kinematics, resample
from stylephase.motion.contacts import ContactRule
from stylephase.motion.root import root_of, to_local
from stylephase.motion.skeleton import Skeleton
from stylephase.runtime.rollout import from_world

# A carried toe touches the floor below this speed (m/s) and height (m).
_CONTACT = ContactRule(speed=1.0, height=0.08)
# Read file by file and never trained on as a whole, so it is no data set of the registry, whose files have a layout.
XIA = Dataset(
    name="xia",
    title="Eight styles of Xia et al. 2015",
    origin="real capture",
    licence="none stated",
    credit="Xia, Wang, Chai and Hodgins 2015, Realtime Style Transfer for Unlabeled Heterogeneous Human Motion",
    source="https://github.com/DeepMotionEditing/deep-motion-editing",
    layout="files",
    contact=_CONTACT,
    archives=(Archive("xia-styles.tar.xz", sha256="df86bc1d6792442063ef9074d22ce9df260662697e80076ae960efe73d1a9b19"),),
)
# Joints of Bandai-Namco's skeleton, and the joint of CMU's that moves the same bone.
FROM_CMU = {
    "Hips": "Hips",
    "Spine": "LowerBack",
    "Chest": "Spine1",
    "Neck": "Neck",
    "Head": "Neck1",
    **{
        f"{ours}_{side[0]}": f"{side}{theirs}"
        for side in ("Left", "Right")
        for ours, theirs in {
            "Shoulder": "Shoulder",
            "UpperArm": "Arm",
            "LowerArm": "ForeArm",
            "Hand": "Hand",
            "UpperLeg": "UpLeg",
            "LowerLeg": "Leg",
            "Foot": "Foot",
            "Toes": "ToeBase",
        }.items()
    },
}


@dataclass(frozen=True)
class Carried:
    """A clip on another body.

    `off` is how far (cm) its joints are from where the file's are, seen from the root, the body's size taken out;
    `moves_off` the same less each joint's own mean, which is what the bodies' proportions come to.
    """

    clip: Clip
    off: float
    moves_off: float


def xia_clips(content: str) -> dict[str, Clip]:
    """Clips of Xia's eight styles at 60 frames a second; walking is `01`."""
    files = sorted(fetch(XIA).rglob(f"*_{content}_000.bvh"))
    return {path.name.split("_")[0]: resample(read_bvh(path), FPS) for path in files}


def carry(
    clips: Sequence[Clip], theirs: Sequence[Clip], ours: Sequence[Clip], names: Mapping[str, str]
) -> list[Carried]:
    """Clips on another skeleton, in the order given; `names` gives for each of its joints the one to follow.

    Walkers of both skeletons, `theirs` and `ours`, are thought to hold their joints alike on average: that is the rest
    pose. Raises InputError for a joint that is not there.
    """
    source, target = clips[0].skeleton, ours[0].skeleton
    moving = [j for j in range(len(target)) if not target.sites[j]]
    if missing := [target.names[j] for j in moving if target.names[j] not in names]:
        raise InputError(f"no joint to follow for {', '.join(missing)}")
    followed = [source.index(names[target.names[j]]) for j in moving]
    turned = np.swapaxes(_mean_pose(theirs)[followed], -1, -2) @ _mean_pose(ours)[moving]
    size = _leg(target) / _leg(source)
    found = []
    for clip in clips:
        pose = forward_kinematics(clip)
        made = from_world(target, pose.rotations[:, followed] @ turned, size * clip.root_positions, clip.name)
        found.append(Carried(made, *_off(made, clip, size, moving, followed)))
    return found


def _mean_pose(clips: Sequence[Clip]) -> Float[ndarray, "joints 3 3"]:
    """Mean rotation of each joint against the root."""
    total = np.zeros((len(clips[0].skeleton), 3, 3))
    for clip in clips:
        pose = forward_kinematics(clip)
        total += np.einsum("tji,tkjl->kil", root_of(pose, clip.skeleton).matrices, pose.rotations)
    u, _, vt = np.linalg.svd(total)
    u[..., -1] *= np.sign(np.linalg.det(u @ vt))[:, None]
    return u @ vt


def _leg(skeleton: Skeleton) -> float:
    """Length (m) of the bones from the left thigh to the toe."""
    chain = skeleton.chain(skeleton.roles.toes[0])
    return float(sum(np.linalg.norm(skeleton.offsets[j]) for j in chain[chain.index(skeleton.roles.thighs[0]) + 1 :]))


def _off(made: Clip, clip: Clip, size: float, moving: list[int], followed: list[int]) -> tuple[float, float]:
    """Mean distance (cm) of the joints from the source's, and of their movement about their means."""
    ours, theirs = (forward_kinematics(one) for one in (made, clip))
    here = to_local(root_of(ours, made.skeleton), ours.positions[:, moving])
    there = size * to_local(root_of(theirs, clip.skeleton), theirs.positions[:, followed])
    apart = here - there
    both = (apart, apart - apart.mean(axis=0))
    return 100 * float(np.linalg.norm(both[0], axis=-1).mean()), 100 * float(np.linalg.norm(both[1], axis=-1).mean())


def xia_styles(store: VectorStore, base: Bundle) -> tuple[list[NewStyle], list[Carried]]:
    """Xia's styles on the body of Bandai-Namco, each to be learned from its walk, and how they were carried over.

    Their toes glide a little after the carrying, so that contacts have a rule of their own. Their other takes are too
    short to test on.
    """
    walks, catalogue, body = xia_clips("01"), store.catalogue, base.body
    ours = [load_clip(_a_walk(catalogue, name), catalogue.dataset, skeleton=body.skeleton) for name in base.styles]
    carried, styles = carry(list(walks.values()), list(walks.values()), ours, FROM_CMU), []
    for name, one in zip(walks, carried, strict=True):
        clip = clip_vectors(one.clip, name, body, store.phases, "", symmetric=True, gait="walk", rule=_CONTACT)
        angles = root_of(forward_kinematics(one.clip), one.clip.skeleton).angles
        styles.append(NewStyle(name, one.clip, clip, float(np.degrees(np.ptp(angles))), {}))
    return styles, carried


def _a_walk(catalogue: Catalogue, style: str) -> Entry:
    return next(entry for entry in catalogue.of(style) if entry.gait in WALKS)
