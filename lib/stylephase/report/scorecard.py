"""The scorecard: every claim with the paper's value, ours and a verdict, as Markdown.

`python -m stylephase.report.scorecard --write` brings the README's two sections and the statuses in data/claims.toml
into step with figures/*.json; `--check` fails where they are stale.
"""

import argparse
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from stylephase.errors import InputError
from stylephase.files import write_text
from stylephase.report.claims import (
    DIFFERS,
    OTHER_DATA,
    PAPERS,
    REPRODUCED,
    STATUSES,
    VERDICTS,
    Catalogue,
    Claim,
    Record,
    Result,
    read_claims,
    read_records,
    recorded_ids,
)
from stylephase.report.made import admitted
from stylephase.report.manifest import ROOT

OPEN, RECORDED = STATUSES
OUTCOMES = (*VERDICTS, OPEN)
HEADLINE, SCORECARD = "headline", "scorecard"
# Numbers and settings can agree because a thing is built alike; these say how it behaves.
_STATEMENTS = ("ordering", "qualitative", "figure")
HOW_SURE = (
    "Square brackets hold 95 % intervals, over styles, and over seeds where there are several; where one style is "
    "judged (notebook 06), over starts of one training, which say nothing of another. A claim that differs with an "
    "interval on both sides of no effect was not shown, which is less than contradicted."
)
MAIN_HEADER = "| What the papers say | Verdict | What we found | Notebook |\n|---|---|---|---|"
HEADER = "| Where | Claim | Paper | Ours | Verdict | Notebook |\n|---|---|---|---|---|---|"


def results_of(records: Iterable[Record]) -> dict[str, Result]:
    """All results by the id of their claim."""
    return {result.id: result for record in records for result in record.results}


def group_of(claim: Claim) -> str:
    """The group in which a claim is counted: its paper, and whether it says how something behaves."""
    kind = "statements and figures" if claim.kind in _STATEMENTS else "numbers and settings"
    return PAPERS[claim.paper] if claim.paper == "ours" else f"{PAPERS[claim.paper]}, {kind}"


def counts(catalogue: Catalogue, records: Iterable[Record]) -> dict[str, Counter[str]]:
    """For each group of claims how many have each verdict, and how many are still open."""
    results, order = results_of(records), list(PAPERS)
    claims = sorted(catalogue.claims.values(), key=lambda c: (order.index(c.paper), c.kind not in _STATEMENTS))
    table = {group_of(claim): Counter({outcome: 0 for outcome in OUTCOMES}) for claim in claims}
    for claim in claims:
        table[group_of(claim)][_outcome(claim, results)] += 1
    return table


def _outcome(claim: Claim, results: Mapping[str, Result]) -> str:
    return results[claim.id].verdict if claim.id in results else OPEN


def outcomes(table: Mapping[str, Counter[str]]) -> tuple[str, ...]:
    """All verdicts, and `open` where a claim is."""
    return OUTCOMES if any(row[OPEN] for row in table.values()) else VERDICTS


def summary_line(catalogue: Catalogue, records: Iterable[Record]) -> str:
    """One sentence: how many claims there are and how many have each outcome."""
    table = counts(catalogue, records)
    whole = sum(table.values(), Counter())
    told = ", ".join(f"{whole[outcome]} {outcome}" for outcome in outcomes(table))
    return f"{len(catalogue.claims)} claims: {told}."


def summary(catalogue: Catalogue, records: Iterable[Record]) -> str:
    """The summary line and a table of counts, a row for each group of claims."""
    table = counts(catalogue, records)
    shown = outcomes(table)
    lines = [summary_line(catalogue, records), "", f"| | {' | '.join(shown)} |", "|---" * (len(shown) + 1) + "|"]
    lines += [
        f"| {title} | " + " | ".join(str(row[outcome]) for outcome in shown) + " |" for title, row in table.items()
    ]
    return "\n".join(lines)


def headline(catalogue: Catalogue, records: Iterable[Record]) -> str:
    """What became of the papers' claims, without our own, and which of the main ones do not reproduce."""
    results = results_of(records)
    claims = [claim for claim in catalogue.claims.values() if claim.paper != "ours"]
    main, said = [claim for claim in claims if claim.main], [claim for claim in claims if claim.kind in _STATEMENTS]
    held = [claim for claim in main if _outcome(claim, results) in (REPRODUCED, OTHER_DATA)]
    missed = [claim for claim in main if _outcome(claim, results) == DIFFERS]
    lines = [
        f"The two papers make {len(claims)} claims: {_told(claims, results)}. The statements and figures among them, "
        f"which say how models behave, {len(said)}: {_told(said, results)}.",
        "",
        f"Of the {len(main)} main claims {len(held)} hold. **These do not reproduce:**",
        "",
        *(f"* {claim.name} ({claim.paper}, {claim.where})" for claim in missed),
        *_minutes(results),
    ]
    return "\n".join(lines)


