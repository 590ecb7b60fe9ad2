"""Problems in colours on a terminal; NO_COLOR and FORCE_COLOR decide where they are set."""

import os
import sys

from vibecalc.core.results.visible import visible

#: what stands out, and how rich calls it
_STYLES = {
    r"^error\b:?": "bold red",
    r"^ *--> .*": "cyan",
    r"^ *\d* \|": "blue",
    r"(?<=\| ) *\^.*": "red",
    r"^ *help:": "bold green",
    r"^\d+ errors? in .*": "bold",
}


def coloured(text: str) -> str:
    """The words as they may be printed, with colours where stderr is a terminal that shows them.

    Any text in NO_COLOR forbids them, else any in FORCE_COLOR wants them everywhere. rich is
    imported where there are some.
    """
    text = visible(text)
    terminal = sys.stderr.isatty() and os.environ.get("TERM") != "dumb"
    if os.environ.get("NO_COLOR") or not (os.environ.get("FORCE_COLOR") or terminal):
        return text
    import re

    from rich.color import ColorSystem
    from rich.console import Console
    from rich.text import Text

    words = Text(text)
    for pattern, style in _STYLES.items():
        words.highlight_regex(re.compile(pattern, re.MULTILINE), style)
    # piece by piece, as a console would wrap lines and spread tabs
    return "".join(
        piece.style.render(piece.text, color_system=ColorSystem.STANDARD)
        if piece.style
        else piece.text
        for piece in words.render(Console())
    )
