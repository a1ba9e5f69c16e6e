"""The command `stylephase`.

To add a subcommand, add a module to this folder; its name is the command's name (`check_release.py` is
`stylephase check-release`) and the first line of its docstring is the line in `stylephase --help`.

- A module with a function of its own name is a command: `phases.py` defines `phases`.
- Any other module is a group: each public function defined in it is a command, so `ls` in `data.py` is
  `stylephase data ls`.

The functions are plain: typer reads their annotated parameters, and their docstring is the help. Each takes
`as_json: AsJson = False` and prints by `emit` (output.py). Bad input is raised as InputError. Only the module that
the user asks for is imported, so that no command waits for the libraries of another.
"""

import ast
import errno
import importlib
import inspect
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Annotated, NoReturn

import typer
from typer.exceptions import TyperException

from stylephase import __version__
from stylephase.errors import InputError

_FOLDER = Path(__file__).parent
_NOT_COMMANDS = {"__init__", "app", "output"}
BAD_INPUT, INTERRUPTED = 2, 130


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and exit: 0 success, 2 bad input with one line on standard error, 130 interrupted.

    Any other exception is a mistake of the program and shows its traceback.
    """
    words = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    command = typer.main.get_command(build(asked=next((word for word in words if not word.startswith("-")), None)))
    try:
        status = command.main(words, prog_name="stylephase", standalone_mode=False)
    except (InputError, TyperException) as error:
        _fail(str(error) if isinstance(error, InputError) else error.format_message(), BAD_INPUT)
    except OSError as error:
        if error.errno != errno.ENOSPC:
            raise
        _fail(str(InputError("no space left on the disk", error.filename)), BAD_INPUT)
    except KeyboardInterrupt:
        status = INTERRUPTED
    if status == INTERRUPTED:
        _fail("interrupted", INTERRUPTED)
    sys.exit(status or 0)


def command_names() -> list[str]:
    """Names of the subcommands, from the files of this folder."""
    stems = {path.stem for path in _FOLDER.glob("*.py")} - _NOT_COMMANDS
    return sorted(stem.replace("_", "-") for stem in stems)


def build(asked: str | None) -> typer.Typer:
    """The typer application, with the command `asked` for; of the others it knows the name and one line of help."""
    app = typer.Typer(name="stylephase", add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    app.callback()(_options)
    for name in command_names():
        stem = name.replace("-", "_")
        if name == asked:
            _add(app, name, importlib.import_module(f"stylephase.cli.{stem}"))
        else:
            app.command(name, help=_summary((_FOLDER / f"{stem}.py").read_text(encoding="utf-8")))(_not_asked)
    return app


def _add(app: typer.Typer, name: str, module: ModuleType) -> None:
    """Add a module's function, or its public functions as a group."""
    single = vars(module).get(module.__name__.rpartition(".")[2])
    if inspect.isfunction(single):
        app.command(name)(single)
        return
    group = typer.Typer(help=module.__doc__, rich_markup_mode=None)
    group.callback()(_no_options)
    for function in _public_functions(module):
        group.command(function.__name__.replace("_", "-"))(function)
    app.add_typer(group, name=name)


def _public_functions(module: ModuleType) -> list[Callable[..., None]]:
    functions = (value for key, value in vars(module).items() if not key.startswith("_") and inspect.isfunction(value))
    return [function for function in functions if function.__module__ == module.__name__]


def _summary(source: str) -> str:
    """First line of a module's docstring, read without running the module."""
    return (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]


def _fail(message: str, status: int) -> NoReturn:
    typer.echo(f"stylephase: {' '.join(message.split())}", err=True)
    sys.exit(status)


def _show_version(wanted: bool) -> bool:
    if wanted:
        typer.echo(f"stylephase {__version__}")
        raise typer.Exit
    return wanted


def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Style modelling of human walking: local motion phases, FiLM and residual adapters, replicated."""


def _no_options() -> None:
    """A callback keeps a group with one command a group."""


def _not_asked() -> None:
    """Stands for a command that the user did not ask for."""