def _minutes(results: Mapping[str, Result]) -> list[str]:
    """How long the two commands took, where that was measured."""
    took = [results[name].value for name in ("ours-reproduce-minutes", "ours-test-minutes") if name in results]
    if len(took) < 2:
        return []
    text = "From a fresh clone on two cores, set-up included, `make reproduce` took {} minutes and `make test` {}."
    return ["", text.format(*took)]


def _told(claims: Sequence[Claim], results: Mapping[str, Result]) -> str:
    found = Counter(_outcome(claim, results) for claim in claims)
    return ", ".join(f"{found[outcome]} {outcome}" for outcome in OUTCOMES if found[outcome])


def tables(catalogue: Catalogue, records: Iterable[Record], links: str, only_tested: bool = False) -> str:
    """A table for each paper, its rows in the order of the sections; `links` leads from the text to the notebooks."""
    results, parts = results_of(records), []
    for paper, title in PAPERS.items():
        claims = [c for c in catalogue.claims.values() if c.paper == paper and (c.id in results or not only_tested)]
        if claims:
            rows = [row(claim, results.get(claim.id), links) for claim in claims]
            parts.append("\n".join([f"**{title[0].upper()}{title[1:]}**", "", HEADER, *rows]))
    return "\n\n".join(parts)


def main_table(catalogue: Catalogue, records: Iterable[Record], links: str) -> str:
    """The main claims in the order of the file: what became of each, with the numbers and reasons that were noted."""
    results = results_of(records)
    rows = [_main_row(claim, results.get(claim.id), links) for claim in catalogue.claims.values() if claim.main]
    return "\n".join([MAIN_HEADER, *rows]) if rows else ""


def _main_row(claim: Claim, result: Result | None, links: str) -> str:
    found = _found(result.value, claim.unit, result.note) if result else ""
    cells = (f"{claim.name} ({claim.paper}, {claim.where})", result.verdict if result else OPEN, found)
    return "| " + " | ".join([*map(_cell, cells), _link(claim, links) if result else claim.notebook[:2]]) + " |"


def _found(value: Any, unit: str, note: str) -> str:
    """A value and what its note says of it: once, where the note tells the same numbers.

    >>> _found([0.02, 0.971], "", "share held: alone, ours"), _found([0.8669], "", "ratio 0.867 [0.8, 0.9]")
    ('0.02 / 0.971: share held: alone, ours', 'ratio 0.867 [0.8, 0.9]')
    >>> _found(1.0, "s", "worse by -1.1"), _found(1.0, "", "1 of 2")
    ('1 s: worse by -1.1', '1 of 2')
    """
    parts = value if isinstance(value, list) else [value]
    numbers = [f"{part:.3g}" if isinstance(part, int | float) and not isinstance(part, bool) else "" for part in parts]
    said = note and all(number and re.search(rf"(?<![\d.-]){re.escape(number)}(?!\d|\.\d)", note) for number in numbers)
    return note if said else ": ".join(part for part in (shown(value, unit), note) if part)


def row(claim: Claim, result: Result | None, links: str) -> str:
    """One row: what the number is of, or the reason, stands beside the verdict."""
    verdict = result.verdict if result else OPEN
    if result and result.note:
        verdict = f"{verdict}: {result.note}"
    asked = shown(claim.paper_value, claim.unit) if claim.paper_value is not None else claim.bounds
    ours = shown(result.value, claim.unit) if result else ""
    notebook = _link(claim, links) if result else claim.notebook[:2]
    return "| " + " | ".join(_cell(part) for part in (claim.where, claim.name, asked, ours, verdict, notebook)) + " |"


def _link(claim: Claim, links: str) -> str:
    return f"[{claim.notebook[:2]}]({links}{claim.notebook}.ipynb)"


