"""Rules between the keys of a table: data on the table (`RULES`), and what holds a case to them.

They work on the case as tomllib reads it, so that they also run where the schema found problems;
what they cannot read they leave to the schema. A rule is anything that is called with a `Row` and
yields problems; those that an editor can follow also say themselves in the JSON schema.
"""

import functools
import unicodedata
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise, product
from typing import Any

from vibecalc.core.case.fields import Table
from vibecalc.core.case.raw import (
    EACH,
    Data,
    entries_at,
    misspelt,
    read_number,
    table_at,
    tables_at,
    unknown,
)
from vibecalc.core.case.walk import Shape, keys_of, shape_of, words
from vibecalc.core.results.named import named
from vibecalc.core.results.visible import hidden, spelled
from vibecalc.errors import KeyPath, Problem, dotted, leaves

# ----------------------------------------------------------------------------
# A table as written, and the walk that holds every table of a case to its rules.
# ----------------------------------------------------------------------------

#: a key below a table (`a.b`), "" for the table itself, or a path from the root of the case
At = str | KeyPath


@functools.cache
def _shape(model: type[Table], key: str) -> Shape:
    field = keys_of(model).get(key)
    return Shape(kind="") if field is None else shape_of(field)


@functools.cache
def _default(model: type[Table], key: str) -> Any:
    field = keys_of(model).get(key)
    value = None if field is None else field.get_default(call_default_factory=True)
    return list(value) if isinstance(value, tuple) else value


@dataclass(frozen=True, repr=False, eq=False)
class Row:
    """A table as written (`data`, of the class `model`) at its path in the whole case."""

    data: Data
    path: KeyPath
    case: Data
    model: type[Table]

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def __getitem__(self, key: str) -> Any:
        """What stands at a key, or its default."""
        return self.data[key] if key in self.data else _default(self.model, key)

    def said(self, *keys: str) -> list[str]:
        """Those of the keys that say something: a resolved case holds defaults, too."""
        defaults = {key: _default(self.model, key) for key in keys}
        return [
            key
            for key, default in defaults.items()
            if key in self.data and (default is None or self.data[key] != default)
        ]

    def lacks(self, *keys: str) -> bool:
        """Whether none of the keys is there, nor one that may be one of them with a slip in it."""
        return self.data.keys().isdisjoint(keys) and not misspelt(self.data, self.path, *keys)

    def number(self, key: str) -> float | None:
        """The number at a key in SI, or its default."""
        return read_number(self[key], _shape(self.model, key).unit or "")

    def unit(self, key: str) -> str:
        """SI unit of a key, with a blank before it."""
        shape = _shape(self.model, key)
        return f" {(shape.item or shape).unit or ''}".rstrip()

    @property
    def machine(self) -> Data:
        """The table [machine] of the case, or an empty one."""
        table: Data = table_at(self.case, "machine")
        return table

    def entries(self, key: str) -> list[Any]:
        """The list at a key, or an empty one."""
        return self.data[key] if isinstance(self.data.get(key), list) else []

    def listed(self, key: str) -> list[Any]:
        """The list at a key, numbers in SI, and None for what is none."""
        item = _shape(self.model, key).item
        if item is None or item.kind not in ("number", "whole"):
            return self.entries(key)
        return [read_number(entry, item.unit or "") for entry in self.entries(key)]

    def below(self, key: str) -> "Row | None":
        """The table at a key, if there is one."""
        table = self.data.get(key)
        if not isinstance(table, dict):  # a shape imports its table
            return None
        model = _shape(self.model, key).table
        return None if model is None else Row(table, (*self.path, key), self.case, model)

    def each(self, key: str) -> "list[Row]":
        """The tables in the list at a key."""
        tables = list(tables_at(self.data, key))
        item = _shape(self.model, key).item if tables else None
        model = item.table if item else None
        if model is None:
            return []
        return [Row(one, (*self.path, key, place), self.case, model) for place, one in tables]

    def header(self) -> str:
        """The table as a case writes it: `[machine.body]`, or an entry: `limit[0]`."""
        text = dotted(self.path)
        return text if text.endswith("]") else f"[{text}]"

    def place(self, at: At) -> KeyPath:
        """The key path of a place."""
        return (*self.path, *filter(None, at.split("."))) if isinstance(at, str) else at

    def problem(self, at: At, message: str, *, also: At = (), **words: Any) -> Problem:
        """A problem at a place with `found`, `allowed` and `hint`; also at another place, if
        anything stands there."""
        *above, key = self.place(also) or ("",)
        there = isinstance(key, int) or key in table_at(self.case, *above)
        return Problem(self.place(at), message, also=(*above, key) if there else None, **words)


