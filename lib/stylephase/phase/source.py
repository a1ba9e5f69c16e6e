"""Source functions: the one-dimensional signals that a phase is read from ([M22] 4.1.2 to 4.1.4)."""

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray
from scipy.signal import butter, sosfiltfilt

# Butterworth low-pass, order and cut-off (Hz), of the release ([M22] 4.1.4 names the filter only).
_ORDER, _CUTOFF = 2, 4.0
# A source this close to zero is zero ([M22] release).
_SILENT = 1e-3


def contact_source(contacts: Bool[ndarray, " frames"]) -> Float[ndarray, " frames"]:
    """The contact-based source: 1 in contact, 0 otherwise ([M22] 4.1.2)."""
    return contacts.astype(float)


def principal_direction(positions: Float[ndarray, "frames 3"]) -> Float[ndarray, "3"]:
    """First principal component of a bone's positions (m; axes left, up, forward), pointing forward ([M22] 4.1.3).

    Positions are centred and not standardised. A component without a forward part points to the left instead.
    """
    centred = positions - positions.mean(axis=0)
    _, _, components = np.linalg.svd(centred.T @ centred)
    first = components[0]
    towards = first[2] if abs(first[2]) > 1e-9 else first[0]
    return first if towards >= 0 else -first


def principal_source(
    positions: Float[ndarray, "frames 3"], direction: Float[ndarray, "3"]
) -> Float[ndarray, " frames"]:
    """The contact-free source: a bone's position (m) along its principal direction ([M22] 4.1.3)."""
    return (positions - positions.mean(axis=0)) @ direction


def window_zscore(values: Float[ndarray, "frames channels"], frames: int) -> Float[ndarray, "frames channels"]:
    """Normalise inside a centred window of an odd number of frames; the end values are repeated ([M22] 4.1.4)."""
    half = frames // 2
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    spread = windows.std(axis=-1)
    return (values - windows.mean(axis=-1)) / np.where(spread < 1e-9, 1.0, spread)


def low_pass(values: Float[ndarray, "frames *channels"], fps: float) -> Float[ndarray, "frames *channels"]:
    """Butterworth filter forward and backward, so that nothing is delayed; a clip of a few frames stays as it is."""
    if fps <= 2 * _CUTOFF or len(values) < 4:
        return values
    padding = min(3 * (_ORDER + 1), len(values) - 1)
    sections = butter(_ORDER, _CUTOFF, fs=fps, output="sos")
    return sosfiltfilt(sections, values, axis=0, padtype="constant", padlen=padding)


def prepared(
    values: Float[ndarray, "frames channels"], fps: float, window_seconds: float
) -> Float[ndarray, "frames channels"]:
    """A source function ready for the fit: normalised in a window, smoothed, silence set to zero ([M22] 4.1.4)."""
    half = round(window_seconds * fps / 2)
    smooth = low_pass(window_zscore(values, 2 * half + 1), fps)
    return np.where(np.abs(smooth) < _SILENT, 0.0, smooth)
