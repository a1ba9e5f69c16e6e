"""The papers' claims (data/claims.toml) and what became of them (figures/NN_name.json)."""

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from stylephase.errors import InputError
from stylephase.files import read_json

REPRODUCED, OTHER_DATA = "reproduced", "reproduced on other data"
DIFFERS, NOT_TESTABLE = "differs", "not testable here"
VERDICTS = (REPRODUCED, OTHER_DATA, DIFFERS, NOT_TESTABLE)
PAPERS = {"M22": "2022 paper", "M18": "2018 paper", "ours": "beyond both"}
KINDS = ("number", "ordering", "qualitative", "figure", "protocol")
STATUSES = ("open", "recorded")
Number = int | float
Value = Number | str | list[Number]


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One claim, as data/claims.toml lists it; that file's head explains each field."""

    id: str
    paper: str
    where: str
    name: str
    kind: str
    notebook: str
    status: str
    paper_value: Number | list[Number] | None = None
    unit: str = ""
    at_least: Number | None = None
    at_most: Number | None = None
    data: str = ""
    main: bool = False

    @property
    def bounded(self) -> bool:
        """Whether a bound decides the verdict."""
        return self.at_least is not None or self.at_most is not None

    @property
    def bounds(self) -> str:
        """The bounds in words, "" where there are none."""
        words = {"at least": self.at_least, "at most": self.at_most}
        return ", ".join(f"{word} {bound:g}" for word, bound in words.items() if bound is not None)


@dataclass(frozen=True, kw_only=True)
class Result:
    """What became of one claim: our value (None where there is none), from `n` cases and the `seeds`, and a verdict."""

    id: str
    name: str
    paper: str
    where: str
    paper_value: Number | list[Number] | None
    value: Value | bool | None
    unit: str
    n: int | None
    seeds: list[int]
    tolerance: Value | None
    verdict: str
    note: str


@dataclass(frozen=True)
class Catalogue:
    """All claims by id, in the order of the file, and the notebooks with their titles."""

    notebooks: Mapping[str, str]
    claims: Mapping[str, Claim]


@dataclass(frozen=True)
class Record:
    """What one notebook recorded: results of claims, further numbers, and the manifest of both."""

    notebook: str
    results: tuple[Result, ...]
    numbers: Mapping[str, Any]
    manifest: Mapping[str, Any]


def within_bounds(value: Any, at_least: Number | None, at_most: Number | None) -> bool:
    """Whether a number, or every element of an array, lies within the bounds given, both ends included.

    Raises ValueError without any bound and for a value that is not finite.

    >>> within_bounds(0.3, None, 0.3), within_bounds([0.3, 0.4], None, 0.3)
    (True, False)
    """
    if at_least is None and at_most is None:
        raise ValueError("expected a bound to judge by")
    values = np.asarray(value)
    if not np.all(np.isfinite(values)):
        raise ValueError(f"expected finite values, got {value}")
    low, high = (-np.inf if at_least is None else at_least), (np.inf if at_most is None else at_most)
    return bool(np.all((low <= values) & (values <= high)))


def read_claims(path: str | Path) -> Catalogue:
    """Read claims.toml; raises InputError, with the line of the claim, for anything that is not as its head says."""
    text = _read(path)
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not TOML: {error}", path) from error
    notebooks, claims = tables.get("notebooks", {}), {}
    for table in tables.get("claim", []):
        identifier = table.get("id", "without id")
        reason = _table_fault(table, notebooks) or ("is listed twice" if identifier in claims else None)
        if reason:
            line = text[: text.rfind(f'id = "{identifier}"')].count("\n") + 1
            raise InputError(f"claim {identifier} {reason}", path, line)
        claims[identifier] = Claim(**table)
    return Catalogue(notebooks, claims)


