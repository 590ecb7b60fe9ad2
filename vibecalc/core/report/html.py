"""Blocks of a report as HTML: headings, tables with their verdicts in colour, pictures, style."""

import base64
import re
from collections.abc import Iterable, Iterator
from html import escape
from itertools import groupby

from vibecalc.core.report.writing import Heading, Pairs, Paragraph, Table, read

#: what verdicts are coloured as: those in capitals are not what the case expects
VERDICTS = (
    ("missed", re.compile(r"\b[A-Z]{4,}\b")),
    ("open", re.compile(r"\b(undecided|known)\b")),
    ("kept", re.compile(r"\b(kept|broken|within)\b")),
)
_JUDGED = ("limit", "verdict")

STYLE = """
:root { color-scheme: light; --rule: #c8ccd0; --quiet: #5b6168; }
body { font: 15px/1.45 system-ui, "Segoe UI", "Helvetica Neue", Arial, sans-serif; color: #16191c;
  max-width: 60rem; margin: 2rem auto; padding: 0 1.25rem; background: #fff; }
h1 { font-size: 1.6rem; margin: 0 0 .5rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; border-bottom: 1px solid var(--rule); }
nav { font-size: .85rem; margin: 1rem 0; } nav a { margin-right: .9rem; white-space: nowrap; }
a { color: #0058a0; text-decoration: none; } a:hover { text-decoration: underline; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1.2rem; margin: .5rem 0; }
dt { color: var(--quiet); } dd { margin: 0; overflow-wrap: anywhere; }
.wide { overflow-x: auto; margin: .6rem 0; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .18rem .7rem .18rem 0; text-align: left; vertical-align: top; }
th { border-bottom: 1px solid #16191c; font-weight: 600; vertical-align: bottom; }
tbody + tbody tr:first-child td { border-top: 1px solid var(--rule); }
.n { text-align: right; } .u { white-space: nowrap; }
th:last-child, td:last-child { padding-right: 0; }
.kept { color: #146c2e; font-weight: 600; } .missed { color: #b00020; font-weight: 700; }
.open { color: #8a5a00; font-weight: 600; }
p { margin: .5rem 0; max-width: 48rem; }
pre { font: 12.5px/1.4 ui-monospace, Consolas, "DejaVu Sans Mono", monospace; overflow-x: auto;
  background: #f5f6f7; padding: .7rem .9rem; margin: .6rem 0; }
pre.case { white-space: pre-wrap; overflow-wrap: anywhere; }
figure { margin: 1.2rem 0; } figure img { max-width: 100%; height: auto; }
figcaption { font-size: .85rem; color: var(--quiet); }
@page { size: A4; margin: 16mm 15mm; }
@media print {
  body { font-size: 9.5pt; margin: 0; padding: 0; max-width: none; } nav { display: none; }
  h2 { break-after: avoid; } figure, tr { break-inside: avoid; }
  thead { display: table-header-group; }
  .wide { overflow: visible; } table { font-size: 8pt; }
  pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: 7.5pt; }
}
"""


def html_blocks(lines: Iterable[str]) -> Iterator[str]:
    """Blocks as HTML; what is text alone stays as it is set."""
    for plain, group in groupby(lines, key=lambda line: type(line) is str):
        if plain:
            text = read("\n".join(group)).strip("\n")
            if text.strip():
                yield f"<pre>{escape(text)}</pre>"
            continue
        for block in group:
            if isinstance(block, Heading):
                yield html_heading(block.words, block.level)
            elif isinstance(block, Table):
                yield html_table(block)
            elif isinstance(block, Pairs):
                rows = (
                    f"<dt>{html_text(name)}</dt><dd>{html_text(value)}</dd>"
                    for name, value in block.rows
                )
                yield f"<dl>{''.join(rows)}</dl>"
            elif isinstance(block, Paragraph) and block.words.strip():
                mark = f"{html_text(block.mark)} " if block.mark else ""
                yield f"<p>{mark}{html_text(block.words)}</p>"


def html_table(block: Table) -> str:
    """A table with its verdicts in colour."""

    def row(cells: Iterable[str], tag: str = "td") -> str:
        made = []
        for cell, column in zip(cells, block.columns, strict=True):
            shown, side = html_text(cell.strip()), "n" if column.right else ""
            side = side or "u" * (column.title == "unit")
            colour = next((name for name, words in VERDICTS if words.search(cell)), "")
            if tag == "td" and column.title in _JUDGED and colour:
                shown = f'<span class="{colour}">{shown}</span>'
            kind = f' class="{side}"' if side else ""
            made.append(f"<{tag}{kind}>{shown}</{tag}>")
        return f"<tr>{''.join(made)}</tr>"

    head = f"<thead>{row((column.title for column in block.columns), 'th')}</thead>"
    parts = [part for part in (block.rows, block.totals) if part]
    bodies = "".join(f"<tbody>{''.join(map(row, part))}</tbody>" for part in parts)
    return f'<div class="wide"><table>{head}{bodies}</table></div>'


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


def html_document(title: str, style: str, body: Iterable[str]) -> str:
    """The whole page."""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html_text(title)}</title>\n<style>{style}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )
