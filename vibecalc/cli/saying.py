"""What every command says, and how: `--quiet`, `--verbose` and `--json` are the same for all."""

import inspect
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from pathlib import Path
from typing import Any

import typer

from vibecalc.core.results.steps import listen, step
from vibecalc.core.results.visible import put, visible

_COMMON = {
    "json": typer.Option(False, "--json", help="Print JSON only, on stdout."),
    "quiet": typer.Option(
        False, "--quiet", "-q", help="Print problems only, and JSON if requested."
    ),
    "verbose": typer.Option(
        False, "--verbose", "-v", help="Log each step with its time on stderr."
    ),
}


class _Asked:
    """What the command that runs was asked to say."""

    json = quiet = verbose = False

    @property
    def silent(self) -> bool:
        """Whether no words go to stdout."""
        return self.json or self.quiet


asked = _Asked()


def spoken(function: Callable[..., None], *, json: bool = True) -> Callable[..., None]:
    """A command with the common options; `json` is False where its words are its result."""
    common = {name: option for name, option in _COMMON.items() if json or name != "json"}

    @wraps(function)
    def command(**given: Any) -> None:
        for name in _COMMON:
            setattr(asked, name, given.pop(name, False))
        began = time.perf_counter()
        if asked.verbose:
            listen(lambda words: note(f"{time.perf_counter() - began:9.3f} s  {words}"))
        try:
            step(f"vibecalc {function.__name__}")
            function(**given)
        finally:
            step("end")
            listen(None)

    keyword = inspect.Parameter.KEYWORD_ONLY
    extra = [
        inspect.Parameter(name, keyword, default=option, annotation=bool)
        for name, option in common.items()
    ]
    own = inspect.signature(function)
    made: Any = command
    made.__signature__ = own.replace(parameters=[*own.parameters.values(), *extra])
    made.__annotations__ = {**function.__annotations__, **dict.fromkeys(common, bool)}
    return command


def say(text: str) -> None:
    """Words on stdout with a line end behind them, unless nobody wants them."""
    if not asked.silent:
        put(visible(text) + "\n" * (not text.endswith("\n")) * bool(text))


def answer(data: Callable[[], Any], words: Callable[[], str]) -> None:
    """The object of `--json`, or words for people: what is asked for is made."""
    if asked.json:
        say_json(data())
    elif not asked.quiet:
        say(words())


def say_json(data: Any) -> None:
    """The object of `--json` on stdout."""
    import json

    put(json.dumps(data, indent=2, allow_nan=False) + "\n")


def say_written(*paths: Path, **more: Any) -> None:
    """Which files were written: a line for each, or `written` of an object with `more`."""
    if asked.json:
        say_json({**more, "written": [str(path) for path in paths]})
    for path in paths:
        say(f"wrote {path}")


def note(text: str) -> None:
    """Words on stderr, in colours where it is a terminal; a full one changes no exit code."""
    from vibecalc.cli.colours import coloured

    with suppress(OSError):
        print(coloured(text), file=sys.stderr, flush=True)
