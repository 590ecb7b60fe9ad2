"""What the frame and a stage agree on: its row of the plan, and the run in progress."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.results.catalogue import AXES, CATALOGUE, OWNER
from vibecalc.core.results.described import Group, given_in
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Axis, Method, Record
from vibecalc.errors import KeyPath, NumericalFailure
from vibecalc.numerics.bounded import Bounded, Summed
from vibecalc.subjects import SUBJECTS

if TYPE_CHECKING:
    from vibecalc.parts.machine import MachineParts
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# What a plan says of one stage.
# ----------------------------------------------------------------------------


#: longest arrays whose entries keep errors of their own; of others the largest counts for all
_ENTRIES_WITH_ERRORS = 2000

#: (how many, name of the unit of work)
Work = tuple[tuple[float, str], ...]


class Harmonics(NamedTuple):
    """Orders lowest, lowest + step .. highest, `number` of them, and the rule that fixed them.

    `is_least`: the stage goes on to more where the tolerance is not met with these. Steps that
    differ, as of several shafts, are none of `lowest`.
    """

    number: int
    lowest: float
    highest: float
    rule: str
    is_least: bool = False

    def words(self) -> str:
        """`12: 0.5 to 6 by 0.5 (the case asks)`."""
        if self.number <= 1:
            return f"{self.number}: {self.highest:g} ({self.rule})"
        step = (self.highest - self.lowest) / (self.number - 1)
        even = abs(step - self.lowest) <= 1e-9 * self.lowest
        by = "" if step == 1.0 or not even else f" by {step:.6g}"
        at_least = "at least " if self.is_least else ""
        ends = f"{self.lowest:.4g} to {self.highest:.4g}"
        return f"{at_least}{self.number}: {ends}{by} ({self.rule})"


class Leading(NamedTuple):
    """That a stage computes many points of a sweep at once, its numbers having a leading axis.

    `keys` name the numbers of the case that may be arrays (points,), `[]` being any entry of a
    list; every stage of a case that has a `Leading` takes the keys of all, if it `takes_all`.
    `only` are the results that it gives, none for all of the stage. `why_not` says why the stage
    takes this case point by point, if it does. `most` is how many points it takes at once.
    `adapter` stands for that of the stage where that one takes no leading axis. `milliseconds` is
    what each of many points takes, if that is enough for many processes to share them.
    """

    keys: frozenset[str] = frozenset()
    only: tuple[str, ...] = ()
    why_not: str = ""
    most: int = 2048
    adapter: str = ""
    takes_all: bool = True
    milliseconds: float = 0.0


class Stage(NamedTuple):
    """One stage of a run as its case asks for it.

    `adapter` names the function that runs it as `package.module:function`, `topics` those that
    measure its methods; `why` is the reason shown, `parts` what it reads of the machine, `cost` its
    work in words, `quantities` the paths that it makes. `harmonics` and `work` count, from the case
    alone. `is_last` marks a stage that no later one reads from, `leading` one that takes many
    points at once.
    """

    name: str
    adapter: str
    why: str
    parts: tuple[str, ...]
    orders: str
    cost: str
    quantities: tuple[str, ...]
    is_last: bool = False
    harmonics: "Callable[[Case], Harmonics] | None" = None
    work: "Callable[[Case, int], Work] | None" = None
    topics: tuple[str, ...] = ()
    leading: Leading | None = None

    def as_texts(self) -> dict[str, str]:
        """The plan of this stage as short texts, for reports."""
        return {
            "stage": self.name,
            "why": self.why,
            "parts": ", ".join(self.parts),
            "orders": self.orders,
            "cost": self.cost,
            "quantities": ", ".join(self.quantities),
        }


def first_orders(number: int, rule: str) -> Harmonics:
    """The orders 1 to `number`."""
    return Harmonics(number, 1, number, rule)


def harmonics_of(case: "Case", stage: Stage) -> Harmonics | None:
    """Harmonics that a stage of `case` will compute; None for a stage without any.

    Raises NumericalFailure where no number of harmonics meets the tolerance, as the run will.
    """
    return None if stage.harmonics is None else stage.harmonics(case)


def work_of(case: "Case", stage: Stage) -> Work:
    """The work of one stage; entries of zero are left out."""
    found = harmonics_of(case, stage)
    counted = () if stage.work is None else stage.work(case, 0 if found is None else found.number)
    return (*((number, unit) for number, unit in counted if number), (1, "stage"))


@lru_cache(maxsize=64)
def below(prefix: str, without: tuple[str, ...] = ()) -> tuple[str, ...]:
    return tuple(
        path
        for path in CATALOGUE
        if path.startswith(prefix) and not any(word in path for word in without)
    )


# ----------------------------------------------------------------------------
# What a subject says of itself: its folder has a `stage.py` with one `SUBJECT`.
# ----------------------------------------------------------------------------


class Unit(NamedTuple):
    """What a piece of work costs: seconds of one thread, its name when there are many.

    `library` is the heavy one that it takes, `megabytes` what each piece keeps and `holds` what the
    first one needs on top.
    """

    seconds: float
    words: str
    library: str = ""
    megabytes: float = 0.0
    holds: float = 0.0


class Entries(NamedTuple):
    """The numbers that an axis of a result will have, and what of the case says so.

    `between`: the result is a curve, with a value at every number between the two ends.
    """

    values: tuple[float, ...]
    because: str
    between: bool = False

    @classmethod
    def up_to(cls, last: int, because: str, first: int = 1) -> "Entries":
        """The numbers `first`, `first` + 1, ... `last`."""
        return cls(tuple(range(first, last + 1)), because)

    @classmethod
    def of_speeds(cls, asked: Any, table: str) -> "Entries | None":
        """The speeds of a curve that a table of the case asks for; None without that table."""
        words = f"[{table}] says from where to where"
        return cls((asked.start, asked.stop), words, between=True) if asked else None


class Subject(NamedTuple):
    """One subject: what it can do for a case. Functions are named as `package.module:function`.

    `stages` are makers of the stages that a case asks for, in the order in which they run.
    `concerns` says whether a case has anything of the subject: only then are `checks` (problems)
    and `cautions` (warnings) examined; `last_checks` want a machine without other problems.
    `suspects` has, by the name of a check, a function of a case with arrays which tells the points
    (points,) that the check may refuse, or None where it cannot; a check that has none is made at
    every point of a sweep whose keys it reads.
    `names` gives the entries of axes that the case names, `entries` the numbers of one axis of a
    result, None where only the run can tell. `units` are the pieces of work of its stages.
    `sections` of the report and `pictures` by their names are made where a result has quantities of
    the subject; those of a subject that `leads` stand first in the report. `calculation` names the
    `Calculation` that its page of HTML has the form of; `assumes` says what its models take for
    granted and leave out. `files` names, by the path of a key, what reads the files next to a case
    that stand there: called with the case as written and its folder, it puts numbers in their place
    and returns problems.
    """

    stages: "tuple[Callable[[Case], Iterator[Stage]], ...]"
    concerns: "Callable[[Case], bool]"
    units: Mapping[str, Unit]
    checks: tuple[str, ...] = ()
    last_checks: tuple[str, ...] = ()
    suspects: Mapping[str, str] = {}
    cautions: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()
    pictures: Mapping[str, str] = {}
    leads: bool = False
    names: "Callable[[Case, str], dict[str, tuple[str, ...]]]" = lambda case, path: {}
    entries: "Callable[[Case, str, str], Entries | None]" = lambda case, path, axis: None
    calculation: str = ""
    assumes: tuple[str, ...] = ()
    files: Mapping[KeyPath, str] = {}


@lru_cache(maxsize=1)
def subjects() -> dict[str, Subject]:
    """Every subject by its name, in the order in which their stages run."""
    return {name: named(f"vibecalc.{name}.stage:SUBJECT") for name in SUBJECTS}


def subjects_of(record: Record) -> list[Subject]:
    """The subjects that a record has quantities of."""
    there = {OWNER[path] for path in record if path in OWNER}
    return [subject for name, subject in subjects().items() if name in there]


# ----------------------------------------------------------------------------
# A run in progress: the case, its machine and what the stages have made so far.
# ----------------------------------------------------------------------------


@dataclass(kw_only=True, repr=False, eq=False)
class Scene:
    """What stages read and write; `handed_on` holds what one stage leaves for the next.

    `wanted` names the results to keep, None all of them. `maker` has what runs before this one have
    made by `once`, `keeper` what they have made of arrays by `again`.
    """

    case: "Case"
    parts: "MachineParts"
    wanted: frozenset[str] | None = None
    record: Record = field(default_factory=Record)
    handed_on: dict[str, Any] = field(default_factory=dict)
    maker: "Callable[[str, Callable[[Case], Any]], Any] | None" = None
    keeper: "Callable[[str, Sequence[Any], Callable[[], Any]], Any] | None" = None

    def once(self, name: str, make: "Callable[[Case], Any]") -> Any:
        """What several stages need, made of the case by the first that asks for it."""
        if self.maker is not None:
            return self.maker(name, make)
        if name not in self.handed_on:
            self.handed_on[name] = make(self.case)
        return self.handed_on[name]

    def again(self, name: str, inputs: Sequence[Any], make: Callable[[], Any]) -> Any:
        """What `make` makes of arrays and numbers, kept from the second run on that has the same.

        None in the first, and where no other run is known: what takes longer than doing without,
        and pays where many runs have it in common. `inputs` must be all that `make` uses.
        """
        return None if self.keeper is None else self.keeper(name, inputs, make)

    def wants(self, *paths: str) -> bool:
        """Whether any of these results is asked for; a study asks for a few, a run for all."""
        return self.wanted is None or not self.wanted.isdisjoint(paths)

    def emit(
        self,
        path: str,
        values: Any,
        error: Any = 0.0,
        axes: Mapping[str, Any] | None = None,
        standard_error: float | None = None,
        terms: Any = 0.0,
    ) -> None:
        """Put one result into the record, with what the catalogue says of it.

        `values` may be a `Bounded`, which has its error with it. `error` and `terms` are absolute,
        numbers or arrays; the largest counts, and of a short array each entry keeps its own error.
        A value that is not a number is a failure here, at
        its source; an infinite one stands for an unbounded peak, where that of a `Bounded` is left
        out.
        """
        if not self.wants(path):
            return
        entry = CATALOGUE[path]
        given = axes or {}
        if isinstance(values, Bounded):
            values, error = values.value, np.where(np.isfinite(values.value), values.error, 0.0)
        values = np.asarray(values)
        if np.isnan(values).any():
            raise NumericalFailure(f"{path} ({entry.long_name}) has no defined value in this case")
        finite_errors = np.asarray(error, dtype=float)
        estimate = float(np.max(finite_errors)) if finite_errors.size else 0.0
        own = values.shape == finite_errors.shape and 1 < values.size <= _ENTRIES_WITH_ERRORS
        own = own and bool(np.any(finite_errors != estimate))
        self.record.add(
            entry.quantity(
                values,
                estimate,
                tuple(self._axis(name, given[name]) for name in entry.axes),
                standard_error=standard_error,
                terms=float(np.max(terms)),
                errors=finite_errors if own else None,
            )
        )

    def emit_all(
        self, group: Group | Mapping[str, Any], axes: Mapping[str, Any] | None = None
    ) -> None:
        """Put the results of a group, or by path, into the record, with their axes among these.

        A value is an array, a `Bounded`, or a `Summed` with the size of its terms; or a function
        without arguments that gives one, which is called where its result is asked for.
        """
        for path, value in group.items() if isinstance(group, Mapping) else given_in(group):
            if callable(value):
                if not self.wants(path):
                    continue
                value = value()
            if isinstance(value, Summed):
                self.emit(path, value.value, value.error, axes, terms=value.terms)
            else:
                self.emit(path, value, axes=axes)

    def cite(self, name: str, purpose: str, citation: str) -> None:
        """Name a method that took part, once."""
        method = Method(name=name, purpose=purpose, citation=citation)
        if method not in self.record.methods:
            self.record.methods.append(method)

    def warn(self, message: str) -> None:
        """Keep a warning for the report, once."""
        if message not in self.record.warnings:
            self.record.warnings.append(message)

    def _axis(self, name: str, values: Sequence[Any] | np.ndarray) -> Axis:
        unit, long_name = AXES[name]
        array = np.asarray(values)
        if array.dtype.kind in "US":
            array = array.astype(object)
        return Axis(name=name, values=array, unit=unit, long_name=long_name)
