"""A data set's body: its skeleton with rest axes, and what follows for the vectors. It travels with trained weights."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.data.catalogue import Catalogue, load_clip, usable
from stylephase.features.layout import Layout, feature_joints, layout_of
from stylephase.motion.rest import rest_axes, stands_at_zero
from stylephase.motion.skeleton import Skeleton


@dataclass(frozen=True)
class Body:
    """A skeleton and its joints' rest axes (motion/rest.py)."""

    skeleton: Skeleton
    rest: Float[ndarray, "joints 3 3"]

    @cached_property
    def layout(self) -> Layout:
        """Layout of the vectors."""
        return layout_of(self.skeleton)

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """Indices of the feature joints in the skeleton."""
        return feature_joints(self.skeleton)

    @cached_property
    def bones(self) -> tuple[tuple[int, int], ...]:
        """(parent, child) pairs among the feature joints, by their place in the vectors."""
        place, parents = {joint: k for k, joint in enumerate(self.joints)}, self.skeleton.parents
        return tuple((place[parents[j]], place[j]) for j in self.joints if parents[j] in place)

    def to_json(self) -> dict[str, Any]:
        """Plain values for a file beside the weights."""
        s = self.skeleton
        return {
            "names": list(s.names),
            "parents": list(s.parents),
            "offsets_m": s.offsets.tolist(),
            "sites": list(s.sites),
            "rest": self.rest.tolist(),
        }


def body_from_json(value: dict[str, Any]) -> Body:
    """The inverse of `Body.to_json`."""
    skeleton = Skeleton(
        tuple(value["names"]), tuple(value["parents"]), np.array(value["offsets_m"], dtype=float), tuple(value["sites"])
    )
    return Body(skeleton, np.array(value["rest"], dtype=float))


def body_of(catalogue: Catalogue) -> Body:
    """The body of a data set: the first take's skeleton, and where needed the mean pose of one take of each style."""
    first = load_clip(catalogue.entries[0], catalogue.dataset)
    if stands_at_zero(first.skeleton):
        return Body(first.skeleton, rest_axes(first.skeleton, [first]))
    clips = []
    for style in catalogue.styles:
        takes = (load_clip(e, catalogue.dataset, skeleton=first.skeleton) for e in catalogue.of(style) if not e.idle)
        clips += [next((clip for clip in takes if usable(len(clip))), first)]
    return Body(first.skeleton, rest_axes(first.skeleton, clips))
