"""The one exception for input that the user can mend; the command line turns it into one line and exit status 2."""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path


class InputError(ValueError):
    """Bad input: what is wrong, and where.

    The message reads `file:line: reason`, with the parts that are known.
    """

    def __init__(self, reason: str, path: str | Path | None = None, line: int | None = None):
        self.reason, self.path, self.line = reason, path, line
        place = "" if path is None else f"{path}: " if line is None else f"{path}:{line}: "
        super().__init__(f"{place}{' '.join(reason.split())}")


def hint(asked: str, known: Iterable[str]) -> str:
    """What to say after an unknown name: the known ones that are spelt alike, or else all of them.

    >>> hint("zombi", ["Old", "Zombie"])
    'did you mean Zombie?'
    >>> hint("x", ["Old", "Zombie"])
    'there are Old, Zombie'
    """
    by_lower = {name.lower(): name for name in known}
    close = [by_lower[name] for name in get_close_matches(asked.lower(), by_lower, n=5)]
    return f"did you mean {' or '.join(close)}?" if close else f"there are {', '.join(by_lower.values())}"
