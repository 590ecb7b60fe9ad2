"""The report of a file as one page of HTML: tables, pictures and the case, for print and post."""

from pathlib import Path

from vibecalc.core.report.calculation import calculation_page
from vibecalc.core.report.html import (
    STYLE,
    html_blocks,
    html_document,
    html_figure,
    html_heading,
    html_written,
    link,
)
from vibecalc.core.report.plots import vector_pictures
from vibecalc.core.report.sweep.text import file_lines
from vibecalc.core.report.writing import Heading
from vibecalc.core.results.layout import is_accuracy


def html_page(path: Path, *, full: bool = False) -> str:
    """One self-contained page: the report of a file, its pictures as SVG, the case as written.

    A result of a subject that has the form of a calculation is set as `calculation_page` does it.

    Raises ResultError if the file cannot be read, UsageError if matplotlib is not installed.
    """
    from vibecalc.core.results.store import read_result
    from vibecalc.core.results.sweep_file import is_sweep, open_sweep

    if is_sweep(path):
        with open_sweep(path) as opened:
            written = opened.head.result.case_toml
    else:
        result = read_result(path)
        calculation = None if is_accuracy(result) else calculation_page(result, full=full)
        if calculation is not None:
            return calculation
        written = result.case_toml
    lines = file_lines(path, full=full)
    body = list(html_blocks(lines))
    titles = [line.words for line in lines if isinstance(line, Heading)]
    pictures = [
        html_figure(title.removeprefix(" ".join(titles[0].split())).strip() or title, image)
        for title, image in vector_pictures(path)
    ]
    if pictures:
        body += [html_heading("Pictures"), *pictures]
    if written:
        body += [html_heading("Case as written"), html_written(written)]
    titles += ["Pictures"] * bool(pictures) + ["Case as written"] * bool(written)
    links = "\n".join(link(one) for one in titles[1:])
    return html_document(titles[0], STYLE, [body[0], f"<nav>\n{links}\n</nav>", *body[1:]])
