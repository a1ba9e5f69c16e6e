"""Recording what a notebook measured: its last cell writes figures/NN_name.json."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stylephase.errors import InputError
from stylephase.files import write_json
from stylephase.report.claims import (
    DIFFERS,
    NOT_TESTABLE,
    OTHER_DATA,
    REPRODUCED,
    Claim,
    Record,
    Result,
    Value,
    entry_fault,
    entry_of,
    finite,
    read_claims,
    within_bounds,
)
from stylephase.report.manifest import ROOT, manifest

QUICK, QUICK_NOTE = "quick", "the quick preset only shows that every step runs"


class Recorder:
    """Collects a notebook's results and writes them in one piece.

    `notebook` is the notebook's name (`04_training`), `dataset` and `preset` what it ran with, `params` all of its
    parameters, `data_files` the files that its numbers rest on (their hash goes into the manifest).
    """

    def __init__(
        self,
        notebook: str,
        *,
        dataset: str,
        preset: str,
        params: dict[str, Any],
        data_files: Iterable[Path] = (),
        root: Path = ROOT,
    ):
        self.notebook, self.dataset, self.preset, self.params = notebook, dataset, preset, params
        self.root, self.data_files = root, list(data_files)
        self.catalogue = read_claims(root / "data" / "claims.toml")
        self.entries: dict[str, dict[str, Any]] = {}
        self.numbers: dict[str, dict[str, Any]] = {}

    def claim(
        self,
        identifier: str,
        holds: bool | None = None,
        note: str = "",
        *,
        value: Any = None,
        n: int | None = None,
        seeds: Sequence[int] = (),
        tolerance: Value | None = None,
        dataset: str | None = None,
    ) -> str:
        """Record one claim and return its verdict.

        Whether it `holds` the bounds in claims.toml decide, and where it has none the notebook. What holds is
        "reproduced on other data" where the `dataset` of this claim (the notebook's unless given) is not the claim's.
        `n` is the number of cases behind the value. Raises InputError for an unknown claim, one of another notebook,
        one recorded twice, a value that is not finite, and a verdict that nothing decides, contradicts the bounds or
        lacks its note.
        """
        claim, value = self._fresh(identifier), _plain(value)
        if not finite(value):
            raise InputError(f"{identifier} has value {value}; expected finite values")
        if holds is None:
            if not claim.bounded or value is None:
                raise InputError(f"{identifier} needs a verdict: it has no {'value' if claim.bounded else 'bounds'}")
            holds = within_bounds(value, claim.at_least, claim.at_most)
        other = bool(claim.data) and claim.data != (dataset or self.dataset)
        verdict = (OTHER_DATA if other else REPRODUCED) if holds else DIFFERS
        if verdict == DIFFERS and not note and self.preset == QUICK:
            note = QUICK_NOTE
        tolerance = claim.bounds or None if tolerance is None else tolerance
        self._enter(claim, verdict, note, value=value, n=n, seeds=list(seeds), tolerance=tolerance)
        return verdict

    def not_testable(self, identifier: str, needs: str) -> None:
        """Record that a claim cannot be tested here, and what a test needs."""
        claim = self._fresh(identifier)
        self._enter(claim, NOT_TESTABLE, needs, value=None, n=None, seeds=[], tolerance=claim.bounds or None)

    def _fresh(self, identifier: str) -> Claim:
        if identifier not in self.catalogue.claims:
            raise InputError(f"{identifier} is not in claims.toml")
        if identifier in self.entries:
            raise InputError(f"{identifier} is recorded twice")
        return self.catalogue.claims[identifier]

    def _enter(self, claim: Claim, verdict: str, note: str, **measured: Any) -> None:
        entry = entry_of(claim, verdict=verdict, note=note, **measured)
        if reason := entry_fault(entry, self.notebook, self.catalogue):
            raise InputError(reason)
        self.entries[claim.id] = entry

    def number(self, name: str, value: Any, unit: str = "") -> None:
        """Record a number that belongs to no claim but is quoted in the text or compared by a test."""
        self.numbers[name] = {"value": _plain(value), "unit": unit}

    @property
    def record(self) -> Record:
        """What has been recorded so far, as it would be read back; the manifest is left empty."""
        return Record(self.notebook, tuple(Result(**entry) for entry in self.entries.values()), self.numbers, {})

    def write(self, folder: str | Path) -> None:
        """Write NN_name.json, whole or not at all, into the folder.

        A relative folder lies in the repository, wherever the notebook was started.
        """
        facts = manifest(
            notebook=self.notebook,
            dataset=self.dataset,
            preset=self.preset,
            params=self.params,
            data_files=self.data_files,
            root=self.root,
        )
        whole: dict[str, Any] = {"claims": list(self.entries.values()), "manifest": facts}
        if self.numbers:
            whole["numbers"] = self.numbers
        write_json(self.root / folder / f"{self.notebook}.json", whole)


def _plain(value: Any) -> Any:
    """NumPy scalars and arrays as Python's own numbers and lists, tuples as lists."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value
