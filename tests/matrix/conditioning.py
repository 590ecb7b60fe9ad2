"""How far each quantity of a case moves when its inputs move a little.

Every number of a case that is not a count, a label, a setting of a method or a published value is
multiplied by one plus a small random number, the case is run again, and the two results are
compared as `vibecalc diff` does it, with error estimates left out. The change of a quantity, on
the scale that `diff` takes its tolerance of, over the change of the inputs is its condition
number. Two sizes of perturbation tell a smooth answer, which moves in proportion, from one that
jumps because a search or a march took another step.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vibecalc.core.case.load import LoadedCase, resolve, validate
from vibecalc.core.results.compare import compare
from vibecalc.core.results.compare_rules import Rule, Rules
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.core.study.execute import execute

#: relative sizes of the perturbations: one well above round-off, one of some last digits
LARGE, SMALL = 1e-10, 1e-14
EPS = float(np.finfo(float).eps)
#: a condition number this many times larger at the small perturbation is a jump or round-off
JUMP = 30.0
#: root of the number of operations behind an entry, 1e4 of them: how far round-off walks
LENGTH = 100.0
SAFETY = 3.0
#: an estimate this large a part of the whole quantity: it is zero but for round-off
NO_DIGITS = 1e-2
#: an entry of fewer error estimates: of its change the estimate decides, not the default tolerance
DIGITS = 2e9
#: how much larger than demanded a tolerance may be
ROOM = 1e4

#: tables and keys that are not inputs of the physics, and the exponents of laws: what goes with the
#: square of the speed has an exact form, and is refused with any other power in a change of speed
_KEPT = {
    *("schema", "accuracy", "reference", "reference_table", "limit", "sweep", "find"),
    *("optimisation", "run_up", "speeds", "orders", "from", "to", "span", "steps", "points"),
    *("samples", "seed", "where", "curves", "range", "repeat", "box", "design_factor"),
    "exponent",
}
#: rtol of the comparison; small enough that no limit of `diff` cuts in
_UNIT = 1e-6


@dataclass(frozen=True)
class Conditioning:
    """What was measured of one quantity; all relative to the scale of the comparison.

    `condition` is from the large perturbation, `jump` the change under the small one where that
    is not in proportion (zero elsewhere), `estimate` the error estimate stored with the quantity.
    `problem` says what is not a number: an axis with other labels, a quantity that went.
    """

    path: str
    condition: float
    jump: float
    estimate: float
    problem: str = ""

    @property
    def demanded(self) -> float:
        """The change to be expected of another machine, times a safety factor."""
        return SAFETY * max(max(self.condition, 1.0) * EPS * LENGTH, self.jump)

    @property
    def least(self) -> float:
        """The smallest honest rtol: `diff` adds the estimates of both results to what it allows."""
        if self.estimate > NO_DIGITS:
            return 0.0
        return max(self.demanded - 2.0 * self.estimate, 0.0)

    @property
    def most(self) -> float:
        """The largest rtol that still says something."""
        return ROOM * max(self.demanded, SAFETY * self.estimate)


def perturbed(loaded: LoadedCase, size: float, seed: int) -> LoadedCase:
    """The case with every input multiplied by one plus up to `size`; counts and names stay."""
    generator = np.random.default_rng(seed)
    table = moved(loaded.resolved, size, generator)
    case = validate(table)
    return replace(loaded, case=case, resolved=resolve(case))


def moved(value: Any, size: float, generator: np.random.Generator) -> Any:
    """A table of a case with every input multiplied by one plus up to `size`."""
    if isinstance(value, dict):
        return {
            key: entry if key in _KEPT else moved(entry, size, generator)
            for key, entry in value.items()
        }
    if _is_symmetric(value):
        entries = np.array(value, dtype=float)
        entries *= 1.0 + size * generator.uniform(-1.0, 1.0, entries.shape)
        return (np.triu(entries) + np.triu(entries, 1).T).tolist()
    if isinstance(value, list | tuple):
        return [moved(entry, size, generator) for entry in value]
    if isinstance(value, float):
        return value * (1.0 + size * float(generator.uniform(-1.0, 1.0)))
    return value


def _is_symmetric(value: Any) -> bool:
    """A square table of numbers, the same on both sides of its diagonal: it has to stay so."""
    if not isinstance(value, list | tuple) or len(value) < 2:
        return False
    rows = all(isinstance(row, list | tuple) and len(row) == len(value) for row in value)
    if not rows or not all(isinstance(entry, int | float) for row in value for entry in row):
        return False
    return bool(np.array_equal(np.array(value), np.array(value).T))


def measured(loaded: LoadedCase, start: Result, seeds: tuple[int, ...]) -> list[Conditioning]:
    """Conditioning of every quantity of `start`, the result of `loaded`; worst of all seeds."""
    large: dict[str, float] = {}
    small: dict[str, float] = {}
    words: dict[str, str] = {}
    for size, worst in ((LARGE, large), (SMALL, small)):
        for seed in seeds:
            other = execute(perturbed(loaded, size, seed))
            for path, change, problem in changes(start.record, other.record):
                worst[path] = max(worst.get(path, 0.0), change)
                if problem and size == SMALL:
                    words[path] = problem
    found = []
    for path, quantity in start.record.items():
        condition = large.get(path, 0.0) / LARGE
        jumps = small.get(path, 0.0) > JUMP * SMALL * max(condition, 1.0)
        jump = small[path] if jumps else 0.0
        found.append(Conditioning(path, condition, jump, estimate(quantity), words.get(path, "")))
    return found


def changes(one: Record, other: Record) -> Iterator[tuple[str, float, str]]:
    """Path, largest change over the scale of the comparison, and what has no number.

    Entries of which few digits are known, such as orders that vanish by symmetry but for round-off,
    have a scale of their own that says nothing: `diff` allows them the error estimates, which are
    left out here, and so are they.
    """
    rules = Rules(
        default=Rule(rtol=_UNIT, nan_equal=True),
        rules=(Rule(quantity="*/run_up", compare="curve"),),
    )
    for row in compare(_bare(_known(one, one)), _bare(_known(other, one)), rules).rows:
        ratio = row.ratio if np.isfinite(row.ratio) else 1.0 / _UNIT
        yield row.path, ratio * _UNIT, "; ".join(row.problems)


def _known(record: Record, start: Record) -> Record:
    """The record with zeros where few digits of `start` are known."""
    return Record(
        quantities={path: _known_digits(one, start.get(path)) for path, one in record.items()}
    )


def _known_digits(one: Quantity, start: Quantity | None) -> Quantity:
    values = one.values
    if start is None or start.values.shape != values.shape or values.dtype.kind not in "fc":
        return one
    return replace(
        one, values=np.where(abs(start.values) <= DIGITS * start.error_estimate, 0, values)
    )


def _bare(record: Record) -> Result:
    """The record as a result, without its estimates."""
    quantities = {
        path: replace(quantity, error_estimate=0.0, standard_error=None, terms=0.0)
        for path, quantity in record.items()
    }
    return Result(
        name="",
        case={},
        case_toml="",
        case_toml_resolved="",
        case_sha256="",
        record=Record(quantities=quantities),
        version="",
        verdicts=(),
    )


def estimate(quantity: Quantity) -> float:
    """Error estimate, and four standard errors, over the largest entry; zero for names."""
    if quantity.values.dtype.kind not in "biufc" or not quantity.values.size:
        return 0.0
    sizes = np.abs(quantity.values)
    scale = float(sizes[np.isfinite(sizes)].max(initial=0.0))
    error = quantity.error_estimate + 4.0 * (quantity.standard_error or 0.0)
    return error / scale if scale > 0.0 and np.isfinite(error) else 0.0
