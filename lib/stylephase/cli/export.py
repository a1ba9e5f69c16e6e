"""Write what runs a character: the network as an ONNX file, the weights alone in half precision, or starts of walks."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.archive import where
from stylephase.data.catalogue import load_catalogue
from stylephase.data.registry import dataset
from stylephase.errors import InputError
from stylephase.evaluation.starts import starts_from
from stylephase.features.store import VectorStore
from stylephase.files import replacing, write_arrays
from stylephase.models.bundle import Bundle, Start, is_bundle, save_bundle, save_starts
from stylephase.models.card import write_card
from stylephase.models.released import RELEASE, load_weights
from stylephase.runtime.graph import to_onnx, widths_of


def export(
    weights: Annotated[str, typer.Option(help="Folder of trained weights, or `release` for the authors' own.")],
    onnx: Annotated[Path | None, typer.Option(help="FILE.onnx; the styles' codes go into FILE.npz beside it.")] = None,
    to_run: Annotated[
        Path | None, typer.Option(help="Folder for half-precision weights without generator, and their card.")
    ] = None,
    starts: Annotated[
        bool, typer.Option("--starts", help="Walk to a start of each style and keep it in the folder of the weights.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Write the run-time network: in come x in metres, what the gate looks at and a style code, out comes y in metres.

    With --onnx the codes of the styles are written beside it, by name. With --to-run the other commands take the
    folder as they take the whole weights, except that it makes no codes of new styles. Weights of others keep their
    licence, which is noted in the file.

    A start is a moment of a walk by the network itself, after some seconds from a frame of the data that it was trained
    on, which must be at hand; no frame of the data is kept. Without it some styles keep to a shuffle or a run in which
    they began. --to-run makes starts too where the data are at hand; the file is `starts.safetensors`.
    """
    if (onnx is not None) + (to_run is not None) + starts != 1:
        raise InputError("name what to write: --onnx FILE, --to-run FOLDER or --starts")
    if onnx is not None:
        if onnx.suffix != ".onnx":
            raise InputError("expected a name that ends in .onnx", onnx)
        result, text = _write_onnx(load_weights(weights), onnx)
    elif starts:
        if weights == RELEASE:
            raise InputError("the authors' weights have no folder here; --starts is for weights of your own")
        result, text = _write_starts(load_weights(weights), Path(weights))
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


def _write_starts(bundle: Bundle, folder: Path) -> tuple[dict[str, Any], str]:
    made = _walked(bundle)
    path = save_starts(folder, made)
    result = {"starts": path, "styles": len(made), "of": len(bundle.codes), "licence": bundle.about.get("licence")}
    return result, f"{path}: starts of {len(made)} of {len(bundle.codes)} styles"


def _walked(bundle: Bundle) -> dict[str, Start]:
    """Starts by the data of the weights; raises InputError where these are not known or not at hand."""
    try:
        data, phases = bundle.about["data"], bundle.about["phases"]
    except KeyError as error:
        raise InputError(f"the weights do not say which {error.args[0]} they were trained with") from error
    store = VectorStore(load_catalogue(data, bundle.styles), phases)
    with tqdm(desc="starts", unit="frame", disable=None) as bar:
        return starts_from(bundle, store, bar.update)


def _with_starts(bundle: Bundle) -> Bundle:
    """The same with starts, where they can be made without a download: weights without them walk too."""
    try:
        at_hand = where(dataset(str(bundle.about.get("data")))) in ("folder", "cache", "mirror")
        return replace(bundle, starts=_walked(bundle)) if at_hand and not bundle.starts else bundle
    except InputError:
        return bundle


def _write_to_run(bundle: Bundle, weights: Path, folder: Path) -> tuple[dict[str, Any], str]:
    bundle = _with_starts(bundle)
    save_bundle(folder, bundle, to_run=True)
    card, licence = write_card(folder, bundle, weights), bundle.about.get("licence")
    size = sum(path.stat().st_size for path in folder.iterdir())
    result = {"folder": folder, "card": card, "styles": len(bundle.codes), "bytes": size, "licence": licence}
    text = (
        f"{folder}: {bundle.model} in {len(bundle.codes)} styles, starts of {len(bundle.starts)}, {size / 1e6:.1f} MB"
    )
    return result | {"starts": len(bundle.starts)}, f"{text}; {licence}"
