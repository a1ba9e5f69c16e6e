"""The PFNN of [M18] Fig. 4: every layer a function of the global phase, the style in an adapter beside the second."""

from collections.abc import Callable, Sequence
from itertools import pairwise

from torch import nn

from stylephase.models.adapters import CpLayer, DiagonalLayer
from stylephase.models.experts import ExpertLayer
from stylephase.models.modulators import Adapters, Modulator
from stylephase.models.spline import POINTS, SplineGate
from stylephase.models.synthesis import NetworkSettings, Synthesis

# Factors of the decomposed adapters of base styles ([M18] 7.1).
RANK = 30


class Pfnn(Synthesis):
    """Four control points for each weight, blended by the phase ([M18] Eq. 1, 4). Its gate input is the phase in rad.

    `make_layer` makes a layer from its number of inputs and outputs; left out, it has full matrices.
    """

    def __init__(
        self,
        inputs: int,
        outputs: int,
        settings: NetworkSettings,
        modulator: Modulator | None = None,
        make_layer: Callable[[int, int], nn.Module] | None = None,
    ):
        make = make_layer or (lambda a, b: ExpertLayer(POINTS, a, b))
        widths = pairwise((inputs, settings.units, settings.units, outputs))
        super().__init__(SplineGate(), [make(a, b) for a, b in widths], modulator or Modulator(), settings)


def decomposed_layer(inputs: int, outputs: int) -> CpLayer:
    """A layer for a PFNN that is decomposed in whole, as tried in [M18] 7.1."""
    return CpLayer(POINTS, inputs, outputs, RANK, bias_points=POINTS)


def adapter(form: str, units: int) -> nn.Module:
    """One adapter: `full`, `diag` or `cp` of [M18] Table 1, `cp-one-bias` as [M22] Table 2 counts it.

    `cp:10` has ten factors in place of thirty. `static` is the adapter of [M22]'s LPN Resad: a full matrix without
    phase. Raises ValueError for any other form.
    """
    kind, _, factors = form.partition(":")
    rank = int(factors) if factors else RANK
    make: dict[str, Callable[[], nn.Module]] = {
        "full": lambda: ExpertLayer(POINTS, units, units),
        "diag": lambda: DiagonalLayer(POINTS, units),
        "cp": lambda: CpLayer(POINTS, units, units, rank, bias_points=POINTS),
        "cp-one-bias": lambda: CpLayer(POINTS, units, units, rank, bias_points=1),
        "static": lambda: ExpertLayer(1, units, units),
    }
    if kind not in make:
        raise ValueError(f"expected an adapter of the forms {', '.join(make)}, found {form!r}")
    return make[kind]()


def adapters(kind: str, styles: int, units: int, *, rank: int = RANK, rate: float = 0.0) -> Adapters:
    """One adapter per style, all of one kind (see `adapter`)."""
    form = f"{kind}:{rank}"
    return Adapters(styles, lambda: adapter(form, units), phased=kind != "static", rate=rate)


def mixed_adapters(forms: Sequence[str], units: int) -> Adapters:
    """One adapter per style, each of its own form; all depend on the phase."""
    made = iter(adapter(form, units) for form in forms)
    return Adapters(len(forms), lambda: next(made))
