"""What [optimisation] picks from: values, whole numbers and stocks, each as a list of options."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from vibecalc.core.case.raw import field_unit, parse_key
from vibecalc.core.case.search_checks import read_choice, whole_numbers
from vibecalc.core.case.walk import shape_at
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.core.case.study_tables import Optimisation, Stock, Variable

# ----------------------------------------------------------------------------
# Choices and combinations of their options.
# ----------------------------------------------------------------------------

#: runs of the machine that a search from one start takes, with three variables and more
SEARCH_RUNS = 50
#: runs up to which all combinations are examined
MOST_RUNS = 50_000


class Option(NamedTuple):
    """One thing that can be picked: its name in tables, and the keys that it sets, in SI."""

    label: str
    settings: Mapping[str, Any]


class Choice(NamedTuple):
    """A key, or several together, of which one option is picked.

    `path` is that of the result below `optimisation/`: of a number its value, else the number of
    the option, counted from 1. `ordered`: options next to each other are alike.
    """

    name: str
    path: str
    options: tuple[Option, ...]
    ordered: bool

    @property
    def is_number(self) -> bool:
        """Whether the result is the value itself."""
        return self.path.startswith("variable/")

    def value(self, place: int) -> float:
        """What the result holds where the option at `place` is picked."""
        return float(self.options[place].settings[self.name]) if self.is_number else place + 1.0


def choices_of(study: "Optimisation") -> tuple[Choice, ...]:
    """All choices of an optimisation: those of variables, then the stocks."""
    picked = (_of_variable(one) for one in study.variables if not one.moves)
    return (*picked, *map(_of_stock, study.stock))


def combinations(choices: tuple[Choice, ...]) -> int:
    """How many combinations of options there are."""
    return math.prod(len(choice.options) for choice in choices)


def runs_of_one(study: "Optimisation") -> int:
    """Runs that one combination is likely to take."""
    moving = len(study.moving)
    return (study.starts + 1) * min(SEARCH_RUNS, 10 + 15 * moving) if moving else 1


def examines_all(study: "Optimisation", choices: tuple[Choice, ...]) -> bool:
    """Whether every combination is examined."""
    return combinations(choices) * runs_of_one(study) <= MOST_RUNS


def ends_of(variable: "Variable") -> tuple[float, float]:
    """Its bounds in SI, 0 for one that it has not."""
    unit = field_unit(variable.key)
    return parse_quantity(variable.lower or 0.0, unit), parse_quantity(variable.upper or 0.0, unit)


def ties_of(variable: "Variable") -> list[tuple[str, float, float]]:
    """Keys that follow it, each a factor times it and an offset in SI."""
    return [
        (tie.key, tie.factor, parse_quantity(tie.offset or 0.0, field_unit(tie.key)))
        for tie in variable.follow
    ]


def _of_variable(variable: "Variable") -> Choice:
    shape = shape_at(parse_key(variable.key))
    assert shape is not None
    given = variable.choices or whole_numbers(*ends_of(variable))
    values = [(str(one), read_choice(one, shape)) for one in given]
    is_name = shape.kind == "choice"
    if not is_name:
        values.sort(key=lambda one: float(one[1]))
    options = []
    for label, value in values:
        follow = {key: factor * float(value) + more for key, factor, more in ties_of(variable)}
        options.append(Option(label, {variable.key: value, **follow}))
    path = f"{'choice' if is_name else 'variable'}/{variable.key}"
    return Choice(variable.key, path, tuple(options), not is_name)


def _of_stock(stock: "Stock") -> Choice:
    options = []
    for item in stock.items:
        settings = {}
        for table in (stock.table, *stock.also):
            for key, value in item.values.items():
                shape = shape_at(parse_key(f"{table}.{key}"))
                assert shape is not None
                settings[f"{table}.{key}"] = read_choice(value, shape)
        options.append(Option(item.name, settings))
    return Choice(stock.name, f"choice/{stock.name}", tuple(options), False)


def in_words(choices: tuple[Choice, ...], picked: tuple[int, ...]) -> str:
    """A combination as tables name it: the labels of what is picked."""
    return ", ".join(
        choice.options[place].label for choice, place in zip(choices, picked, strict=True)
    )
