"""Count the parameters of every model: by arithmetic, by our modules, and as both papers print them."""

from stylephase.cli.output import AsJson, emit
from stylephase.evaluation.budget.paper_2018 import shares, table_1
from stylephase.evaluation.budget.paper_2022 import table_2
from stylephase.evaluation.budget.rows import Row


def count(as_json: AsJson = False) -> None:
    """Every row of both papers' parameter tables: arithmetic, our modules' count, the printed number, a verdict."""
    rows = [*table_2(), *table_1(), *shares()]
    found = [vars(row) | {"ours": row.counted, "value": row.value, "verdict": row.verdict} for row in rows]
    head = _line("table", "model", "quantity", ("arithmetic", "ours", "paper"), "verdict")
    emit({"rows": found}, as_json=as_json, text="\n".join([head, *map(_row, rows), *_notes(rows)]))


def _row(row: Row) -> str:
    form = ",.0f" if row.unit == "parameters" else ".4g"
    numbers = tuple(format(number, form) for number in (row.value, row.counted, row.paper))
    return _line(row.table, row.name, f"{row.quantity} ({row.unit})", numbers, row.verdict)


def _line(table: str, name: str, quantity: str, numbers: tuple[str, ...], verdict: str) -> str:
    columns = " ".join(f"{number:>10}" for number in numbers)
    return f"{table:13} {name:25} {quantity:30} {columns}  {verdict}"


def _notes(rows: list[Row]) -> list[str]:
    """The arithmetic of each number, once, and why a number differs."""
    sums = dict.fromkeys(f"{row.value:.10g} {row.unit} = {row.arithmetic}" for row in rows)
    notes = dict[str, str]()
    for row in rows:
        if row.note:
            notes.setdefault(row.note, f"{row.name}, {row.quantity}")
    return ["", *sums, "", *(f"{place}: {note}" for note, place in notes.items())]
