"""What is read of a case while something is made from it, recorded as it is read.

`traced` stands for a table of the case. It passes every check of type, its methods see it and not
the table, and each field that is read for the first time is noted, with the absence of a table as
a value like any other. A list counts as read whole, and so does a table that is compared or dumped.
"""

import marshal
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from operator import attrgetter
from types import FunctionType
from typing import Any, TypeVar, cast

from pydantic import BaseModel

from vibecalc.core.case.fields import Table
from vibecalc.schema import Case

#: field -> what was read of the table in it; of another field whether there are tables within
Tree = dict[str, "Tree | bool"]
#: stands in a tree for all of a table
WHOLE = ""

T = TypeVar("T")


class Reads:
    """What one piece of work has read: of the case, of other results, of things made once.

    `handed` are names of what earlier stages left, `made` names of what `Scene.once` gave.
    """

    def __init__(self) -> None:
        self.tree: Tree = {}
        self.handed: set[str] = set()
        self.made: set[str] = set()
        self.is_open = True

    def close(self, left: Any) -> bytes:
        """End the record of work that leaves `left`, and return what tells it from others.

        A table within `left` may be read later, by others: all of it counts as read now. Any other
        table can no longer be read, since nobody would know.
        """
        for one in walked(left):
            if type(one) is TracedTable:
                one._release()
        self.is_open = False
        tables: list[str] = []
        plain: list[str] = []
        others: list[str] = []
        _places(self.tree, "", tables, plain, others)
        self._tables, self._plain, self._others = map(_getter, (tables, plain, others))
        return marshal.dumps((tables, plain, others, sorted(self.handed), sorted(self.made)), 2)

    def contents(self, case: Any, known: dict[int, Any]) -> Any:
        """What a case has where this was read, as plain values; None where a table is missing.

        They differ where the case differs. `known` keeps lists and tables that were looked up
        before as plain values, by identity.
        """
        try:
            tables, plain, others = self._tables(case), self._plain(case), self._others(case)
        except AttributeError:
            return None
        for one in others:
            if id(one) not in known:
                known[id(one)] = _plain(one)
        return plain, [type(one).__name__ for one in tables], [known[id(one)] for one in others]


@cache
def _fields_of(kind: type[Table]) -> frozenset[str]:
    return frozenset(kind.model_fields)


class TracedTable:
    """Stands for a table; see `traced`."""

    def __init__(self, table: Table, node: Tree, reads: Reads):
        self.__dict__["_traced"] = (table, node, reads)

    @property  # type: ignore[misc]
    def __class__(self) -> type:
        return type(self._traced[0])

    def __getattr__(self, name: str) -> Any:
        table, node, reads = self.__dict__["_traced"]
        kind: Any = type(table)
        if name in _fields_of(kind) or name == "model_fields_set":
            value = getattr(table, name)
            if isinstance(value, Table):
                below = _note(node, name, {}, reads)
                value = TracedTable(value, below, reads)
            else:
                _note(node, name, _holds_tables(value), reads)
            self.__dict__[name] = value  # the next time it is read as fast as any attribute
            return value
        for base in kind.__mro__:
            if name in vars(base) and base is not BaseModel:
                attribute = vars(base)[name]
                if isinstance(attribute, FunctionType | property):
                    return attribute.__get__(self, kind)
                return getattr(table, name)
        _note(node, WHOLE, True, reads)
        return getattr(table, name)

    def __eq__(self, other: object) -> bool:
        return bool(self._whole() == (other._whole() if type(other) is TracedTable else other))

    def __hash__(self) -> int:
        return hash(self._whole())

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return iter(self._whole())

    def __repr__(self) -> str:
        return repr(self._whole())

    def __reduce_ex__(self, protocol: Any) -> Any:
        return self._whole().__reduce_ex__(protocol)

    def _whole(self) -> Table:
        table, node, reads = self.__dict__["_traced"]
        _note(node, WHOLE, True, reads)
        return cast(Table, table)

    def _release(self) -> None:
        """Let everybody read all of the table from now on."""
        table = self._whole()
        self.__dict__.clear()
        self.__dict__.update(_traced=(table, {}, Reads()), **dict(table))


