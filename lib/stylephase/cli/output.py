"""What a subcommand prints: a text for people, or one JSON object for scripts.

Results go to standard output; progress bars and messages go to standard error.
"""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object last on standard output.")]


def emit(result: dict[str, Any], *, as_json: bool, text: str | None = None) -> None:
    """Print a subcommand's result: as one line of JSON, or as `text` (left out: one line for each entry).

    NumPy values and paths become plain JSON; NaN and infinity raise ValueError, since JSON has neither.
    """
    if as_json:
        typer.echo(json.dumps(result, ensure_ascii=False, allow_nan=False, default=_plain))
    elif text is None:
        typer.echo("\n".join(f"{name}: {value}" for name, value in result.items()))
    else:
        typer.echo(text)


def _plain(value: Any) -> Any:
    if isinstance(value, Path):
        return str(value)
    return value.tolist()
