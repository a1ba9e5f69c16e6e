"""What a command says of bad input."""


def refused(result: tuple[int, str, str]) -> str:
    """The one line of a call that must have failed for bad input; the result is status, standard output and error."""
    status, out, err = result
    assert (status, out, err.count("\n")) == (2, "", 1) and err.startswith("stylephase: ")
    return err.removeprefix("stylephase: ").rstrip("\n")
