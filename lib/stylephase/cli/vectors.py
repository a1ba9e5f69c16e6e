"""Compute the networks' vectors of a data set, style by style, into the cache."""

from typing import Annotated

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.data.catalogue import load_catalogue
from stylephase.features.store import VectorStore


def vectors(
    data: Annotated[str, typer.Option(help="A data set's name, or own:FOLDER.")],
    styles: Annotated[str | None, typer.Option(help="Names of styles, with commas between; left out: all.")] = None,
    phases: Annotated[str, typer.Option(help="Variant of the local phases.")] = "adaptive",
    as_json: AsJson = False,
) -> None:
    """Compute the vectors of some styles, or of all; what is in the cache already is left as it is."""
    store = VectorStore(load_catalogue(data), phases)
    chosen = store.catalogue.styles if styles is None else load_catalogue(data, styles.split(",")).styles
    rows = {style: len(store.load(style).x) for style in tqdm(chosen, desc="vectors", unit="style", disable=None)}
    emit(
        {"data": data, "folder": store.folder, "rows": rows},
        as_json=as_json,
        text=f"{sum(rows.values())} rows in {store.folder}",
    )
