"""Style codes of many clips: how well they separate, in their own space and in a picture ([M22] 5.3.2, Fig. 11)."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from numpy import ndarray
from sklearn.manifold import TSNE
from sklearn.metrics import silhouette_samples

from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle
from stylephase.training.codes import clip_codes
from stylephase.training.sampler import Scaling

# Clips of a style in [M22] Fig. 11.
CLIPS = 50
_PERPLEXITY = 30.0

# Codes (clips, values) by style.
Codes = Mapping[str, Float[ndarray, "_ values"]]


def codes_of_clips(
    bundle: Bundle, styles: Sequence[StyleVectors], *, part: str = "train", most: int = CLIPS
) -> dict[str, Float[ndarray, "_ values"]]:
    """Codes that the bundle's generator gives for clips of each style, whether it learned the style or not.

    Clips are spread evenly over the style's walks; a style without clips in the part is left out.
    """
    generator, scaling = bundle.network.generator, Scaling(bundle.normaliser, bundle.layout)
    assert generator is not None
    with_clips = (style for style in styles if len(style.rows(part)))
    return {style.style: clip_codes(generator, style, scaling, part=part, most=most).numpy() for style in with_clips}


def silhouettes(codes: Codes) -> dict[str, float]:
    """Mean silhouette of each style's clips, in -1 to 1: at 0 a clip is as near to another style as to its own.

    A style of a single clip has no silhouette, but is another style to the rest.
    """
    values, labels = _joined(codes)
    each = np.asarray(silhouette_samples(values, labels))
    return {name: float(each[labels == name].mean()) for name, group in codes.items() if len(group) > 1}


def nearest_centroid(codes: Codes, probes: Codes | None = None) -> dict[str, float]:
    """Share of each style's clips whose nearest centroid is their own style's.

    `probes` are the clips that are asked; without them each clip of `codes` is, its own left out of its centroid, and a
    style of a single clip is not.
    """
    names = list(codes)
    sums = np.stack([group.sum(axis=0) for group in codes.values()])
    counts = np.array([len(group) for group in codes.values()])
    shares = {}
    for name, group in (probes or codes).items():
        own = names.index(name)
        if probes is None and counts[own] < 2:
            continue
        distances = np.linalg.norm(group[:, None] - sums / counts[:, None], axis=2)
        if probes is None:
            without = (sums[own] - group) / (counts[own] - 1)
            distances[:, own] = np.linalg.norm(group - without, axis=1)
        shares[name] = float((distances.argmin(axis=1) == own).mean())
    return shares


def picture(codes: Codes, *, seed: int = 0) -> tuple[Float[ndarray, "clips 2"], list[str]]:
    """Places of all clips in a plane by t-SNE, and their styles: for looking only, its distances mean little."""
    values, labels = _joined(codes)
    perplexity = min(_PERPLEXITY, (len(values) - 1) / 3)
    places = TSNE(perplexity=perplexity, init="pca", random_state=seed).fit_transform(values)
    return np.asarray(places), [str(label) for label in labels]


def _joined(codes: Codes) -> tuple[Float[ndarray, "clips values"], ndarray]:
    labels = np.repeat(list(codes), [len(group) for group in codes.values()])
    return np.concatenate(list(codes.values())).astype(float), labels
