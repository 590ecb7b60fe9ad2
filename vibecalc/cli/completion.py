"""What a shell offers after the tab key: keys and names of cases, quantities and pictures."""

import os
import shlex
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import typer

from vibecalc.cli.saying import say
from vibecalc.errors import UsageError

SHELLS = ("bash", "zsh", "fish", "powershell")
#: set by the script in the shell when it asks
VARIABLE = "_VIBECALC_COMPLETE"


def completion(
    shell: str = typer.Argument(metavar="SHELL", help=f"{', '.join(SHELLS)}."),
) -> None:
    """Print the script that lets a shell complete commands, options, keys and quantities."""
    from typer.completion import get_completion_script  # type: ignore[attr-defined]

    if shell not in SHELLS:
        raise UsageError(f"no script for {shell[:40]!r}; there are {', '.join(SHELLS)}")
    script = get_completion_script(prog_name="vibecalc", complete_var=VARIABLE, shell=shell)
    if shell == "bash":  # a value comes right behind `key=`
        space = "    [[ ${COMPREPLY[0]} == *= ]] && compopt -o nospace\n    return 0"
        script = script.replace("    return 0", space)
    say(script)


def answer_shells() -> None:
    """Let typer answer the shell's question, with the classes that its scripts belong to."""
    from typer.completion import completion_init  # type: ignore[attr-defined]

    completion_init()
    if "COMP_WORDS" in os.environ and _join_words():
        from typer._completion_classes import BashComplete

        def behind_the_sign(_: Any, item: Any) -> str:
            return str(item.value).partition("=")[2]

        setattr(BashComplete, "format_completion", behind_the_sign)  # noqa: B010


def _join_words() -> bool:
    """Put `machine.speed`, `=` and what follows, three words of bash, together into one again.

    Whether bash asks for the last of such three.
    """
    text = os.environ["COMP_WORDS"]
    words = text.split("\n") if "\n" in text else text.split()
    current = os.environ.get("COMP_CWORD", "")
    if not current.isdecimal():
        return False
    joined: list[str] = []
    glued, parted = False, False
    for number, word in enumerate(words):
        sign = word == "=" and bool(joined) and not joined[-1].startswith("-")
        if sign or glued:
            joined[-1] += word
        else:
            joined.append(word)
        if number == int(current):
            parted = sign or glued
            break
        glued = sign
    if parted or len(joined) < min(len(words), int(current) + 1):
        quoted = "\n".join(map(shlex.quote, joined))
        os.environ.update(COMP_WORDS=quoted, COMP_CWORD=str(len(joined) - 1))
    return parted


def keys(ctx: typer.Context, incomplete: str) -> list[str]:
    """`machine.speed=` and so on: keys of the first case on the line, as `--set` takes them.

    Behind the sign: the choices of the key, true and false, or the value of the case.
    """
    key, sign, _ = incomplete.partition("=")
    if sign:
        whole = [f"{key}={one}" for one in _values(ctx, key)]
        return [one for one in whole if one.startswith(incomplete)]
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


def _values(ctx: typer.Context, key: str) -> list[str]:
    from vibecalc.core.case.raw import get_key, parse_key
    from vibecalc.core.case.walk import keys_of, shape_at
    from vibecalc.errors import UsageError

    with suppress(UsageError):
        path = parse_key(key)
        shape = shape_at(path)
        if shape is not None and shape.kind == "choice":
            return [str(one) for one in shape.choices]
        if shape is not None and shape.kind == "flag":
            return ["true", "false"]
        with suppress(UsageError):
            written = get_key(_case(ctx), path)
            return [str(written)] if isinstance(written, str | int | float) else []
        parent = shape_at(path[:-1])
        if parent is not None and parent.table is not None:
            default = keys_of(parent.table)[str(path[-1])].default
            return [f"{default:g}"] if isinstance(default, int | float) else []
    return []


def _case(ctx: typer.Context) -> dict[str, Any]:
    import tomllib

    from vibecalc.core.results.text_files import LARGEST, content_of, text_of

    with suppress(Exception):  # whatever is wrong with the file, the command says it
        path = _first(ctx, "case", "cases", "file")
        return tomllib.loads(text_of(content_of(path, LARGEST)))
    return {}


def _keys(ctx: typer.Context) -> list[str]:
    return list(_leaves(_case(ctx))) if _case(ctx) else []


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
