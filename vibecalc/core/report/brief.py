"""The brief report: as long as the case asks for, the first tables of all sections first."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

from vibecalc.core.report.sections import Section, stacked
from vibecalc.core.report.writing import height, paragraph, titled

#: lines of the report of a case of so many keys, those for each further key, and of the largest one
_LEAST, _FEW, _EACH, _MOST = 40, 10, 2, 90
#: tables of a case that ask for no section
_BESIDE = ("document", "limit", "picture", "reference")


def lines_of(case: Any) -> int:
    """How many lines the report of a case may have: 40 for ten keys, 90 for 35 and more."""
    return min(_MOST, _LEAST + _EACH * max(0, _keys(case) - _FEW))


def _keys(case: Any) -> int:
    if isinstance(case, Mapping):
        return sum(_keys(value) for key, value in case.items() if key not in _BESIDE)
    tables = isinstance(case, list) and case and isinstance(case[0], Mapping)
    return sum(map(_keys, case)) if tables else 1


def fitted(found: Sequence[Section], room: int) -> list[str]:
    """Sections in at most so many lines, and a paragraph that names what found no room.

    The first tables of all sections are taken before the second ones; a table with its notes is
    shown whole or not at all, and none after one that found no room.
    """
    tables = [[list(lines) for some, lines in groupby(one.lines, bool) if some] for one in found]
    shown = [0] * len(found)
    for place in range(max(map(len, tables), default=0)):
        for i, its in enumerate(tables):
            if shown[i] == place < len(its):
                tried = [*shown[:i], place + 1, *shown[i + 1 :]]
                if height(_lines(found, tables, tried)) <= room:
                    shown = tried
    return _lines(found, tables, shown)


def _lines(
    found: Sequence[Section], tables: Sequence[list[list[str]]], shown: Sequence[int]
) -> list[str]:
    """So many tables of each section, and what is left out."""
    lines, left = list[str](), list[str]()
    for one, its, count in zip(found, tables, shown, strict=True):
        lines += titled(one.title, stacked(*its[:count])) if count else []
        if count < len(its):
            left.append(f"more of {one.title}" if count else one.title)
        left += [one.detail_name] if one.detail else []
    if not left:
        return lines
    return [*lines, "", *paragraph(f"`vibecalc report --full` adds: {'; '.join(left)}.")]
