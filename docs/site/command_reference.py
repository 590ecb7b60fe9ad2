"""The reference of the command line, from the commands themselves."""

from collections.abc import Iterator
from typing import Any

import typer
from page_parts import cell, code, table

from vibecalc.cli.commands import app
from vibecalc.cli.examples import EXAMPLES
from vibecalc.errors import EXIT_CODES, VibecalcError


def commands() -> dict[str, Any]:
    """Every command that the help lists, by name."""
    program: Any = typer.main.get_command(app)
    return {name: one for name, one in program.commands.items() if not one.hidden}


def pages() -> dict[str, str]:
    """Markdown of the pages by name."""
    sections = "\n\n".join(_section(name, one) for name, one in commands().items())
    return {"command_line": f"{_HEAD}\n\n{sections}\n", "exit_codes": _exit_codes()}


_HEAD = """# Command line

Every command of `vibecalc` with its arguments and options, as `vibecalc help COMMAND` prints them.
Commands end with an [exit code](exit_codes.md); with `--json` what they find is one JSON text on
standard output."""


def _section(name: str, command: Any) -> str:
    context = typer.Context(command, info_name=f"vibecalc {name}")
    parts = [f"## `vibecalc {name}`", cell(" ".join((command.help or "").split())),
             f"```text\n{command.get_usage(context).removeprefix('Usage: ')}\n```"]  # fmt: skip
    for kind in ("argument", "option"):
        records = [
            parameter.get_help_record(context)
            for parameter in command.get_params(context)
            if parameter.param_type_name == kind
        ]
        rows = [[code(names), cell(words)] for names, words in filter(None, records)]
        parts += [table((kind, "what it does"), rows)] if rows else []
    examples = EXAMPLES.get(name, ())
    if examples:
        lines = "\n".join(f"{line}\n    # {about}" for line, about in examples)
        parts.append(f"```text\n{lines}\n```")
    return "\n\n".join(part for part in parts if part)


def _exit_codes() -> str:
    rows = [
        [code(str(number)), words, ", ".join(code(one) for one in _errors(number))]
        for number, words in EXIT_CODES.items()
    ]
    return f"""# Exit codes

What a command returns to the shell (`$?`), to make and to CI, and which exception of Python stands
for it. Anything but 0 leaves no half-written file; of several cases the worst code counts.

{table(("code", "meaning", "in Python"), rows)}
"""


def _errors(number: int) -> Iterator[str]:
    waiting = [VibecalcError]
    for one in waiting:
        waiting += one.__subclasses__()
        if one.exit_code == number:
            yield one.__name__
