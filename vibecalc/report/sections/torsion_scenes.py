"""What the first table on a shaft line is made of: its columns, its rows, a limit of the case."""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.report.limits import judge_limits
from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import show
from vibecalc.report.sections.summary import limit_verdict
from vibecalc.report.sections.torsion_terms import TORSION, asked
from vibecalc.results.record import Quantity, Record, Result
from vibecalc.units import convert

HEALTHY, BARE = "healthy/", "bare/"
ANY, OPERATING = "any speed", "operating"
HAMMER, CLOSE = "HAMMER", "CLOSE"
#: behind a value above a limit that is for another column
ABOVE = " !"


class Scene(NamedTuple):
    """A column: its title, its name in a row, and what its paths start with below `TORSION`."""

    title: str
    name: str
    prefix: str


class Row(NamedTuple):
    """A quantity: a text and a place for each scene by its prefix, limit and flag."""

    words: str
    unit: str
    value: dict[str, str]
    limit: str = ""
    flag: str = ""
    where: dict[str, tuple[str, str]] = {}  # noqa: RUF012


def scenes(result: Result) -> list[Scene]:
    """The columns that the result has: all fire, misfire, without dampers."""
    record = result.record
    silent = asked(result).get("misfire")
    found = []
    if isinstance(silent, list | tuple) and silent:
        if any(path.startswith(TORSION + HEALTHY) for path in record):
            found.append(Scene("all\nfire", "all fire", HEALTHY))
        name = f"misfire {', '.join(map(str, silent))}"
        found.append(Scene(name.replace(" ", "\n", 1), name, ""))
        bare = Scene(f"{name},\nwithout\ndampers", "no dampers", BARE)
    else:
        found.append(Scene("all\nfire", "all fire", ""))
        bare = Scene("all fire,\nwithout\ndampers", "no dampers", BARE)
    if any(path.startswith(TORSION + BARE) for path in record):
        found.append(bare)
    return found


def own_entry(record: Record, path: str, section: str) -> float | None:
    """The entry of a section under `TORSION`, None if it has none."""
    quantity: Quantity | None = having(record, TORSION + path, "section")
    found = [] if quantity is None else labels(quantity.axes[0])
    if quantity is None or section not in found:
        return None
    return float(quantity.values[found.index(section)])


def bound_of(result: Result, path: str, factor: float) -> tuple[str, str, float]:
    """The first `[[limit]]` of the case on a whole quantity, its verdict, and its size."""
    for row in judge_limits(result):
        whole = row.quantity == path and not row.where and row.at != "start"
        if whole and row.max is not None:
            own: Any = result.record[path].unit
            bound = factor * convert(row.max, row.unit, own)
            return show(bound, digits=5), limit_verdict(row), bound
    return "", "", np.inf
