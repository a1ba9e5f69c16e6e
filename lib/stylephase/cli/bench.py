"""Measure speed and memory, each figure beside its reference in the same run."""

from typing import Annotated

import typer
from tqdm import tqdm

from stylephase.cli.output import AsJson, emit
from stylephase.errors import InputError
from stylephase.evaluation.bench.table import BENCHES, as_text
from stylephase.evaluation.bench.table import as_json as row_json


def bench(
    only: Annotated[str | None, typer.Option(help=f"One part of it: {', '.join(BENCHES)}.")] = None,
    as_json: AsJson = False,
) -> None:
    """Time training and running, ours against a reference in turns, with the ratio and whether the target is met."""
    if only is not None and only not in BENCHES:
        raise InputError(f"no part {only!r}; there are {', '.join(BENCHES)}")
    chosen = [only] if only else list(BENCHES)
    rows = [row for name in tqdm(chosen, desc="bench", unit="part", disable=None) for row in BENCHES[name]()]
    emit({"rows": [row_json(row) for row in rows]}, as_json=as_json, text=as_text(rows))