def read_record(path: str | Path, catalogue: Catalogue) -> Record:
    """Read one figures/NN_name.json and check it against the catalogue; raises InputError with the file's name."""
    whole, notebook = read_json(path), Path(path).stem
    if not isinstance(whole, dict) or not {"claims", "manifest"} <= set(whole):
        raise InputError('expected an object with "claims" and "manifest"', path)
    results: dict[str, Result] = {}
    for entry in whole["claims"]:
        identifier = entry.get("id", "without id")
        reason = f"{identifier} is recorded twice" if identifier in results else entry_fault(entry, notebook, catalogue)
        if reason:
            raise InputError(reason, path)
        results[identifier] = Result(**entry)
    return Record(notebook, tuple(results.values()), whole.get("numbers", {}), whole["manifest"])


def read_records(folder: str | Path, catalogue: Catalogue) -> list[Record]:
    """Read every NN_name.json of the folder, in the order of their names; a folder that is missing holds none."""
    return [read_record(path, catalogue) for path in sorted(Path(folder).glob("[0-9][0-9]_*.json"))]


def entry_fault(entry: Mapping[str, Any], notebook: str, catalogue: Catalogue) -> str | None:
    """Why an entry of a JSON file is not a valid result of the notebook, or None."""
    claim = catalogue.claims.get(entry.get("id", ""))
    if claim is None:
        return f"{entry.get('id')} is not in claims.toml"
    if set(entry) != {field.name for field in fields(Result)}:
        return f"{claim.id} has other fields than {', '.join(field.name for field in fields(Result))}"
    if claim.notebook != notebook:
        return f"{claim.id} belongs to notebook {claim.notebook}"
    copied = ("name", "paper", "where", "paper_value", "unit")
    if changed := [name for name in copied if entry[name] != getattr(claim, name)]:
        return f"{claim.id} is out of date: {', '.join(changed)} changed in claims.toml; run the notebook again"
    return _judgement_fault(entry, claim)


def _judgement_fault(entry: Mapping[str, Any], claim: Claim) -> str | None:
    verdict, value = entry["verdict"], entry["value"]
    if verdict not in VERDICTS:
        return f"{claim.id} has verdict {verdict!r}; expected one of {', '.join(VERDICTS)}"
    if verdict in (DIFFERS, NOT_TESTABLE) and not entry["note"]:
        return f"{claim.id} {verdict} and needs a note: {'the reason' if verdict == DIFFERS else 'what it needs'}"
    if not finite(value):
        return f"{claim.id} has value {value}; expected finite values"
    if verdict == NOT_TESTABLE:
        return None
    if value is None and claim.kind == "number":
        return f"{claim.id} has no value"
    if claim.bounded and within_bounds(value, claim.at_least, claim.at_most) == (verdict == DIFFERS):
        return f"{claim.id} has value {value} and verdict {verdict!r}, but claims.toml asks for {claim.bounds}"
    return None


def finite(value: Any) -> bool:
    """Whether a value, or every number of a list, is finite; what is no number counts as finite."""
    numbers = value if isinstance(value, list) else [value]
    return all(math.isfinite(number) for number in numbers if isinstance(number, float))


def _table_fault(table: Mapping[str, Any], notebooks: Mapping[str, str]) -> str | None:
    """Why a table of claims.toml is not a claim, or None."""
    names = {field.name for field in fields(Claim)}
    required = [field.name for field in fields(Claim) if field.default is MISSING]
    if unknown := set(table) - names:
        return f"has unknown fields: {', '.join(sorted(unknown))}"
    if missing := [name for name in required if not table.get(name)]:
        return f"lacks {', '.join(missing)}"
    choices = {"paper": PAPERS, "kind": KINDS, "status": STATUSES, "notebook": notebooks}
    for field, allowed in choices.items():
        if table[field] not in allowed:
            return f"has {field} {table[field]!r}; expected one of {', '.join(allowed)}"
    return None


def _read(path: str | Path) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror}", path) from error


def entry_of(claim: Claim, **measured: Any) -> dict[str, Any]:
    """The entry of a JSON file that states what was measured for a claim."""
    return asdict(
        Result(
            id=claim.id,
            name=claim.name,
            paper=claim.paper,
            where=claim.where,
            paper_value=claim.paper_value,
            unit=claim.unit,
            **measured,
        )
    )


def recorded_ids(records: Iterable[Record]) -> set[str]:
    """Ids of all claims that have a result."""
    return {result.id for record in records for result in record.results}
