"""[M22] Table 2: parameters of the animation synthesis network, of the style modulation network, and per style."""

from stylephase.evaluation.budget.rows import Row, built, layers, parameters
from stylephase.features.layout import Layout
from stylephase.models.synthesis import StyledNetwork
from stylephase.models.zoo import PAPER_2022, model, widths_of

# Training styles of [M22], joints of its skeleton.
STYLES = 95
PUBLISHED = Layout(25, tuple(range(25)))


def _gating(inputs: int) -> str:
    return f"({inputs} * 32 + 32) + (32 * 32 + 32) + (32 * 8 + 8)"


_ASN = {
    "pfnn": (layers(4, 348, 327), 2_436_380),
    "lpn": (f"{layers(8, 348, 342)} + {_gating(8)}", 4_935_928),
    "mann": (f"{layers(8, 348, 326)} + {_gating(12)}", 4_870_392),
}
_GENERATOR = "(300 * 25 * 256 + 256) + (256 * 25 * 256 + 256) + (15360 * 2048 + 2048) + (2048 * 2048 + 2048)"
_MISCOUNT = (
    "the printed number is the two dense layers, 35,655,680, plus 2 * (256 * 25 + 25) = 12,850: each convolution "
    "counted as a dense layer from 256 to 25, without its 300 or 256 input channels"
)
_PER_STYLE = {
    "pfnn-onehot": ("512 * 4", 2048),
    "lpn-onehot": ("512 * 8", 4096),
    "pfnn-resad": ("30 * (512 + 512 + 4) + 512", 31_352),
    "lpn-resad": ("512 * 512 + 512", 262_656),
}
_CODE = ("4 * 512", 2048)
_SMN = {"pfnn-onehot": 194_560, "lpn-onehot": 389_120, "pfnn-resad": 2_978_440, "lpn-resad": 24_952_320}


def table_2() -> list[Row]:
    """All counts of [M22] Table 2."""
    return [row for name in PAPER_2022 for row in _rows_of(name)]


def _rows_of(name: str) -> list[Row]:
    network = built(name, widths_of(name, PUBLISHED), STYLES)
    counted, filmed = counts_of(network), network.generator is not None
    psr, psr_printed = _PER_STYLE.get(name, _CODE)
    columns = {
        "A.S.N.": (*_ASN[model(name).backbone], ""),
        "S.M.N.": (_GENERATOR, 35_668_530, _MISCOUNT) if filmed else (f"{STYLES} * ({psr})", _SMN[name], ""),
        "P.S.R.": (psr, psr_printed, ""),
    }
    return [
        Row("[M22] Table 2", name, column, "parameters", arithmetic, counted[column], paper, note=note)
        for column, (arithmetic, paper, note) in columns.items()
    ]


def counts_of(network: StyledNetwork) -> dict[str, int]:
    """Counted parameters by the columns of [M22] Table 2: A.S.N., S.M.N. and P.S.R."""
    synthesis, modulator = network.synthesis, network.synthesis.modulator
    own = parameters(modulator)
    smn, psr = own, own // max(modulator.values, 1)
    if network.generator is not None:
        smn, psr = parameters(network.generator), modulator.values
    return {"A.S.N.": parameters(synthesis.gating) + parameters(synthesis.layers), "S.M.N.": smn, "P.S.R.": psr}
