"""Motion that leaves the program: BVH, arrays, or a movie."""

from pathlib import Path

import numpy as np
from jaxtyping import Bool
from numpy import ndarray

from stylephase.errors import InputError
from stylephase.files import write_arrays
from stylephase.motion.bvh import write_bvh
from stylephase.motion.clip import Clip, forward_kinematics

FORMATS = (".bvh", ".npz")


def write_motion(path: Path, clip: Clip, contacts: Bool[ndarray, "frames 2"]) -> None:
    """Write a clip in the format of the file's suffix, whole or not at all; raises InputError for another suffix.

    An npz holds `positions` (m) and `rotations` (wxyz, local) of all joints, `contacts` (right, left), `names`,
    `parents` and `fps`.
    """
    if path.suffix == ".bvh":
        write_bvh(path, clip)
    elif path.suffix == ".npz":
        pose, s = forward_kinematics(clip), clip.skeleton
        names, parents, fps = np.array(s.names), np.array(s.parents), np.array(clip.fps)
        arrays = {"positions": pose.positions, "rotations": clip.rotations, "contacts": contacts}
        write_arrays(path, **arrays, names=names, parents=parents, fps=fps)
    else:
        raise InputError(f"expected a name that ends in {' or '.join(FORMATS)}", path)
