"""Write the network that runs a character as an ONNX file."""

from pathlib import Path
from typing import Annotated

import typer

from stylephase.cli.output import AsJson, emit
from stylephase.errors import InputError
from stylephase.files import replacing, write_arrays
from stylephase.models.released import load_weights
from stylephase.runtime.graph import to_onnx, widths_of


def export(
    weights: Annotated[str, typer.Option(help="Folder of trained weights, or `release` for the authors' own.")],
    onnx: Annotated[Path, typer.Option(help="FILE.onnx; the styles' codes go into FILE.npz beside it.")],
    as_json: AsJson = False,
) -> None:
    """Write the run-time network: in come x in metres, what the gate looks at and a style code, out comes y in metres.

    The codes of the styles are written beside it, by name. Weights of others keep their licence, which is noted in
    the file.
    """
    if onnx.suffix != ".onnx":
        raise InputError("expected a name that ends in .onnx", onnx)
    bundle = load_weights(weights)
    model = to_onnx(bundle)
    with replacing(onnx) as temporary:
        temporary.write_bytes(model.SerializeToString())
    codes = onnx.with_suffix(".npz")
    write_arrays(codes, **{style: code.numpy() for style, code in bundle.codes.items()})
    widths, licence = widths_of(model), bundle.about.get("licence")
    result = {"onnx": onnx, "codes": codes, "styles": len(bundle.codes), "widths": widths, "licence": licence}
    text = f"{onnx}: {', '.join(f'{name} {width}' for name, width in widths.items())}; {licence}\n{codes}: "
    emit(result, as_json=as_json, text=text + f"codes of {len(bundle.codes)} styles")
