"""Entry point: run the command line, turn errors into words on stderr and an exit code."""

import os
import sys

# `python -m` looks for modules in the current folder first: a file there is never taken for one
if __name__ == "__main__" and not sys.flags.safe_path:
    sys.path.pop(0)
    sys.path.append(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

import atexit
import contextlib
import copy
import gc
import io
from typing import Any, NoReturn

from vibecalc import interrupts
from vibecalc.errors import (
    EXIT_BUG,
    Interrupted,
    OutputError,
    UsageError,
    VibecalcError,
)

REPORT_BUGS = "This is a bug in vibecalc. Please report it with the lines above and the case file."


def main() -> NoReturn:
    """Run `vibecalc` with the arguments of the process."""
    # Modules, schemas and results live to the end: looking through them for garbage, again and
    # again and once more at exit, finds nothing and takes a quarter of a short run.
    gc.set_threshold(500_000, 20, 20)
    atexit.register(gc.freeze)
    # One thread per process: small matrices gain nothing from more, and sums keep their order.
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    # Else pydantic looks through every installed package for plugins that we do not want.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    _open_closed_streams()
    # A title in letters that the terminal cannot show is no reason to stop.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    with interrupts.listening():
        sys.exit(_run("--json" in sys.argv[1:]))


def _run(as_json: bool) -> int:
    """Run the command that is named; its exit code."""
    try:
        from vibecalc.cli.commands import app as every_command

        # the parameters of ten other commands need not be examined to run the one that is named
        app = copy.copy(every_command)
        named = [one for one in app.registered_commands if sys.argv[1:2] == [_name(one)]]
        if sys.argv[1:2] != ["help"]:
            app.registered_commands = named or app.registered_commands
        if "_VIBECALC_COMPLETE" in os.environ:
            from vibecalc.cli.completion import answer_shells

            answer_shells()
        if as_json:
            return _with_objects(app)
        app(prog_name="vibecalc")
    except (KeyboardInterrupt, Exception) as met:
        return _said(met, as_json)
    return 0


def _said(met: BaseException, as_json: bool) -> int:
    """Say what has ended the command; its exit code."""
    # libraries turn an interrupt into errors of their own
    interrupted = isinstance(met, KeyboardInterrupt) or interrupts.came()
    error = Interrupted() if interrupted and not isinstance(met, Interrupted) else met
    if not isinstance(error, VibecalcError):
        import traceback

        traceback.print_exception(error)
        _say(REPORT_BUGS)
        return EXIT_BUG
    if isinstance(error, Interrupted):
        interrupts.met()
    if isinstance(error, OutputError):  # what is left of the text would fail at exit again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    bare = isinstance(error, Interrupted) or str(error).startswith("error")
    _say(str(error) if bare else f"error: {error}")
    if as_json:
        _print_error(error)
    return error.exit_code


def _open_closed_streams() -> None:
    """Put the null device in place of stdin, stdout and stderr where the caller has closed them.

    Else the first files that are opened would take their numbers, and be written as these streams.
    """
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            null = os.open(os.devnull, os.O_RDWR)
            if null != number:
                os.dup2(null, number)
                os.close(null)
            os.set_inheritable(number, True)
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, mode, encoding="utf-8", closefd=False))


def _name(command: Any) -> str:
    return str(command.name or command.callback.__name__)


def _with_objects(app: Any) -> int:
    """Run with `--json`; a command line that cannot be read is an error with an object, too."""
    from typer import BadParameter

    # the class of all that is wrong with a command line, in click or in typer's own copy of it
    unreadable: type[Any] = BadParameter.__bases__[0]
    try:
        return int(app(prog_name="vibecalc", standalone_mode=False) or 0)
    except unreadable as error:
        error.show()
        found = UsageError(error.format_message())
        _print_error(found)
        return found.exit_code


def _print_error(error: VibecalcError) -> None:
    import json

    print(json.dumps({"error": error.as_object()}, indent=2))


def _say(text: str) -> None:
    from vibecalc.cli.colours import coloured

    with contextlib.suppress(OSError):  # a full or closed stderr changes no exit code
        print(coloured(text), file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