def traced(table: T, reads: Reads) -> T:
    """Stand in for a table of the case; what is read of it is added to `reads`.

    Once `reads` is closed, a field that was not read before raises RuntimeError.
    """
    return cast(T, TracedTable(cast(Table, table), reads.tree, reads))


class TracedEntries(dict[str, Any]):
    """What earlier stages left, for a stage to read and to add to; `left` is what it adds."""

    def __init__(self, before: dict[str, Any], reads: Reads):
        super().__init__(before)
        self._reads = reads
        self.left: dict[str, Any] = {}

    def _note(self, name: Any) -> None:
        if name not in self.left:
            self._reads.handed.add(name)

    def __getitem__(self, name: str) -> Any:
        self._note(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """As of any dict."""
        self._note(name)
        return super().get(name, default)

    def __contains__(self, name: object) -> bool:
        self._note(name)
        return super().__contains__(name)

    def __setitem__(self, name: str, value: Any) -> None:
        self.left[name] = value
        super().__setitem__(name, value)


def walked(left: Any) -> Iterator[Any]:
    """An object and all in it: in tuples, lists, dicts and objects, but not in stand-ins."""
    waiting, visited = [left], set[int]()
    while waiting:
        one = waiting.pop()
        if id(one) in visited:
            continue
        visited.add(id(one))
        yield one
        if type(one) is TracedTable:
            continue
        if isinstance(one, tuple | list | set | frozenset):
            waiting += one
        elif isinstance(one, dict):
            waiting += one.values()
        elif hasattr(one, "__dict__") and not isinstance(one, type):
            waiting += vars(one).values()
        elif is_dataclass(one) and not isinstance(one, type):  # with slots
            waiting += [getattr(one, field.name) for field in fields(one)]


def written(values: Any) -> bytes:
    """Plain values as bytes: every double in full, equal objects as the same one."""
    try:
        return marshal.dumps(values, 2)
    except ValueError:  # a list that was empty when it was recorded has tables in it
        return marshal.dumps(_plain(values), 2)


def _note(node: Tree, name: str, what: Any, reads: Reads) -> Any:
    if name not in node:
        if not reads.is_open:
            raise RuntimeError(f"{name or 'a table'} of the case is read after its record ended")
        node[name] = what
    return node[name]


def _places(tree: Tree, above: str, tables: list[str], plain: list[str], others: list[str]) -> None:
    """Sort the places of a tree, by attribute path, into tables, plain values and the rest."""
    if WHOLE in tree and not above:  # the case itself
        others += list(Case.model_fields)
        return
    for name, below in sorted(tree.items()):
        place = f"{above}.{name}".strip(".")
        if isinstance(below, dict):
            tables.append(place)
            _places(below, place, tables, plain, others)
        else:
            (others if below else plain).append(place)


def _getter(places: list[str]) -> Callable[[Any], tuple[Any, ...]]:
    if len(places) > 1:
        return attrgetter(*places)
    ones = [attrgetter(place) for place in places]
    return lambda case: tuple([one(case) for one in ones])


def _holds_tables(value: Any) -> bool:
    """Whether `_plain` has to change a value."""
    if isinstance(value, dict):
        return any(map(_holds_tables, value.values()))
    if isinstance(value, tuple | list):
        return any(map(_holds_tables, value))
    return isinstance(value, BaseModel | set | frozenset)


def _plain(value: Any) -> Any:
    """Tables as dicts, sets as lists; what holds neither comes back itself."""
    if isinstance(value, BaseModel):
        return value.model_dump()
    if isinstance(value, set | frozenset):
        return sorted(value)
    if isinstance(value, dict):
        plain: Any = {name: _plain(entry) for name, entry in value.items()}
        return plain if any(plain[name] is not value[name] for name in value) else value
    if isinstance(value, tuple | list):
        plain = [_plain(entry) for entry in value]
        return plain if any(a is not b for a, b in zip(plain, value, strict=True)) else value
    return value
