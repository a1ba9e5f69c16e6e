"""Write what runs a character: the network as an ONNX file, or the weights alone in half precision."""

from pathlib import Path
from typing import Annotated, Any

import typer

from stylephase.cli.output import AsJson, emit
from stylephase.errors import InputError
from stylephase.files import replacing, write_arrays
from stylephase.models.bundle import Bundle, is_bundle, save_bundle
from stylephase.models.card import write_card
from stylephase.models.released import RELEASE, load_weights
from stylephase.runtime.graph import to_onnx, widths_of


def export(
    weights: Annotated[str, typer.Option(help="Folder of trained weights, or `release` for the authors' own.")],
    onnx: Annotated[Path | None, typer.Option(help="FILE.onnx; the styles' codes go into FILE.npz beside it.")] = None,
    to_run: Annotated[
        Path | None, typer.Option(help="Folder for half-precision weights without generator, and their card.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write the run-time network: in come x in metres, what the gate looks at and a style code, out comes y in metres.

    With --onnx the codes of the styles are written beside it, by name. With --to-run the other commands take the
    folder as they take the whole weights, except that it makes no codes of new styles. Weights of others keep their
    licence, which is noted in the file.
    """
    if (onnx is None) == (to_run is None):
        raise InputError("name what to write: --onnx FILE or --to-run FOLDER")
    if onnx is not None:
        if onnx.suffix != ".onnx":
            raise InputError("expected a name that ends in .onnx", onnx)
        result, text = _write_onnx(load_weights(weights), onnx)
    else:
        assert to_run is not None
        if is_bundle(to_run):
            raise InputError("holds weights already; choose another folder", to_run)
        if weights == RELEASE:
            raise InputError("the authors' weights are theirs to pass on; --to-run is for weights of your own")
        result, text = _write_to_run(load_weights(weights), Path(weights), to_run)
    emit(result, as_json=as_json, text=text)


def _write_onnx(bundle: Bundle, onnx: Path) -> tuple[dict[str, Any], str]:
    model = to_onnx(bundle)
    with replacing(onnx) as temporary:
        temporary.write_bytes(model.SerializeToString())
    codes = onnx.with_suffix(".npz")
    write_arrays(codes, **{style: code.numpy() for style, code in bundle.codes.items()})
    widths, licence = widths_of(model), bundle.about.get("licence")
    result = {"onnx": onnx, "codes": codes, "styles": len(bundle.codes), "widths": widths, "licence": licence}
    text = f"{onnx}: {', '.join(f'{name} {width}' for name, width in widths.items())}; {licence}\n{codes}: "
    return result, text + f"codes of {len(bundle.codes)} styles"


def _write_to_run(bundle: Bundle, weights: Path, folder: Path) -> tuple[dict[str, Any], str]:
    save_bundle(folder, bundle, to_run=True)
    card, licence = write_card(folder, bundle, weights), bundle.about.get("licence")
    size = sum(path.stat().st_size for path in folder.iterdir())
    result = {"folder": folder, "card": card, "styles": len(bundle.codes), "bytes": size, "licence": licence}
    return result, f"{folder}: {bundle.model} in {len(bundle.codes)} styles, {size / 1e6:.1f} MB; {licence}"
