"""Every two optional tables of a kind of machine together in one case: a covering array.

Tables are those of the top level and of [machine], [response] and [response.torsion]. Each pair is
put into a case that has one of the two; to it come all other tables that `check` takes along, those
first that make most new pairs. A pair that no such case has is refused, with the words of `check`.
"""

import copy
import re
from collections.abc import Iterator
from functools import cache
from itertools import combinations, islice

from key_walk import (
    VALUES,
    Aim,
    Data,
    Pattern,
    bases,
    get,
    lighten,
    places,
    plans,
    problems_of,
    put,
    settle,
)

from vibecalc.core.case.raw import EACH
from vibecalc.errors import Problem

Pair = frozenset[Pattern]
#: tables whose own tables are optional parts of a case as well
_ABOVE: tuple[Pattern, ...] = ((), ("machine",), ("response",), ("response", "torsion"))
#: cases with a table that are tried, planned ones and shipped ones
_CASES = 3


def tables(kind: str) -> list[Pattern]:
    """Optional tables, and lists of tables, of a kind of machine."""
    return [
        pattern
        for pattern, (shape, _, required, _) in places(kind).items()
        if not required
        and EACH not in pattern
        and pattern[:-1] in _ABOVE
        and (shape.table or (shape.item and shape.item.table))
    ]


@cache
def with_table(kind: str, table: Pattern) -> list[Data]:
    """Cases that have a table, and that `check` takes."""
    own = [base.data for base in bases(kind) if get(base.data, table) is not None]
    return [*(data for _, data in islice(plans(Aim(kind, table)), _CASES)), *own[:_CASES]]


class Covering:
    """Cases that have every pair of tables between them, made as they are asked for.

    `refused` holds the pairs that no case has, each with what `check` says of the two.
    """

    def __init__(self, kind: str):
        self.kind, self.tables = kind, tables(kind)
        self.refused: dict[Pair, list[Problem]] = {}

    def cases(self) -> Iterator[Data]:
        """Cases with pairs that none before had."""
        left = {frozenset(pair): None for pair in combinations(self.tables, 2)}
        while left:
            pair = next(iter(left))
            data = self._both(pair)
            if data is None:
                del left[pair]
                continue
            data = self._grown(data, left)
            for covered in map(frozenset, combinations(self.present(data), 2)):
                left.pop(covered, None)
            yield data

    def present(self, data: Data) -> list[Pattern]:
        """The tables that a case has."""
        return [table for table in self.tables if get(data, table) is not None]

    def _both(self, pair: Pair) -> Data | None:
        one, other = sorted(pair, key=self.tables.index)
        said: list[Problem] = []
        for first, second in ((one, other), (other, one)):
            for data in with_table(self.kind, first):
                if get(data, second) is not None:
                    return data
                if (found := self._with(data, second, [first], said)) is not None:
                    return found
        self.refused[pair] = said
        return None

    def _grown(self, data: Data, left: dict[Pair, None]) -> Data:
        """The case with all further tables that it can have, those with most new pairs first."""
        untried = set(self.tables)
        while True:
            present = self.present(data)
            untried -= set(present)
            new = {
                table: sum(frozenset((table, one)) in left for one in present) for table in untried
            }
            table = max(sorted(untried), key=lambda table: new[table], default=None)
            if table is None or not new[table]:
                return data
            untried.remove(table)
            found = self._with(data, table, present, [])
            data = data if found is None else found

    def _with(
        self, data: Data, table: Pattern, kept: list[Pattern], said: list[Problem]
    ) -> Data | None:
        """The case with one more table and all that it had; `said` takes what speaks against it."""
        if get(data, table[:-1]) is None:
            return None if get(data, table[:-2]) is None else self._below(data, table, kept, said)
        for other in with_table(self.kind, table):
            alone = copy.deepcopy(data)
            put(alone, table, copy.deepcopy(get(other, table)))
            for new in (alone, {**copy.deepcopy(other), **copy.deepcopy(alone)}):
                lighten(new)
                against = problems_of(new)
                if not settle(new, table, self.kind) and not self._lost(new, kept):
                    return new
                said += against
        return None

    def _lost(self, data: Data, kept: list[Pattern]) -> bool:
        return any(get(data, one) is None for one in kept)

    def _below(
        self, data: Data, table: Pattern, kept: list[Pattern], said: list[Problem]
    ) -> Data | None:
        above = self._with(data, table[:-1], kept, said)
        return None if above is None else self._with(above, table, kept, said)

    def unexplained(self) -> dict[str, str]:
        """Pairs that no case has, though `check` names neither both of them nor what is listed."""
        found = {}
        for pair, said in self.refused.items():
            one, other = sorted(pair, key=self.tables.index)
            name = f"{self.kind}: {'.'.join(one)} + {'.'.join(other)}"
            rows = [row for row in VALUES["apart"] if re.search(row["keys"], name)]
            listed = any(re.fullmatch(row["why"], each.message) for row in rows for each in said)
            if not listed and not any(_names(each, one, other) for each in said):
                found[name] = said[0].message if said else "nothing is said"
        return found


def _names(problem: Problem, *named: Pattern) -> bool:
    """Whether a problem names these tables, in its words or by its places."""
    places = (".".join(map(str, path)) for path in (problem.path, problem.also or ()))
    words = " ".join((problem.message, problem.found, problem.allowed, problem.hint, *places))
    return all(re.search(rf"\b{table[-1]}\b", words) for table in named)
