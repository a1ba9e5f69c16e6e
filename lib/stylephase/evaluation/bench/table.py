"""All that is measured. To add rows, write a function that gives a list of `Row` and name it in `BENCHES`."""

from collections.abc import Callable

from stylephase.evaluation.bench.crowds import crowd_rows
from stylephase.evaluation.bench.frames import frame_rows
from stylephase.evaluation.bench.phases import phase_rows
from stylephase.evaluation.bench.rows import Row
from stylephase.evaluation.bench.training import training_rows

BENCHES: dict[str, Callable[[], list[Row]]] = {
    "phases": phase_rows,
    "training": training_rows,
    "frames": frame_rows,
    "crowds": crowd_rows,
}


def as_text(rows: list[Row]) -> str:
    """The table for people."""
    lines = [f"{'':52} {'ours':>9} {'reference':>9} {'ratio':>6} {'unit':7} target"]
    for row in rows:
        verdict = f"{row.target}: {'met' if row.met else 'missed'}" if row.target else ""
        numbers = f"{row.ours:9.4g} {row.reference:9.4g} {row.ratio:6.2f}"
        lines.append(f"{row.name:52} {numbers} {row.unit:7} {verdict}")
        lines += [f"    {row.note}"] if row.note else []
    return "\n".join(lines)


def as_json(row: Row) -> dict[str, object]:
    """One row for scripts."""
    return vars(row) | {"ratio": row.ratio, "target": row.target, "met": row.met}
