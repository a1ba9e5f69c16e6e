"""Training on phases that are read from contacts alone, to see what contact-free phases are worth ([M22] 5.1.1)."""

from dataclasses import replace

from jaxtyping import Bool
from numpy import ndarray

from stylephase.features.layout import Layout
from stylephase.features.store import StyleVectors, VectorStore
from stylephase.models.bundle import Bundle
from stylephase.runtime.rollout import quiet
from stylephase.training.loop import trained
from stylephase.training.presets import preset as find_preset

# A foot that is in contact for less of the time than this never touches the floor.
_TOUCHES = 0.02
# The columns of the left and the right foot among the phase vectors.
_FEET = (slice(4, 6), slice(6, 8))


def untouched(style: StyleVectors) -> Bool[ndarray, "2"]:
    """Whether the left and the right foot never touch the floor; contacts in y are (right, left)."""
    return style.y[:, :-3:-1].mean(axis=0) < _TOUCHES


def contact_based(style: StyleVectors, layout: Layout) -> StyleVectors:
    """The same with phases of feet from contacts alone: a foot that never touches the floor has none.

    Its source function is zero, and so are its phase vector and their update. Of other feet nothing changes where they
    are read from contacts anyway.
    """
    p, y = style.p.copy(), style.y.copy()
    for foot, never in zip(_FEET, untouched(style), strict=True):
        if never:
            p[:, foot] = 0
            for part in (layout.y_phases, layout.y_phase_updates):
                y[:, part][:, foot] = 0
    return replace(style, p=p, y=y)


class ContactBasedStore(VectorStore):
    """The vectors of a data set with phases from contacts alone."""

    def load(self, style: str) -> StyleVectors:
        """The vectors of one style."""
        return contact_based(super().load(style), self.body.layout)


def train_contact_based(store: VectorStore, preset: str, seed: int) -> Bundle:
    """LPN with FiLM trained like any other, but on phases from contacts alone."""
    blind = ContactBasedStore(store.catalogue, store.phases)
    return trained(blind, "lpn-film", find_preset(preset), preset, seed, quiet)