Rule = Callable[[Row], Iterator[Problem]]


def row_at(case: Data, *path: str) -> Row | None:
    """The table of a case at a path, if there is one."""
    row: Row | None = Row(case, (), case, named("vibecalc.schema:Case"))
    for key in path:
        row = None if row is None else row.below(key)
    return row


def cross_check(case: Data) -> list[Problem]:
    """Return all problems between keys of a case; never raises on nonsense."""
    return [*_walk(Row(case, (), case, named("vibecalc.schema:Case"))), *_unseen(case)]


def _unseen(case: Data) -> Iterator[Problem]:
    """Texts with characters that nobody sees, or that move what others see."""
    for path, value in leaves(case):
        if isinstance(value, str) and (character := hidden(value)):
            name = unicodedata.name(character, "a control character").lower()
            yield Problem(
                path=path,
                message=f"{path[-1]} has an unprintable character",
                found=f"{spelled(character)}, {name}",
                allowed="printable characters, spaces, tabs and new lines",
            )


def _walk(row: Row) -> Iterator[Problem]:
    for rule in row.model.RULES:
        yield from (named(rule) if isinstance(rule, str) else rule)(row)
    for key, value in row.data.items():
        if isinstance(value, dict | list):
            table = row.below(key)
            for below in (table,) if table else row.each(key):
                yield from _walk(below)


# ----------------------------------------------------------------------------
# Which keys go together: one of several, one with another, those of a kind.
# ----------------------------------------------------------------------------

Schema = dict[str, Any]


def both(names: Collection[str], word: str = "and") -> str:
    """Names in a sentence: a, b and c."""
    *first, last = names
    return f"{', '.join(first)} {word} {last}" if first else last


def _says(model: type[Table], *keys: str) -> Schema:
    """As `Row.said`: one of these keys is there, and not at its default."""
    alone = len(keys) == 1 and _default(model, keys[0]) is None
    return {"required": [*keys]} if alone else {"not": _silent(model, *keys)}


def _silent(model: type[Table], *keys: str) -> Schema:
    """That these keys are not there, or at their defaults."""
    defaults = {key: _default(model, key) for key in keys}
    return {
        "properties": {
            key: False if default is None else {"const": default}
            for key, default in defaults.items()
        }
    }


class OneOf:
    """One of some alternatives, each of names of keys; or none where `when` says no."""

    def __init__(
        self,
        *alternatives: str,
        when: bool | Callable[[Row], Any] = True,
        allowed: str = "",
        hint: str = "",
    ) -> None:
        self.alternatives = tuple(tuple(one.split()) for one in alternatives)
        self.needed, self.allowed, self.hint = when, allowed, hint

    def given(self, row: Row) -> list[str]:
        """A key of each alternative that a table has."""
        return [said[0] for one in self.alternatives if (said := row.said(*one))]

    def __call__(self, row: Row) -> Iterator[Problem]:
        """Yield each alternative beyond the first, or that there is none."""
        given = self.given(row)
        allowed = self.allowed or ", or ".join(map(both, self.alternatives))
        for key in given[1:]:
            message = f"{key} and {given[0]} are mutually exclusive"
            yield row.problem(key, message, allowed=allowed, also=given[0])
        needed = self.needed(row) if callable(self.needed) else self.needed
        every = [key for alternative in self.alternatives for key in alternative]
        empty = any(isinstance(row.data.get(key), list) and not row.data[key] for key in every)
        if needed and not given and (empty or row.lacks(*every)):
            message = f"{row.header()} has neither {' nor '.join(map(both, self.alternatives))}"
            yield row.problem("", message, allowed=allowed, hint=self.hint)

    def schema(self, model: type[Table]) -> list[Schema]:
        """What an editor can hold such a table to."""
        against: dict[str, list[str]] = {}
        for first, second in combinations(self.alternatives, 2):
            for pair in product(first, second):
                one, other = sorted(pair, key=lambda key: _default(model, key) is not None)
                if not _default(model, one) and not _default(model, other):
                    against.setdefault(one, []).append(other)
        schemas = [
            {"not": {"required": [one, *others]}}
            if len(others) == 1 and _default(model, others[0]) is None
            else {"if": _says(model, one), "then": _silent(model, *others)}
            for one, others in against.items()
        ]
        every = [{"required": [key]} for alternative in self.alternatives for key in alternative]
        return [*schemas, {"anyOf": every}] if self.needed is True else schemas


