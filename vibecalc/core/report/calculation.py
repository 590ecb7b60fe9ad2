"""The page of a result in the form of a calculation: numbered chapters, contents, an appendix.

A subject says in one place, a `Calculation`, which chapters there are, in which order, and what
stands in each. What a result does not have is no chapter, and the numbers close up.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from vibecalc.core.report import pages
from vibecalc.core.report.defects import survived
from vibecalc.core.report.headline import first_table
from vibecalc.core.report.html import (
    html_blocks,
    html_document,
    html_figure,
    html_heading,
    html_text,
    html_written,
    link,
)
from vibecalc.core.report.sections import Section, other, read_as, section, stacked, table_of
from vibecalc.core.report.text import OF_STUDIES, identity
from vibecalc.core.report.verdicts import as_read, bounds_of, in_percent, judge_references, place_of
from vibecalc.core.report.writing import (
    Column,
    as_text,
    number,
    pairs,
    paragraph,
    show,
    table,
    turns,
)
from vibecalc.core.results.catalogue import CATALOGUE, OWNER
from vibecalc.core.results.named import named
from vibecalc.core.results.record import BARRED, Result, Verdict
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.run.stage import Subject, subjects, subjects_of
from vibecalc.units import convert

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


_HERE = "vibecalc.core.report.calculation"
#: the chapters around the sections of a result whose subjects have no form of their own
GENERAL = Calculation(
    title="Vibration calculation",
    applies="",
    summary=f"{_HERE}:summary",
    chapters=(
        Chapter("Input", ("vibecalc.core.report.inputs:inputs",)),
        Chapter("Assumptions", (f"{_HERE}:assumptions",)),
        Chapter("Conclusion", (f"{_HERE}:judged",)),
    ),
)

#: title of a part, "" without one, and its HTML
Below = tuple[str, list[str]]
#: what the frame calls its closing sections, as parts of an appendix
_CLOSING = {"Tolerance": "Accuracy"}


def calculation_page(result: Result, *, full: bool = False) -> str:
    """The page: title block, summary, contents, chapters, appendix.

    Raises UsageError if matplotlib is not installed.
    """
    for subject in subjects_of(result.record):
        if subject.calculation:
            calculation: Calculation = named(subject.calculation)
            if named(calculation.applies)(result):
                return _page(result, subject, calculation, full)
    return _page(result, None, GENERAL, full)


def _page(result: Result, subject: Subject | None, calculation: Calculation, full: bool) -> str:
    made = _Maker(result, full)
    parts = [(chapter.title, made.chapter(chapter)) for chapter in calculation.chapters]
    *chapters, conclusion = (one for one in parts if one[1])
    title = str(result.case.get("title") or result.name)
    body, contents = list[str](), list[str]()
    rest = made.rest(subject, calculation)
    for place, (words, below) in enumerate([*chapters, *rest, conclusion], 1):
        contents.append(f"{place} {words}")
        body += [html_heading(contents[-1]), *_numbered(below, place)]
    written = [("Case as written", [html_written(result.case_toml)])] if full else []
    contents.append("Appendix")
    body += [html_heading("Appendix"), '<div class="appendix">',
             *_numbered([*made.appendix(calculation), *written], "A"), "</div>"]  # fmt: skip
    listed = "".join(f"<li>{link(one)}</li>\n" for one in contents)
    first = [
        html_heading(title, 1), f'<p class="kind">{html_text(calculation.title)}</p>',
        *html_blocks(title_block(result)),
        *html_blocks(named(calculation.summary)(result)),
        *html_blocks(_remarks(result)),
        *html_blocks(_warnings(result)),
        f'<nav class="contents"><strong>Contents</strong><ol>\n{listed}</ol></nav>',
    ]  # fmt: skip
    return html_document(title, [*first, *body], _running(title))


# ----------------------------------------------------------------------------
# The first page, and what every calculation has.
# ----------------------------------------------------------------------------


def title_block(result: Result) -> list[str]:
    """Whose document it is, as `[document]` says, what was computed and with which program."""
    document, day = table_of(result.case, "document"), str(result.provenance.get("time") or "")
    rows = [*identity(result), ("computed", day.split("T")[0])]
    rows += [("program", f"vibecalc {result.version}")]
    history: Any = document.get("history") or ()
    heads = ("revision", "date", "text")
    past = table(heads, [[str(one.get(key) or "") for key in heads] for one in history])
    return stacked(pairs(row for row in rows if row[1]), past)


def _remarks(result: Result) -> list[str]:
    words = str(table_of(result.case, "document").get("remarks") or "")
    return [line for part in words.split("\n\n") if part.strip() for line in paragraph(part)]


def summary(result: Result) -> list[str]:
    """The verdict in one sentence, and the results that are looked for first."""
    limits = verdicts_of(result)
    return stacked(paragraph(_verdict(limits)), first_table(result, limits))


def _verdict(limits: Sequence[Verdict]) -> str:
    return pages.conclusion([], limits) or "The case sets no limits."


def assumptions(result: Result) -> list[str]:
    """What the models that took part take for granted and leave out."""
    said = (words for subject in subjects_of(result.record) for words in subject.assumes)
    return [line for words in said for line in paragraph(words, "-")]


def judged(result: Result) -> list[str]:
    """The sentence, and a row for each limit with its utilisation."""
    limits = verdicts_of(result)
    return [*paragraph(_verdict(limits)), *limit_table(limits)]


_BARRED = (
    "Barred: exceeded only in speed ranges that may be barred for continuous operation, and "
    "not at the operating speed."
)
_INFORMATIVE = "Informative: the society's or the standard's current text counts."


def limit_table(rows: Sequence[Verdict], *notes: str) -> list[str]:
    """A row for each limit, and what has to be known of some, with `notes`."""
    told = any(row.element or row.source for row in rows), any(row.status != "case" for row in rows)
    heads = (Column("element"), Column("limit"), Column("rule"), Column("status"),
             number("allowed"), number("computed"), Column("unit"), number("util.\n%"),
             number("at\nrpm"), Column("verdict"))  # fmt: skip
    words = [_BARRED] * any(row.state == BARRED for row in rows)
    words += [_INFORMATIVE] * any(row.status == "informative" for row in rows)
    words += notes
    cells = (_limit_cells(row, *told) for row in rows)
    return [*table(heads, cells), *paragraph(" ".join(words))[: len(words)]]


def _limit_cells(row: Verdict, rules: bool, statuses: bool) -> list[str]:
    row = as_read(row)
    element, limit, source = row.element, row.limit, row.source
    unit = "%" if not element and read_as(row.quantity, row.unit)[1] == "%" else row.unit
    factor = 1.0 if unit == row.unit else convert(1.0, row.unit, unit)
    bounds = ", ".join(bounds_of(row, factor))
    computed = show(factor * row.computed, row.error_estimate * factor)
    if row.quantity in CATALOGUE and CATALOGUE[row.quantity].flag and not element:
        bounds, computed = "no" if row.max == 0.0 else bounds, show(bool(row.computed))
    if element:
        limit += f"; {row.condition}" if row.condition else ""
        computed = as_text(row.computed, row.unit)
        bounds = bounds if row.min is not None else as_text(row.max or 0.0, row.unit)
        if not row.unit and row.max == 1.0:  # the utilisation itself
            bounds = computed = ""
    else:
        picks = ", ".join(f"{axis.replace('_', ' ')} {one}" for axis, one in row.where.items())
        element = place_of(row).strip() or picks
        limit = read_as(row.quantity, row.unit)[0] + " (start)" * (row.at == "start")
        source = source or "limit of the case"
    at = turns(row.speed) if math.isfinite(row.speed) else ""
    rule = source * rules, row.status * statuses
    verdict = pages.limit_verdict(row)
    use = in_percent(row.utilisation)
    return [element, limit, *rule, bounds, computed, unit, use, at, verdict]


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
            from vibecalc.core.report.plots import make

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
        from vibecalc.core.report.plots import vector_picture

        found = vector_picture(maker)
        if found is None:
            return None
        title, image = found
        case = " ".join(str(self.result.case.get("title") or self.result.name).split())
        self.figures += 1
        words = title.removeprefix(case).strip() or title
        return "", [html_figure(f"Figure {self.figures}: {words}", image)]

    def rest(
        self, of: Subject | None, calculation: Calculation
    ) -> Iterator[tuple[str, list[Below]]]:
        """Sections that no chapter names, each with the pictures of its subject behind its last.

        Pictures of the subject `of` itself that no chapter names are for the full report.
        """
        from vibecalc.core.report.plots import pictures_of

        known = {part for one in calculation.chapters for part in (*one.parts, *one.details)}
        left = pictures_of(self.result).keys() - known
        left -= set() if self.full or of is None else of.pictures.keys()
        there = sorted(subjects_of(self.result.record), key=lambda subject: not subject.leads)
        for sections, names in [
            (OF_STUDIES, left - {name for one in there for name in self.drawn(one)}),
            *((one.sections, left & self.drawn(one)) for one in there),
        ]:
            pictures = self.parts(name for name in pictures_of(self.result) if name in names)
            found = [
                (title, [("", below)])
                for where in sections if where not in known
                for title, below in self.parts([where]) if where not in calculation.elsewhere
            ]  # fmt: skip
            if pictures and found:
                found[-1][1].extend(pictures)
            yield from found or ([("Further pictures", pictures)] if pictures else [])

    def drawn(self, subject: Subject) -> set[str]:
        """Names of the pictures of a subject, with those of the curves that it has."""
        owned = (
            path for path in self.result.record if subjects().get(OWNER.get(path, "")) is subject
        )
        return {*subject.pictures, *(CATALOGUE[path].curve for path in owned if path in CATALOGUE)}

    def appendix(self, calculation: Calculation) -> Iterator[Below]:
        """What is left: input, further results, details, reference numbers, accuracy, methods."""
        if calculation is not GENERAL:
            yield from (("Input", below) for _, below in self.parts(GENERAL.chapters[0].parts))
            yield from (
                ("Assumptions", below) for _, below in self.parts(GENERAL.chapters[1].parts)
            )
        references = judge_references(self.result)
        off = pages.references(pages.missed(references))
        parts = [section("Reference numbers", [pages.references(references) if self.full else off])]
        for one in self.left if self.full else ():
            lines = [line for line in one.detail if line not in self.blocks]
            parts.append(section(f"{one.title}: {one.detail_name}", [lines]))
        parts.append(other(self.result, self.shown))
        parts += pages.closings(self.result) if self.full else [
            pages.methods_section(self.result), pages.tolerance(self.result)
        ]  # fmt: skip
        for part in parts:
            if part is not None and any(part.lines):
                yield _CLOSING.get(part.title, part.title), list(html_blocks(part.lines))
