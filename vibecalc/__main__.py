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
from vibecalc.errors import EXIT_BUG, Interrupted, OutputError, UsageError, VibecalcError

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
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")
    if type(sys.stderr) is io.TextIOWrapper:
        sys.stderr = _Stderr(sys.stderr)
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
    from vibecalc.cli.saying import note

    # libraries turn an interrupt into errors of their own
    interrupted = isinstance(met, KeyboardInterrupt) or interrupts.came()
    error = Interrupted() if interrupted and not isinstance(met, Interrupted) else met
    if not isinstance(error, VibecalcError):
        import traceback

        traceback.print_exception(error)
        note(REPORT_BUGS)
        return EXIT_BUG
    if isinstance(error, Interrupted):
        interrupts.met()
    if isinstance(error, OutputError):
        _close_stdout()
    bare = isinstance(error, Interrupted) or str(error).startswith("error")
    note(str(error) if bare else f"error: {error}")
    if as_json:
        _print_error(error)
    return error.exit_code


class _Stderr(io.TextIOWrapper):
    """stderr that may be full or without a reader: that changes no exit code."""

    def __init__(self, before: io.TextIOWrapper):
        super().__init__(before.buffer, before.encoding, "backslashreplace")
        self.before = before  # which closes the file once nobody holds it any more

    def write(self, text: str) -> int:
        """Write at once what can be written."""
        with contextlib.suppress(OSError):
            super().write(text)
            super().flush()
        return len(text)

    def flush(self) -> None:
        """Nothing is left to write."""


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
    from vibecalc.cli.saying import say_json

    try:
        say_json({"error": error.as_object()})
    except OutputError:  # the exit code is that of the error
        _close_stdout()


def _close_stdout() -> None:
    """Put the null device in its place: what is left of a text would fail at exit again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    main()