def shown(value: Any, unit: str) -> str:
    """A value with its unit: digits grouped by thousands, four significant ones after a point.

    >>> shown(4935928, "parameters"), shown([4.53, 0.0449], "ms")
    ('4,935,928 parameters', '4.53 / 0.0449 ms')
    """
    if value is None:
        return ""
    if isinstance(value, list):
        return f"{' / '.join(shown(part, '') for part in value)} {unit}".rstrip()
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = value if isinstance(value, str) else f"{value:,}" if isinstance(value, int) else f"{value:.4g}"
    return f"{text} {unit}".rstrip()


def older(stale: Mapping[str, str]) -> str:
    """A sentence on the notebooks that are older than their code or data, with the reasons; "" where none is.

    >>> older({"05_test_error": "its trainings take three hours"})
    'Made by earlier code, not made again yet: 05 (its trainings take three hours).'
    """
    reasons = ", ".join(f"{name[:2]} ({reason})" for name, reason in sorted(stale.items()))
    return f"Made by earlier code, not made again yet: {reasons}." if stale else ""


def section(catalogue: Catalogue, records: Sequence[Record], stale: Mapping[str, str] | None = None) -> str:
    """The README's scorecard: counts, the main claims, then all that were tested, folded away.

    `stale` are notebooks that are older than their code or data, with the reasons; they are named below the counts.
    """
    parts = [summary(catalogue, records), "", HOW_SURE, "", *([older(stale), ""] if stale else [])]
    if main := main_table(catalogue, records, "notebooks/"):
        parts += [main, ""]
    if tested := tables(catalogue, records, "notebooks/", only_tested=True):
        parts += ["<details><summary>All claims, each with what was found</summary>", "", tested, "", "</details>", ""]
    return "\n".join([*parts, "How verdicts are given: [notebook 00](notebooks/00_scorecard.ipynb)."])


def marks(name: str) -> tuple[str, str]:
    """Where a section of the README begins and where it ends."""
    return f"<!-- {name} -->", f"<!-- /{name} -->"


def with_section(text: str, name: str, new: str, path: Path) -> str:
    """`text` with one of its sections replaced; raises InputError where the marks are missing."""
    first, last = marks(name)
    before, begin, rest = text.partition(first)
    _, end, after = rest.partition(last)
    if not (begin and end):
        raise InputError(f"expected the marks {first} and {last}", path)
    return f"{before}{first}\n{new}\n{last}{after}"


def with_statuses(text: str, recorded: Iterable[str]) -> str:
    """The text of claims.toml with each claim's status as the records have it."""
    recorded = set(recorded)
    pattern = re.compile(r'^(id = "(?P<id>[^"]+)"\n(?:(?!\[\[)[^\n]+\n)*?status = )"\w+"$', re.MULTILINE)
    return pattern.sub(lambda match: f'{match[1]}"{RECORDED if match["id"] in recorded else OPEN}"', text)


def expected_files(root: Path = ROOT) -> dict[Path, str]:
    """What README.md and data/claims.toml should hold, by path."""
    readme, listed = root / "README.md", root / "data" / "claims.toml"
    catalogue = read_claims(listed)
    records = read_records(root / "figures", catalogue)
    told = with_section(readme.read_text(encoding="utf-8"), HEADLINE, headline(catalogue, records), readme)
    return {
        readme: with_section(told, SCORECARD, section(catalogue, records, admitted(root)), readme),
        listed: with_statuses(listed.read_text(encoding="utf-8"), recorded_ids(records)),
    }


def stale_files(root: Path = ROOT) -> list[Path]:
    """Those of the two files that are out of step with figures/*.json."""
    return [path for path, text in expected_files(root).items() if path.read_text(encoding="utf-8") != text]


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """Write, check or print the scorecard; exit status 1 where it is stale, 2 for bad input."""
    parser = argparse.ArgumentParser(prog="python -m stylephase.report.scorecard", description=__doc__)
    parser.add_argument("--write", action="store_true", help="update README.md and data/claims.toml")
    parser.add_argument("--check", action="store_true", help="fail where they are stale")
    asked = parser.parse_args(arguments)
    try:
        stale = stale_files(root)
        if asked.write:
            for path in stale:
                write_text(path, expected_files(root)[path])
        elif asked.check and stale:
            names = ", ".join(str(path.relative_to(root)) for path in stale)
            print(f"stale: {names}; run python -m stylephase.report.scorecard --write", file=sys.stderr)
            return 1
        catalogue = read_claims(root / "data" / "claims.toml")
        print(summary_line(catalogue, read_records(root / "figures", catalogue)))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    sys.exit(main())
