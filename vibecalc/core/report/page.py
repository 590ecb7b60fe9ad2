"""The report of a file as one page of HTML: tables, pictures and the case, for print and post."""

import base64
import re
from collections.abc import Iterable, Iterator
from html import escape
from itertools import groupby
from pathlib import Path

from vibecalc.core.report.plots import vector_pictures
from vibecalc.core.report.sweep.text import file_lines
from vibecalc.core.report.writing import Heading, Pairs, Paragraph, Table, read

#: what verdicts are coloured as: those in capitals are not what the case expects
_VERDICTS = (
    ("missed", re.compile(r"\b[A-Z]{4,}\b")),
    ("open", re.compile(r"\b(undecided|known)\b")),
    ("kept", re.compile(r"\b(kept|broken|within)\b")),
)
_JUDGED = ("limit", "verdict")

_STYLE = """
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
.n { text-align: right; } th:last-child, td:last-child { padding-right: 0; }
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


def html_page(path: Path, *, full: bool = False) -> str:
    """One self-contained page: the report of a file, its pictures as SVG, the case as written.

    Raises ResultError if the file cannot be read, UsageError if matplotlib is not installed.
    """
    lines = file_lines(path, full=full)
    body = list(_body(lines))
    titles = [line.words for line in lines if isinstance(line, Heading)]
    pictures = [
        _figure(title.removeprefix(" ".join(titles[0].split())).strip() or title, image)
        for title, image in vector_pictures(path)
    ]
    if pictures:
        body += [_heading("Pictures"), *pictures]
    written = _case(path)
    if written:
        body += [_heading("Case as written"), f'<pre class="case">{escape(written)}</pre>']
    titles += ["Pictures"] * bool(pictures) + ["Case as written"] * bool(written)
    links = "".join(f'<a href="#{_anchor(one)}">{_text(one)}</a>\n' for one in titles[1:])
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{_text(titles[0])}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + body[0]
        + f"\n<nav>\n{links}</nav>\n"
        + "\n".join(body[1:])
        + "\n</body>\n</html>\n"
    )


def _body(lines: Iterable[str]) -> Iterator[str]:
    """Blocks as HTML; what is text alone stays as it is set."""
    for plain, group in groupby(lines, key=lambda line: type(line) is str):
        if plain:
            text = read("\n".join(group)).strip("\n")
            if text.strip():
                yield f"<pre>{escape(text)}</pre>"
            continue
        for block in group:
            if isinstance(block, Heading):
                yield _heading(block.words, block.level)
            elif isinstance(block, Table):
                yield html_table(block)
            elif isinstance(block, Pairs):
                rows = (
                    f"<dt>{_text(name)}</dt><dd>{_text(value)}</dd>" for name, value in block.rows
                )
                yield f"<dl>{''.join(rows)}</dl>"
            elif isinstance(block, Paragraph) and block.words.strip():
                mark = f"{_text(block.mark)} " if block.mark else ""
                yield f"<p>{mark}{_text(block.words)}</p>"


def html_table(block: Table) -> str:
    """A table with its verdicts in colour."""
    sides = [' class="n"' if column.right else "" for column in block.columns]
    judged = [column.title in _JUDGED for column in block.columns]

    def row(cells: Iterable[str]) -> str:
        made = []
        for cell, side, verdict in zip(cells, sides, judged, strict=True):
            shown = _text(cell.strip())
            colour = next((name for name, words in _VERDICTS if words.search(cell)), "")
            if verdict and colour:
                shown = f'<span class="{colour}">{shown}</span>'
            made.append(f"<td{side}>{shown}</td>")
        return f"<tr>{''.join(made)}</tr>"

    heads = (
        f"<th{side}>{_text(column.title)}</th>"
        for column, side in zip(block.columns, sides, strict=True)
    )
    parts = [part for part in (block.rows, block.totals) if part]
    bodies = "".join(f"<tbody>{''.join(map(row, part))}</tbody>" for part in parts)
    head = f"<thead><tr>{''.join(heads)}</tr></thead>"
    return f'<div class="wide"><table>{head}{bodies}</table></div>'


def _figure(caption: str, image: bytes) -> str:
    # an image of its own keeps the names inside each SVG apart
    source = base64.b64encode(image).decode("ascii")
    words = _text(caption)
    return (
        f'<figure><img alt="{words}" src="data:image/svg+xml;base64,{source}">'
        f"<figcaption>{words}</figcaption></figure>"
    )


def _case(path: Path) -> str:
    """The text of the case file that the file was made from; empty where it is not kept."""
    from vibecalc.core.results.sweep_file import is_sweep, open_sweep

    if is_sweep(path):
        with open_sweep(path) as opened:
            return opened.head.result.case_toml
    from vibecalc.core.results.store import read_result

    return read_result(path).case_toml


def _heading(title: str, level: int = 2) -> str:
    return f'<h{level} id="{_anchor(title)}">{_text(title)}</h{level}>'


def _anchor(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def _text(words: str) -> str:
    return escape(read(" ".join(words.split())))
