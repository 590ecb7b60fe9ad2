"""Markdown as the generated pages need it: cells, tables, code."""

from collections.abc import Iterable, Sequence


def cell(text: str) -> str:
    """Words in a cell of a table."""
    return " ".join(text.replace("|", r"\|").replace("<", r"\<").split())


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
