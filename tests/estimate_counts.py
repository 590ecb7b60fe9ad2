"""How honest the error estimates of many runs are: counts, and what becomes of the tolerance."""

import copy
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from random_machines import Table

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.results.tolerance import reached
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.schema import Case

MOST_TOO_LOW, MOST_TOO_HIGH = 0.01, 0.05
UNIT = 2.0**-52


class Uncertain(NamedTuple):
    """A quantity with its true error, its estimate and its size; the truth is off by `noise`."""

    path: str
    error: float
    estimate: float
    size: float
    noise: float = 0.0

    @property
    def too_low(self) -> bool:
        """The estimate is surely below a tenth of the true error."""
        return self.estimate < 0.1 * (self.error - self.noise)

    @property
    def too_high(self) -> bool:
        """Surely a thousand times above it; errors below .001 ulp are hits by luck."""
        largest = self.error + self.noise
        return largest > 1e-3 * UNIT * self.size and self.estimate > 1e3 * largest


class Reported(NamedTuple):
    """One machine: its case, its record, and each quantity that has a truth."""

    table: Table
    record: Record
    judged: list[Uncertain]


def flat(nested: Any) -> Iterator[Any]:
    """Entries of lists within lists, one after the other."""
    if isinstance(nested, list | tuple):
        for entry in nested:
            yield from flat(entry)
    else:
        yield nested


def checked_run(table: Table) -> tuple[Case, Record]:
    """A run of a case table in which nothing is wrong."""
    case = validate(copy.deepcopy(table))
    assert check_machine(case) == []
    return case, run_case(case)


def reported_or_refused(
    tables: Iterable[Table], judge: Callable[[Table], Reported]
) -> Iterator[Reported | NumericalFailure]:
    """Each machine judged; one that is refused (exit 3) has nothing to be wrong."""
    for table in tables:
        try:
            yield judge(table)
        except NumericalFailure as failure:
            yield failure


def hold(judged: list[Uncertain], words: str = "", most_high: float = MOST_TOO_HIGH) -> None:
    """At most 1 % of the estimates are too low, at most 5 %, or as given, too high."""
    low, high = [one for one in judged if one.too_low], [one for one in judged if one.too_high]
    print(f"{words}: {len(judged)} estimates, {len(low)} too low, {len(high)} too high")
    print("  too low:", Counter(one.path for one in low).most_common(8))
    print("  too high:", Counter(one.path for one in high).most_common(8))
    assert len(low) <= MOST_TOO_LOW * len(judged), low[:20]
    assert len(high) <= most_high * len(judged), high[:20]
    assert [one for one in judged if one.error - one.noise > one.estimate == 0.0] == []


def broken_promises(reported: Reported) -> list[Uncertain]:
    """Quantities beyond `[accuracy] rtol` by their true error, of which the run says nothing."""
    rtol = float(reported.table["accuracy"]["rtol"])
    shares = {
        path: reached(quantity, reported.record) for path, quantity in reported.record.items()
    }
    missed = {path for path, share in shares.items() if share is not None and share > rtol}
    said = any("accuracy not reached" in words for words in reported.record.warnings)
    assert said == bool(missed)
    broken = []
    for one in reported.judged:
        share = shares[one.path]
        if share is None or one.path in missed:
            continue
        # a part of a balance is measured by the whole of it
        size = one.estimate / share if share > 0.0 else one.size
        if one.error - one.noise > rtol * size:
            broken.append(one)
    return broken