one_of = OneOf


def at_most_one(*alternatives: str, allowed: str = "") -> OneOf:
    """One of these alternatives, or none."""
    return one_of(*alternatives, when=False, allowed=allowed)


class Needs:
    """Where `key` is, one of `others` has to be; without a key: wherever the table is.

    `why` ends the sentence.
    """

    def __init__(
        self,
        key: str,
        others: str,
        why: str = "",
        allowed: str = "",
        when: Callable[[Row], Any] | None = None,
    ) -> None:
        self.key, self.others, self.when = key, tuple(others.split()), when
        self.why = f": {why}" if why else ""
        self.allowed = allowed or f"{self.others[0]} with it"

    def __call__(self, row: Row) -> Iterator[Problem]:
        """Yield that what is needed is not there."""
        asked = (not self.key or row.said(self.key)) and (not self.when or self.when(row))
        if asked and row.lacks(*self.others):
            message = f"{self.key or row.header()} needs {both(self.others, 'or')}{self.why}"
            yield row.problem(self.key, message, allowed=self.allowed)

    def schema(self, model: type[Table]) -> list[Schema]:
        """What an editor can hold such a table to."""
        others: Schema = {"required": [*self.others]}
        if len(self.others) > 1:
            others = {"anyOf": [{"required": [other]} for other in self.others]}
        if self.key:
            others = {"if": _says(model, self.key), "then": others}
        return [] if self.when else [others]


needs = Needs


