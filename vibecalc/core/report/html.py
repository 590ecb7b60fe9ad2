"""Blocks of a report as HTML: headings, tables with their verdicts in colour, pictures."""

import base64
import re
from collections.abc import Iterable, Iterator
from html import escape
from itertools import groupby
from pathlib import Path

from vibecalc.core.report.writing import Block, Heading, Pairs, Paragraph, Table, read

#: what verdicts are coloured as: those in capitals are not what the case expects
VERDICTS = (
    ("missed", re.compile(r"\b[A-Z]{4,}\b")),
    ("open", re.compile(r"\b(undecided|known)\b")),
    ("kept", re.compile(r"\b(kept|broken|within)\b")),
)
_JUDGED = ("limit", "verdict")
#: rows of a table from which on it may break over pages
_LONG = 45


def html_blocks(lines: Iterable[str]) -> Iterator[str]:
    """Blocks as HTML; what is text alone stays as it is set."""
    for plain, group in groupby(lines, key=lambda line: not isinstance(line, Block)):
        text = read("\n".join(group)).strip("\n") if plain else ""
        if text.strip():
            yield f"<pre>{escape(text)}</pre>"
        for block in () if plain else group:
            if isinstance(block, Heading):
                yield html_heading(block.words, block.level)
            elif isinstance(block, Table):
                yield html_table(block)
            elif isinstance(block, Pairs):
                rows = (f"<dt>{html_text(name)}</dt><dd>{html_text(value)}</dd>"
                        for name, value in block.rows)  # fmt: skip
                yield f"<dl>{''.join(rows)}</dl>"
            elif isinstance(block, Paragraph) and block.words.strip():
                yield f"<p>{html_text(f'{block.mark} {block.words}')}</p>"


def html_table(block: Table) -> str:
    """A table with its verdicts in colour."""

    def row(cells: Iterable[str], tag: str = "td") -> str:
        made = []
        for cell, column in zip(cells, block.columns, strict=True):
            shown, side = html_text(cell), "n" if column.right else "u" * (column.title == "unit")
            colour = next((name for name, words in VERDICTS if words.search(cell)), "")
            if tag == "td" and column.title in _JUDGED and colour:
                shown = f'<span class="{colour}">{shown}</span>'
            kind = f' class="{side}"' if side else ""
            made.append(f"<{tag}{kind}>{shown}</{tag}>")
        return f"<tr>{''.join(made)}</tr>"

    head = f"<thead>{row((column.title for column in block.columns), 'th')}</thead>"
    parts = [part for part in (block.rows, block.totals) if part]
    bodies = "".join(f"<tbody>{''.join(map(row, part))}</tbody>" for part in parts)
    long = " long" * (len(block.rows) + len(block.totals) > _LONG)
    return f'<div class="wide{long}"><table>{head}{bodies}</table></div>'


def html_figure(caption: str, image: bytes) -> str:
    """A picture in SVG with its caption."""
    # an image of its own keeps the names inside each SVG apart
    source = base64.b64encode(image).decode("ascii")
    words = html_text(caption)
    return (
        f'<figure><img alt="{words}" src="data:image/svg+xml;base64,{source}">'
        f"<figcaption>{words}</figcaption></figure>"
    )


def html_heading(title: str, level: int = 2) -> str:
    """A heading that links find."""
    return f'<h{level} id="{anchor(title)}">{html_text(title)}</h{level}>'


def anchor(title: str) -> str:
    """The name of a heading in links."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def html_text(words: str) -> str:
    """Words as HTML, products of units as they are read."""
    return escape(read(" ".join(words.split())))


def html_written(case: str) -> str:
    """The text of a case file."""
    return f'<pre class="case">{escape(case)}</pre>'


def link(title: str) -> str:
    """A link to a heading of the page."""
    return f'<a href="#{anchor(title)}">{html_text(title)}</a>'


def html_document(title: str, body: Iterable[str], style: str = "") -> str:
    """The whole page, with a `style` of its own beside that of all pages."""
    style = Path(__file__).with_name("page.css").read_text(encoding="utf-8") + style
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html_text(title)}</title>\n<style>{style}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )
