"""[M18] Table 1: memory of a new style's adapter, and the shares that its text names. Its MB are MiB of float32."""

from torch import nn

from stylephase.evaluation.budget.rows import Row, built, layers, parameters
from stylephase.models.adapters import CpLayer
from stylephase.models.modulators import Adapters
from stylephase.models.pfnn import RANK
from stylephase.models.spline import POINTS
from stylephase.models.zoo import WIDTHS_2018, Widths

# The run time of [M18] stores the weights at so many phases (7.1).
PHASES = 50
# The network of Holden et al. 2017.
_HOLDEN = Widths(inputs=342, gate=1, outputs=311)
_MIB, _BYTES = 2**20, 4

_BASE = layers(4, WIDTHS_2018.inputs, WIDTHS_2018.outputs)
_FULL = "4 * (512 * 512 + 512)"
_CP = "30 * (512 + 512) + 4 * 30 + 4 * 512"
_CP_RUN = f"30 * (512 + 512) + {PHASES} * 30 + 4 * 512"
_CP_NOTE = "fits a bias on four control points that is not discretised; with a single bias it would be {} MiB"


def table_1() -> list[Row]:
    """The memory columns of [M18] Table 1; its MB are MiB."""
    each = {"full": "512 * 512 + 512", "diag": "512 + 512"}
    printed = {"full": ((4.01, 0.01), (50.1, 0.1)), "diag": ((0.016, 0.001), (0.20, 0.01))}
    rows = []
    for kind, one in each.items():
        for (paper, step), points in zip(printed[kind], (4, PHASES), strict=True):
            rows += [_memory(kind, points, f"{points} * ({one})", paper, step)]
    rows += [_memory("cp", 4, _CP, 0.126, 0.001, _CP_NOTE.format("0.1196") + "; one unit off in the last place")]
    return [*rows, _memory("cp", PHASES, _CP_RUN, 0.131, 0.001, _CP_NOTE.format("0.1249"))]


def _memory(kind: str, points: int, numbers: str, paper: float, step: float, note: str = "") -> Row:
    stored = stored_values(_adapter(kind), points)
    quantity = f"{PHASES} phases" if points == PHASES else "control points"
    arithmetic = f"{_BYTES} * ({numbers}) / {_MIB}"
    return Row("[M18] Table 1", f"pfnn-{kind}", quantity, "MiB", arithmetic, _BYTES * stored / _MIB, paper, step, note)


def _adapter(kind: str) -> nn.Module:
    modulator = built(f"pfnn-{kind}", WIDTHS_2018, 1).synthesis.modulator
    assert isinstance(modulator, Adapters)
    return modulator.adapters[0]


def stored_values(layer: nn.Module, points: int) -> int:
    """Numbers kept of a layer with four control points when it is stored at `points` phases.

    Of a decomposed layer only the diagonal is ([M18] 7.1).
    """
    if isinstance(layer, CpLayer):
        return layer.a.numel() + layer.b.numel() + layer.bias.numel() + points * layer.d.shape[1]
    return points * parameters(layer) // POINTS


def shares() -> list[Row]:
    """What an adapter adds to the network, as the text of [M18] says, and the network decomposed in whole (7.1)."""
    base, cp, full = parameters(built("pfnn", WIDTHS_2018, 0)), _adapter("cp"), _adapter("full")
    run, discretised = stored_values(cp, PHASES), base * PHASES // POINTS
    wrong = "34,268 parameters divided by 117,635,200, which are the bytes of the network at 50 phases; parameters by "
    wrong += f"parameters it is {100 * run / discretised:.3f} %"
    few = "32,888 of 2,352,704 parameters"
    stored = f"100 * ({_CP_RUN}) / ({PHASES} * ({_BASE}) / {POINTS})"
    return [
        _share("full", "in training", f"100 * {_FULL} / ({_BASE})", parameters(full) / base, 44.7, 0.1, ""),
        _share("cp", "in training", f"100 * ({_CP}) / ({_BASE})", parameters(cp) / base, 1.5, 0.1, few),
        _share("cp", "at run time", stored, run / discretised, 0.03, 0.01, wrong),
        *_decomposed(),
    ]


def _share(kind: str, quantity: str, arithmetic: str, share: float, paper: float, step: float, note: str) -> Row:
    return Row("[M18] 7", f"pfnn-{kind}", quantity, "% of the network", arithmetic, 100 * share, paper, step, note)


def _decomposed() -> list[Row]:
    """The cursory experiment of [M18] 7.1 on the network of Holden et al. 2017, whose rank is not said."""
    factors = " + ".join(f"{RANK} * ({a} + {b} + 4) + 4 * {b}" for a, b in [(342, 512), (512, 512), (512, 311)])
    whole = f"{_BYTES} * {layers(PHASES, 342, 311)} / {_MIB}", f"{_BYTES} * ({factors}) / {_MIB}"
    counted = [_BYTES * parameters(built(name, _HOLDEN, 0)) / _MIB for name in ("pfnn", "cp-pfnn")]
    unknown = "342 inputs and 311 outputs make no more than 114; what else was counted is not said"
    biases, of_factor = 4 * (512 + 512 + 311), sum(a + b + 4 for a, b in [(342, 512), (512, 512), (512, 311)])
    enough = round((_MIB / _BYTES - biases) / of_factor)
    rank = f"with {RANK} factors; their number is not said, and about {enough} would make 1 MiB"
    table, name = "[M18] 7.1", "Holden's PFNN"
    return [
        Row(table, name, f"{PHASES} phases", "MiB", whole[0], counted[0] * PHASES / POINTS, 136, 1, unknown),
        Row(table, f"{name}, decomposed", "control points", "MiB", whole[1], counted[1], 1, 1, rank),
    ]