class ByKind:
    """The keys of a table of each kind of `what`: `needed ones | others`.

    `kind_of` tells the kind of a table that need not say it; the first kind is then the usual one.
    """

    def __init__(
        self,
        what: str,
        kind_of: Callable[[Row], Any] | None = None,
        key: str = "kind",
        **kinds: str,
    ) -> None:
        self.what, self.kind_of, self.key = what, kind_of, key
        rows = {kind: keys.partition("|") for kind, keys in kinds.items()}
        self.kinds = {
            kind: (tuple(needed.split()), tuple(others.split()))
            for kind, (needed, _, others) in rows.items()
        }

    def __call__(self, row: Row) -> Iterator[Problem]:
        """Yield what the table lacks for its kind, and what belongs to another one."""
        kind = self.kind_of(row) if self.kind_of else row[self.key]
        if not isinstance(kind, str) or kind not in self.kinds:
            return  # the schema refuses it; which keys it should have is anyone's guess
        needed, other = self.kinds[kind]
        usual = next(iter(self.kinds))
        if self.kind_of and self.key not in row and kind != usual:
            yield row.problem(
                "",
                f"the kind of this {self.what} is missing",
                found=", ".join(key for key in row.data if key in self._known()),
                allowed=f"{self.key} = {kind!r}, with {', '.join(needed)}",
                hint=f"without a kind it is {usual!r}",
            )
            return
        has = ", ".join((*needed, *other)) or "no such key"
        missing = [key for key in needed if row.lacks(key)]
        if missing:
            message = f"{self._named(kind)} needs {both(missing)}"
            hint = "; ".join(
                f"{key}: {words(_shape(row.model, key))}, {keys_of(row.model)[key].description}"
                for key in missing
            )
            yield row.problem("", message, allowed=has, hint=hint, also=self.key)
        for key in row.said(*(key for key in row.data if key in self._known())):
            if key not in (*needed, *other):
                message = f"{self._named(kind)} has no {key}"
                hint = f"{key} belongs to {self._named(*self._owners(key))}"
                yield row.problem(key, message, allowed=has, hint=hint, also=self.key)

    def _named(self, *kinds: str) -> str:
        listed = both([*map(repr, kinds)], "or")
        return f"a {self.what} of kind {listed}" if self.what else f"{self.key} = {listed}"

    def _owners(self, key: str) -> tuple[str, ...]:
        return tuple(kind for kind, keys in self.kinds.items() if key in (*keys[0], *keys[1]))

    def _known(self) -> set[str]:
        return {key for row in self.kinds.values() for keys in row for key in keys}

    def schema(self, model: type[Table]) -> list[Schema]:
        """What an editor can hold such a table to."""
        usual = next(iter(self.kinds)) if self.kind_of else _default(model, self.key)

        def of(*kinds: str, said: bool) -> Schema:
            required = {"required": [self.key]} if said and usual not in kinds else {}
            one_of_them = {"enum": [*kinds]} if len(kinds) > 1 else {"const": kinds[0]}
            return {"properties": {self.key: one_of_them}, **required}

        groups: dict[tuple[str, ...], list[str]] = {}
        for key in sorted(self._known()):
            groups.setdefault(self._owners(key), []).append(key)
        schemas: list[Schema] = [
            {"if": _says(model, *keys), "then": of(*owners, said=usual in self.kinds)}
            for owners, keys in groups.items()
            if len(owners) < len(self.kinds)
        ]
        needs: dict[tuple[str, ...], list[str]] = {}
        for kind, (needed, _) in self.kinds.items():
            needs.setdefault(needed, []).append(kind)
        rows = ((of(*kinds, said=True), [*keys]) for keys, kinds in needs.items() if keys)
        return [*schemas, *({"if": kind, "then": {"required": keys}} for kind, keys in rows)]


by_kind = ByKind


def barred(places: Iterable[KeyPath]) -> Schema:
    """What an editor is told of places that are not there."""
    schema: Schema = {}
    for path in places:
        at = schema
        for part in path[:-1]:
            below = at.setdefault("properties", {}) if part != EACH else at
            at = below.setdefault("items" if part == EACH else str(part), {})
        at.setdefault("properties", {})[path[-1]] = False
    return schema


class Without:
    """None of these places below the table, as `springs.individual.*.static`, is there."""

    def __init__(self, places: str, message: str, **words: str) -> None:
        self.places = tuple(tuple(one.split(".")) for one in places.split())
        self.message, self.words = message, words

    def __call__(self, row: Row) -> Iterator[Problem]:
        """Yield each of the keys that is there."""
        for place in self.places:
            for path, _ in entries_at(row.data, place):
                yield row.problem((*row.path, *path), self.message, **self.words)

    def schema(self, model: type[Table]) -> list[Schema]:
        """What an editor can hold such a table to."""
        return [barred(self.places)]


without = Without

# ----------------------------------------------------------------------------
# Names, columns, numbers in their order; and what no other rule says.
# ----------------------------------------------------------------------------


def unique(key: str, what: str = "", name: str = "name") -> Rule:
    """Each entry of the list at `key` has a name of its own."""

    def rule(row: Row) -> Iterator[Problem]:
        seen: dict[str | float, int] = {}
        for place, entry in enumerate(row.each(key)):
            text = entry.data.get(name)
            said = text if _shape(entry.model, name).kind == "text" else entry.number(name)
            if not isinstance(said, str | float) or said == "":
                continue
            if seen.setdefault(said, place) != place:
                yield row.problem(
                    (*row.path, key, place, name),
                    f"two {what or f'entries of {key}'} are named {str(text)[:60]!r}"
                    if isinstance(said, str)
                    else f"two {what} have the same {name}, {text}",
                    hint=f"give each its own {name}",
                    also=(*row.path, key, seen[said], name),
                )

    return rule


