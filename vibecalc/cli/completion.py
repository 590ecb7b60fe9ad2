"""What a shell offers after the tab key: keys and names of cases, quantities and pictures."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from vibecalc.cli.saying import say
from vibecalc.errors import UsageError

SHELLS = ("bash", "zsh", "fish", "powershell")
#: set by the script in the shell when it asks
VARIABLE = "_VIBECALC_COMPLETE"


def completion(
    shell: Annotated[str, typer.Argument(metavar="SHELL", help=f"{', '.join(SHELLS)}.")],
) -> None:
    """Print the script that lets a shell complete commands, options, keys and quantities."""
    from typer.completion import get_completion_script  # type: ignore[attr-defined]

    if shell not in SHELLS:
        raise UsageError(f"no script for {shell[:40]!r}; there are {', '.join(SHELLS)}")
    script = get_completion_script(prog_name="vibecalc", complete_var=VARIABLE, shell=shell)
    say(script)


def answer_shells() -> None:
    """Let typer answer the shell's question, with the classes that its scripts belong to."""
    from typer.completion import completion_init  # type: ignore[attr-defined]

    completion_init()


def keys(ctx: typer.Context, incomplete: str) -> list[str]:
    """`machine.speed=` and so on: keys of the first case on the line, as `--set` takes them."""
    return [f"{key}=" for key in _keys(ctx) if key.startswith(incomplete)]


def names_of_keys(ctx: typer.Context, incomplete: str) -> list[str]:
    """The same without the sign, as `--unset` takes them."""
    return [key for key in _keys(ctx) if key.startswith(incomplete)]


def quantities(ctx: typer.Context, incomplete: str) -> list[str]:
    """Paths of the quantities of the result on the line."""
    return [path for path in _listed(ctx) if path.startswith(incomplete)]


def names_of_pictures(ctx: typer.Context, incomplete: str) -> list[str]:
    """Names of pictures."""
    from vibecalc.core.report.plots import every_picture

    return [name for name in every_picture() if name.startswith(incomplete)]


def beginnings(ctx: typer.Context, incomplete: str) -> list[str]:
    """Names of starters, after `--example` those of the shipped cases."""
    from vibecalc.cli.starters import examples, scenes

    names = examples() if ctx.params.get("example") else {**scenes(), "list": ""}
    return [name for name in names if name.startswith(incomplete)]


def _keys(ctx: typer.Context) -> list[str]:
    import tomllib

    with suppress(OSError, ValueError):
        text = _first(ctx, "case", "cases", "file").read_text(encoding="utf-8")
        return list(_leaves(tomllib.loads(text)))
    return []


def _leaves(value: Any, path: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for key, one in value.items():
            yield from _leaves(one, f"{path}.{key}" if path else key)
    elif isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
        for number, one in enumerate(value):
            yield from _leaves(one, f"{path}[{number}]")
    else:
        yield path


def _listed(ctx: typer.Context) -> list[str]:
    import json

    with suppress(Exception):  # whatever is wrong with the file, the command says it
        import h5py

        with h5py.File(_first(ctx, "result", "file"), "r", locking=False) as file:
            return [str(path) for path in json.loads(file.attrs["quantities"])]
    return []


def _first(ctx: typer.Context, *names: str) -> Path:
    """The first file on the line; while an option waits for its value, it is among the rest."""
    for given in (*(ctx.params.get(name) for name in names), ctx.args):
        if given:
            return Path(given[0] if isinstance(given, list | tuple) else given)
    raise OSError("no file on the line yet")
