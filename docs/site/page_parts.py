"""Markdown as the generated pages need it: cells, tables, code."""

import re
from collections.abc import Iterable, Sequence


def cell(text: str) -> str:
    """Words in a cell of a table: signs are signs, what stands in backticks is code."""
    parts = " ".join(text.replace("|", r"\|").split()).split("`")
    parts[::2] = [re.sub(r"([*<])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)


def code(text: str) -> str:
    """Something to type, in a line or a cell of a table."""
    ticks = "``" if "`" in text else "`"
    return f"{ticks}{text.replace('|', chr(92) + '|')}{ticks}" if text else ""


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; its cells are Markdown."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def toctree(pages: Iterable[str], depth: int = 1, hidden: bool = False) -> str:
    """The pages below one."""
    options = [f":maxdepth: {depth}", *([":hidden:"] if hidden else [])]
    return "\n".join(["```{toctree}", *options, "", *pages, "```"])