def once(key: str, what: str) -> Rule:
    """No text and no number is given twice in the list at `key`."""

    def rule(row: Row) -> Iterator[Problem]:
        names = row.listed(key)
        seen: set[str | float] = set()
        for place, name in enumerate(names):
            if isinstance(name, str | float) and name in seen:
                shown = row.entries(key)[place]
                yield row.problem(
                    (*row.path, key, place),
                    f"{what} {repr(shown[:60]) if isinstance(shown, str) else shown} is given "
                    f"twice in {key}",
                    allowed=f"each {what} once",
                    also=(*row.path, key, names.index(name)),
                )
            elif isinstance(name, str | float):
                seen.add(name)

    return rule


def ascending(key: str, start: float | None = None) -> Rule:
    """Each number of the list at `key` is larger than the one before it; the first is `start`."""

    def rule(row: Row) -> Iterator[Problem]:
        numbers, unit = row.listed(key), row.unit(key)
        pairs = enumerate(pairwise(numbers), start=1)
        back = [at for at, (low, high) in pairs if None not in (low, high) and not low < high]
        if back:
            low, high = numbers[back[0] - 1 : back[0] + 1]
            yield row.problem(
                (*row.path, key, back[0]),
                f"the entries of {key} must be ascending",
                found=f"{low:.6g}{unit}, then {high:.6g}{unit} in row {back[0] + 1}",
                allowed="each larger than the one before it",
            )
        elif start is not None and None not in numbers[:1] and numbers[:1] not in ([], [start]):
            yield row.problem(
                (*row.path, key, 0),
                f"{key} has to begin at {start:g}",
                found=f"{numbers[0]:.6g}{unit} in the first row",
                allowed=f"a first row of {start:g}{unit}",
            )

    return rule


def same_length(*columns: str, what: str = "") -> Rule:
    """As many entries in each of the columns that are there; what the schema refuses is left."""

    def rule(row: Row) -> Iterator[Problem]:
        lists = {key: row.data[key] for key in columns if isinstance(row.data.get(key), list)}
        short = any(len(rows) < _shape(row.model, key).lengths[0] for key, rows in lists.items())
        if len({len(rows) for rows in lists.values()}) > 1 and not short:
            yield row.problem(
                "",
                f"the columns of {what or row.path[-1]} differ in length",
                found=", ".join(f"{len(rows)} of {key}" for key, rows in lists.items()),
                allowed="the same number of entries in each",
            )

    return rule


def ordered(
    low: str, high: str, message: str = "", when: Callable[[Row], Any] | None = None
) -> Rule:
    """The number at `low` is below that at `high`, where `when` does not say no."""
    joined = " " if low in ("from", "to") else " and "

    def rule(row: Row) -> Iterator[Problem]:
        first, last = row.number(low), row.number(high)
        if first is not None and last is not None and not first < last and (not when or when(row)):
            yield row.problem(
                low if low in row else high,
                message or f"{row.header()} must go from a lower to a higher value",
                found=f"{low} {str(row[low])[:40]}{joined}{high} {str(row[high])[:40]}",
                allowed=f"{low} < {high}",
                also=high if low in row else (),
            )

    return rule


#: of a table that says from which speed to which one
upwards = ordered("from", "to", "a run-up must go from a lower to a higher speed")


def below(low: str, high: str, message: str, equal: bool = False) -> Rule:
    """As `ordered`, of two sizes: the first in SI, and what the second leaves for it."""

    def rule(row: Row) -> Iterator[Problem]:
        small, large = row.number(low), row.number(high)
        if small is None or large is None or small < large or (equal and small == large):
            return
        yield row.problem(
            low if low in row else high,
            message,
            found=f"{small:.6g}{row.unit(low)}",
            allowed=f"{'<=' if equal else '<'} {large:.6g}{row.unit(high)}",
            also=high,
        )

    return rule


def pair_ordered(key: str, equal: bool = True) -> Rule:
    """The two numbers of the list at `key` go from the lower to the higher one, or are equal."""

    def rule(row: Row) -> Iterator[Problem]:
        ends, numbers = row.entries(key), row.listed(key)
        if len(ends) != 2 or None in numbers or numbers[0] < numbers[1]:
            return
        if not equal or numbers[0] > numbers[1]:
            yield row.problem(
                key,
                f"{key} must go from a lower to a higher value",
                found=f"{ends[0]} to {ends[1]}",
                allowed=f"from {'<=' if equal else '<'} to",
            )

    return rule


