"""Predictors of the next frame, trained and naive, behind one signature, so that all take the same test."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from numpy import ndarray

from stylephase.features.layout import INPUT_SAMPLES, LOCAL, OUTPUT_SAMPLES, Layout
from stylephase.features.normaliser import Normaliser
from stylephase.features.store import StyleVectors
from stylephase.models.bundle import Bundle, build_network

# From x and p in metres to y in metres.
Predictor = Callable[
    [Float[ndarray, "rows inputs"], Float[ndarray, "rows gate_inputs"]], Float[ndarray, "rows outputs"]
]
# Ridge regression's weight of the squared coefficients, per training row, on normalised values.
_RIDGE = 1e-4
# Seed of the untrained weights and of the dropout.
_SEED = 0


def predict_mean(normaliser: Normaliser) -> Predictor:
    """Always the mean output of the training frames."""
    return lambda x, p: np.tile(normaliser.y_mean, (len(x), 1))


def predict_hold(layout: Layout, normaliser: Normaliser) -> Predictor:
    """Hold the pose and the phases, and go on along the trajectory that the input has; contacts are the mean."""
    columns = [4 * INPUT_SAMPLES.index(sample) + k for sample in OUTPUT_SAMPLES for k in range(4)]

    def hold(x: ndarray, p: ndarray) -> ndarray:
        updates = layout.y_phase_updates
        kept = p if layout.gate == LOCAL else p[:, :0]
        still, contacts = np.zeros((len(x), updates.stop - updates.start)), normaliser.y_mean[layout.y_contacts]
        parts = [x[:, columns], x[:, layout.x_pose], kept, still, np.tile(contacts, (len(x), 1))]
        return np.concatenate(parts, axis=1)

    return hold


@dataclass(frozen=True)
class Ridge:
    """Linear regression from normalised x and p, and a constant, to normalised y, one for all styles."""

    normaliser: Normaliser
    weights: Float[ndarray, "inputs outputs"]

    def __call__(self, x: ndarray, p: ndarray) -> ndarray:
        """Predict y in metres."""
        return _joined(self.normaliser, x, p) @ self.weights * self.normaliser.y_std + self.normaliser.y_mean


def fit_ridge(styles: Sequence[StyleVectors], normaliser: Normaliser) -> Ridge:
    """Fit on the training rows of all styles.

    With a constant: where the statistics count mirror images, the rows that are fitted here are not centred.
    """
    width = len(normaliser.x_mean) + len(normaliser.p_mean) + 1
    square, cross, count = np.zeros((width, width)), np.zeros((width, len(normaliser.y_mean))), 0
    for style in styles:
        rows = style.rows("train")
        inputs = _joined(normaliser, style.x[rows], style.p[rows])
        outputs = (style.y[rows] - normaliser.y_mean) / normaliser.y_std
        square, cross, count = square + inputs.T @ inputs, cross + inputs.T @ outputs, count + len(rows)
    penalty = _RIDGE * count * np.eye(width)
    return Ridge(normaliser, np.linalg.solve(square + penalty, cross))


def _joined(normaliser: Normaliser, x: ndarray, p: ndarray) -> Float[ndarray, "rows inputs"]:
    n = normaliser
    return np.concatenate([(x - n.x_mean) / n.x_std, (p - n.p_mean) / n.p_std, np.ones((len(x), 1))], axis=1)


def predict_network(bundle: Bundle, style: str, *, dropout: bool = False) -> Predictor:
    """The bundle's network with one style's stored code, in eval mode; or with dropout on, as the release tests.

    The dropout is the same in every call.
    """
    n, code, network = bundle.normaliser, bundle.code(style), bundle.network.synthesis

    def predict(x: ndarray, p: ndarray) -> ndarray:
        scaled = [
            torch.from_numpy((v - mean) / std).float()
            for v, mean, std in ((x, n.x_mean, n.x_std), (p, n.p_mean, n.p_std))
        ]
        with torch.inference_mode(), torch.random.fork_rng(devices=[]):
            torch.manual_seed(_SEED)
            y = network.train(dropout)(*scaled, code.expand(len(x), -1)).double().numpy()
        network.eval()
        return y * n.y_std + n.y_mean

    return predict


def untrained(bundle: Bundle) -> Bundle:
    """The same with a network as it was drawn, and for every style the code that modulates nothing."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(_SEED)
        network = build_network(bundle.model, bundle.body, len(bundle.codes), bundle.settings).eval()
    neutral = torch.zeros(network.synthesis.modulator.values)
    if network.generator is not None:
        network.generator.start_neutral()
        neutral = network.generator.code.bias.detach()
    return replace(bundle, network=network, codes=dict.fromkeys(bundle.codes, neutral), about={})
