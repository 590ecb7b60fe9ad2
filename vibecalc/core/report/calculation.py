"""The page of a result in the form of a calculation: numbered chapters, contents, an appendix.

A subject says in one place, a `Calculation`, which chapters there are, in which order, and what
stands in each. What a result does not have is no chapter, and the numbers close up.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from vibecalc.core.report import pages
from vibecalc.core.report.defects import survived
from vibecalc.core.report.html import (
    html_blocks,
    html_document,
    html_figure,
    html_heading,
    html_text,
    html_written,
    link,
)
from vibecalc.core.report.plots import make, pictures_of, vector_picture
from vibecalc.core.report.sections import Section, other, section
from vibecalc.core.report.text import identity, sections_of
from vibecalc.core.report.verdicts import judge_references
from vibecalc.core.report.writing import pairs, paragraph
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Result
from vibecalc.core.run.stage import Subject, subjects_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Chapter(NamedTuple):
    """A heading, and what stands below it; `details` only where the full report is asked for.

    A part is a function of the result, `package.module:function`, that makes a `Section`, blocks of
    lines or a picture, or the name of a picture of the subject; a section keeps its own title where
    there are several.
    """

    title: str
    parts: tuple[str, ...]
    details: tuple[str, ...] = ()


class Calculation(NamedTuple):
    """The chapters of a calculation in their order, the last one being the conclusion.

    `applies` and `summary`, the blocks of the first page, are functions of the result as
    `package.module:function`. `elsewhere` names sections of the text report of which the chapters
    have the contents by other parts; any other section that no chapter names becomes one of its own
    before the conclusion.
    """

    title: str
    applies: str
    summary: str
    chapters: tuple[Chapter, ...]
    elsewhere: tuple[str, ...] = ()


#: title of a part, "" without one, and its HTML
Below = tuple[str, list[str]]
#: what the frame calls its closing sections, as parts of an appendix
_CLOSING = {"Appendix": "Accuracy and methods"}


def calculation_page(result: Result, *, full: bool = False) -> str | None:
    """The page, None for a result of no subject that has the form of a calculation.

    Raises UsageError if matplotlib is not installed.
    """
    for subject in subjects_of(result.record):
        if subject.calculation:
            calculation: Calculation = named(subject.calculation)
            if named(calculation.applies)(result):
                return _page(result, subject, calculation, full)
    return None


def _page(result: Result, subject: Subject, calculation: Calculation, full: bool) -> str:
    made = _Maker(result, full)
    parts = [(chapter.title, made.chapter(chapter)) for chapter in calculation.chapters]
    *chapters, conclusion = (one for one in parts if one[1])
    title = str(result.case.get("title") or result.name)
    date = str(result.provenance.get("time") or "").split("T")[0]
    rows = [*identity(result), ("date", date), ("vibecalc", result.version)]
    body, contents = list[str](), list[str]()
    rest = made.rest(subject, calculation)
    for number, (words, below) in enumerate([*chapters, *rest, conclusion], 1):
        contents.append(f"{number} {words}")
        body += [html_heading(contents[-1]), *_numbered(below, number)]
    written = [("Case as written", [html_written(result.case_toml)])] if result.case_toml else []
    contents.append("Appendix")
    body += [html_heading("Appendix"), '<div class="appendix">',
             *_numbered([*made.appendix(), *written], "A"), "</div>"]  # fmt: skip
    listed = "".join(f"<li>{link(one)}</li>\n" for one in contents)
    first = [
        html_heading(title, 1), f'<p class="kind">{html_text(calculation.title)}</p>',
        *html_blocks(pairs(row for row in rows if row[1])),
        *html_blocks(named(calculation.summary)(result)),
        *html_blocks(_warnings(result)),
        f'<nav class="contents"><strong>Contents</strong><ol>\n{listed}</ol></nav>',
    ]  # fmt: skip
    return html_document(title, [*first, *body], _running(title))


def _running(title: str) -> str:
    """Header and foot of the printed pages but the first."""
    words = " ".join(title.split()).replace("\\", "\\\\").replace('"', '\\"').replace("<", "\\3c ")
    font = "font: 8pt sans-serif; color: #5b6168;"
    return (
        f'@page {{ margin: 18mm 15mm 16mm; @top-left {{ content: "{words}"; {font} }} '
        f'@bottom-right {{ content: counter(page) " / " counter(pages); {font} }} }}\n'
        '@page :first { @top-left { content: ""; } }\n'
    )


def _warnings(result: Result) -> list[str]:
    """Of the run, and of reference numbers that are missed."""
    found = pages.warnings(result)
    references = judge_references(result)
    missed = pages.conclusion(references, []) if pages.missed(references) else ""
    return [*([] if found is None else found.lines), *(paragraph(missed) if missed else [])]


def _numbered(below: Sequence[Below], number: int | str) -> Iterator[str]:
    """Parts under their titles, which have numbers where there are several."""
    count, several = 0, sum(bool(title) for title, _ in below) > 1
    for title, parts in below:
        if title and several:
            count += 1
            yield html_heading(f"{number}.{count} {title}", 3)
        yield from parts


class _Maker:
    """Makes the parts of a page, and keeps what they have shown and how many figures there are."""

    def __init__(self, result: Result, full: bool) -> None:
        self.result, self.full = result, full
        self.figures = 0
        self.shown: set[str] = set()
        self.left: list[Section] = []
        self.blocks: set[str] = set()

    def chapter(self, chapter: Chapter) -> list[Below]:
        """What stands below the heading of a chapter; nothing if the result has none of it."""
        below = self.parts(chapter.parts)
        return below + self.parts(chapter.details if self.full and below else ())

    def parts(self, names: Iterable[str]) -> list[Below]:
        """Sections, blocks and pictures, those that the result has and that do not fail."""
        made = (survived(where, partial(self.part, where)) for where in names)
        return [one for one in made if one is not None]

    def part(self, where: str) -> Below | None:
        """One of them; the details of a section are for the appendix."""
        if ":" not in where:
            return self.picture(partial(make, self.result, where))
        found: Any = named(where)(self.result)
        title, lines = "", found
        if isinstance(found, Section):
            title, lines = found[:2]
            self.shown |= found.shown
            self.left += [found] if found.detail else []
        if lines is not None and not isinstance(lines, list):
            return self.picture(lambda: found)
        self.blocks |= {line for line in lines or () if line}
        return (title, list(html_blocks(lines))) if lines else None

    def picture(self, maker: "Callable[[], Figure | None]") -> Below | None:
        """A picture with its number."""
        found = vector_picture(maker)
        if found is None:
            return None
        title, image = found
        case = " ".join(str(self.result.case.get("title") or self.result.name).split())
        self.figures += 1
        words = title.removeprefix(case).strip() or title
        return "", [html_figure(f"Figure {self.figures}: {words}", image)]

    def rest(self, subject: Subject, calculation: Calculation) -> Iterator[tuple[str, list[Below]]]:
        """Sections and pictures that no chapter names, those of other subjects among them.

        Pictures of the subject itself that no chapter names are for the full report.
        """
        known = {part for one in calculation.chapters for part in (*one.parts, *one.details)}
        for where in sections_of(self.result.record):
            for title, below in self.parts({where} - known):
                if where not in calculation.elsewhere:
                    yield title, [("", below)]
        names = pictures_of(self.result).keys() - known
        names -= set() if self.full else subject.pictures.keys()
        pictures = self.parts(name for name in pictures_of(self.result) if name in names)
        if pictures:
            yield "Further pictures", pictures

    def appendix(self) -> Iterator[Below]:
        """What is left: further results, details, reference numbers, accuracy and methods."""
        references, full = judge_references(self.result), self.full
        compared = pages.references(references) if full else pages.brief(references)
        off = [] if full else pages.references(pages.missed(references))
        words = pages.conclusion(references, [])
        numbers = [*paragraph(words), *compared, *off] if words else []
        parts = [section("Reference numbers", [numbers])]
        for one in self.left if full else ():
            lines = [line for line in one.detail if line not in self.blocks]
            parts.append(section(f"{one.title}: {one.detail_name}", [lines]))
        parts += [other(self.result, self.shown), *pages.closings(self.result, full)]
        for part in parts:
            if part is not None and any(part.lines):
                yield _CLOSING.get(part.title, part.title), list(html_blocks(part.lines))