def refers(key: str, to: str, what: str) -> Rule:
    """Names at `key` (of each entry of a list, as `shafts.between`) are those of a list of tables.

    `to` is the list, from the root of the case.
    """
    *above, last = key.split(".")

    def rule(row: Row) -> Iterator[Problem]:
        *tables, entries = to.split(".")
        owner = row_at(row.case, *tables)
        if owner is None or (entries not in owner and not _may_miss(owner, entries)):
            return  # the schema says so
        if isinstance(owner[entries], str):
            return  # a file that cannot be read
        known = [one.get("name") for _, one in tables_at(row.case, *tables, entries)]
        names = [name for name in known if isinstance(name, str)]
        rows = tables_at(row.data, *above) if above else [(0, row.data)]
        for place, entry in rows:
            path = (*row.path, *above, place, last) if above else (*row.path, last)
            said = entry.get(last)
            asked: Sequence[Any] = said if isinstance(said, list) else [said]
            for number, name in enumerate(asked):
                if isinstance(name, str) and name and name not in names:
                    at = (*path, number) if isinstance(said, list) else path
                    wrong = unknown(at, what, name, names)
                    example = f"{entries} = [{{ name = {name[:60]!r}, ... }}]"
                    yield wrong if names else wrong._replace(allowed=example)

    return rule


def _may_miss(row: Row, key: str) -> bool:
    return row.lacks(key) and not keys_of(row.model)[key].is_required()


class _Words(dict[str, Any]):
    """What a table says, for the words of a refusal."""

    def __init__(self, row: Row) -> None:
        place = row.path[-1] if row.path else ""
        entry, of = "", str(place)
        if isinstance(place, int):
            entry, of = str(row["name"] or place + 1)[:60], str(row.path[-2]).removesuffix("s")
        super().__init__(header=row.header(), entry=entry, list=of)
        self.row = row

    def __missing__(self, key: str) -> Any:
        value = self.row[key]
        return value[:60] if isinstance(value, str) else str(value)[:60]


def refuse(
    at: At,
    message: str,
    when: Callable[[Row], Any],
    allowed: str = "",
    *,
    found: str = "",
    hint: str = "",
    also: At = (),
) -> Rule:
    """What is wrong where `when` says so; `{key}` in message and found is what stands there."""

    def rule(row: Row) -> Iterator[Problem]:
        if when(row):
            said = _Words(row)
            yield row.problem(
                at,
                message.format_map(said),
                found=found.format_map(said),
                allowed=allowed,
                hint=hint,
                also=also,
            )

    return rule


def wants(place: str, allowed: str = "", hint: str = "", of: str = "") -> Rule:
    """What this table asks needs another one, at a place from the root of the case.

    With `of` that is said of such a kind of machine only; others do not have the table at all.
    """
    *above, key = place.split(".")

    def rule(row: Row) -> Iterator[Problem]:
        there, kind = row_at(row.case, *above), table_at(row.case, "machine").get("kind")
        if there is not None and there.data and there.lacks(key) and of in ("", kind):
            message = f"{row.header()} needs [{place}]"
            yield row.problem("", message, allowed=allowed, hint=hint)

    return rule


def at(key: str, *rules: Rule) -> Rule:
    """Rules for the table at a key, of one kind of machine only."""

    def rule(row: Row) -> Iterator[Problem]:
        table = row.below(key)
        if table is not None:
            for one in rules:
                yield from one(table)

    return rule


def no(
    keys: str, when: Callable[[Row], Any], message: str, allowed: str = "", **words: Any
) -> Rule:
    """None of these keys goes with what `when` says; `{key}` in the words is the key."""

    def rule(row: Row) -> Iterator[Problem]:
        for key in row.said(*keys.split()) if when(row) else ():
            shown = allowed.format(key=key)
            yield row.problem(key, message.format(key=key), allowed=shown, **words)

    return rule
