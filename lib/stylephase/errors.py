"""The one exception for input that the user can mend; the command line turns it into one line and exit status 2."""

from pathlib import Path


class InputError(ValueError):
    """Bad input: what is wrong, and where.

    The message reads `file:line: reason`, with the parts that are known.
    """

    def __init__(self, reason: str, path: str | Path | None = None, line: int | None = None):
        self.reason, self.path, self.line = reason, path, line
        place = "" if path is None else f"{path}: " if line is None else f"{path}:{line}: "
        super().__init__(f"{place}{' '.join(reason.split())}")
