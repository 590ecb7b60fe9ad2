"""Entry point: run the command line, turn errors into words on stderr and an exit code."""

import atexit
import gc
import io
import os
import sys
from typing import NoReturn

from vibecalc.errors import EXIT_BUG, EXIT_INTERRUPTED, VibecalcError

REPORT_BUGS = "This is a bug in vibecalc. Please report it with the lines above and the case file."


def main() -> NoReturn:
    """Run `vibecalc` with the arguments of the process."""
    # Modules, schemas and results live to the end: looking through them for garbage, again and
    # again and once more at exit, finds nothing and takes a quarter of a short run.
    gc.set_threshold(100_000, 20, 20)
    atexit.register(gc.freeze)
    # One thread per process: small matrices gain nothing from more, and sums keep their order.
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    # Else pydantic looks through every installed package for plugins that we do not want.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # A title in letters that the terminal cannot show is no reason to stop.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        from vibecalc.cli import app

        app(prog_name="vibecalc")
    except VibecalcError as error:
        _say(str(error) if str(error).startswith("error") else f"error: {error}")
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        _say("interrupted: nothing half-written is left behind")
        sys.exit(EXIT_INTERRUPTED)
    except Exception:
        import traceback

        traceback.print_exc()
        _say(REPORT_BUGS)
        sys.exit(EXIT_BUG)
    sys.exit(0)


def _say(text: str) -> None:
    print(text, file=sys.stderr)


if __name__ == "__main__":
    main()
