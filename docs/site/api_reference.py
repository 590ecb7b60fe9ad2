"""The reference of Python: a directive of autodoc for each name that `import vibecalc` offers."""

import inspect
import re

import vibecalc


def page() -> str:
    """Markdown with a block for functions, results and exceptions each."""
    parts: dict[str, list[str]] = {"Functions": [], "Results": [], "Exceptions": []}
    for name in vibecalc.__all__:
        found = getattr(vibecalc, name)
        if inspect.isfunction(found):
            parts["Functions"].append(f".. autofunction:: vibecalc.{name}")
        elif issubclass(found, Exception):
            parts["Exceptions"].append(f".. autoexception:: vibecalc.{name}\n   :members:")
        else:
            parts["Results"].append(f".. autoclass:: vibecalc.{name}\n   :members:")
    blocks = (
        f"## {title}\n\n```{{eval-rst}}\n" + "\n".join(lines) + "\n```"
        for title, lines in parts.items()
    )
    return _HEAD + "\n\n".join(blocks) + "\n"


_HEAD = """# Python

What `import vibecalc` offers: functions that do what the commands do, results as objects,
problems as exceptions, each with the `exit_code` that the [command line](exit_codes.md) returns
for it. [From Python](../python.md) shows them at work.

"""

_PARAMETER = re.compile(r"(\w[\w, ]*) : (.*)")


def as_numpydoc(lines: list[str]) -> list[str]:
    """A docstring whose parameters are `name : what it is` as napoleon reads it.

    What follows a blank line below them and is no parameter is text again.
    """
    made: list[str] = []
    inside, blank = False, False
    for line in lines:
        named = _PARAMETER.fullmatch(line)
        if line == "Parameters":
            inside = True
        elif inside and named:
            made += [named[1], f"    {named[2]}"]
            continue
        elif inside and blank and line and not line.startswith(" "):
            inside = False
            if line not in ("Raises", "Returns"):
                made += ["Notes", "-----"]
        blank = not line
        made.append(line)
    return made
