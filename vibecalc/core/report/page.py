"""The report of a file as one page of HTML: tables, pictures and the case, for print and post."""

from pathlib import Path

from vibecalc.core.report.calculation import calculation_page
from vibecalc.core.report.html import (
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
from vibecalc.core.results.record import Result
from vibecalc.core.results.sweep_file import SweepResult, opened


def html_page(of: Path | Result, *, full: bool = False) -> str:
    """One page that needs no other file: report, pictures as SVG and the case as written.

    A result is set as a calculation to hand in, by `calculation_page`.

    Raises ResultError if the file cannot be read, UsageError if matplotlib is not installed.
    """
    with opened(of) as found:
        if isinstance(found, SweepResult):
            written = found.head.result.case_toml
        else:
            if not is_accuracy(found):
                return calculation_page(found, full=full)
            written = found.case_toml
    lines = file_lines(of, full=full)
    body = list(html_blocks(lines))
    titles = [line.words for line in lines if isinstance(line, Heading)]
    pictures = [
        html_figure(title.removeprefix(" ".join(titles[0].split())).strip() or title, image)
        for title, image in vector_pictures(of)
    ]
    if pictures:
        body += [html_heading("Pictures"), *pictures]
    if written:
        body += [html_heading("Case as written"), html_written(written)]
    titles += ["Pictures"] * bool(pictures) + ["Case as written"] * bool(written)
    links = "\n".join(link(one) for one in titles[1:])
    return html_document(titles[0], [body[0], f"<nav>\n{links}\n</nav>", *body[1:]])
