"""Check that the authors' released network runs here as it should."""

from pathlib import Path
from typing import Annotated

import typer

from stylephase.cli.output import AsJson, emit
from stylephase.errors import InputError
from stylephase.evaluation.release import TOLERANCE, Agreement, compare, made_golden, read_golden
from stylephase.models.released import fetch_released


def check_release(
    golden: Annotated[Path | None, typer.Option(help="Recorded inputs and outputs (NPZ) to compare with.")] = None,
    as_json: AsJson = False,
) -> None:
    """Run the released LPN and print the largest absolute error of each part, in float32 and float64.

    Without recorded values it is compared with a plain float64 form in NumPy that blends the weights of each row
    first. Both layer normalisations are checked, the demonstration's and the training's. Exit 2 if they disagree.
    """
    recorded = None if golden is None else read_golden(golden)
    released = fetch_released()
    inputs = recorded or made_golden(released)
    found = compare(released, inputs)
    beside = "a plain form in NumPy" if golden is None else str(golden)
    rows = [vars(one) | {"tolerance": TOLERANCE[one.precision], "holds": one.holds} for one in found]
    result = {"against": beside, "inputs": len(inputs.x), "holds": all(one.holds for one in found), "parts": rows}
    lines = [f"the released LPN against {beside}, {len(inputs.x)} inputs; absolute error, and over the largest value"]
    emit(result, as_json=as_json, text="\n".join([*lines, *map(_line, found)]))
    if wrong := [one for one in found if not one.holds]:
        raise InputError(f"the released network disagrees in {len(wrong)} parts; the first: {_line(wrong[0])}", golden)


def _line(one: Agreement) -> str:
    verdict = "agrees" if one.holds else f"beyond {TOLERANCE[one.precision]:g}"
    numbers = f"{one.absolute:9.2e} {one.relative:9.2e}"
    return f"{one.precision} {one.form:9} {one.part:14} {numbers}  {verdict}"
