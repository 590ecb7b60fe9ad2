"""What the frame and a stage agree on: its row of the plan, and the run in progress."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.results.catalogue import AXES, CATALOGUE
from vibecalc.core.results.record import Axis, Method, Quantity, Record
from vibecalc.errors import NumericalFailure
from vibecalc.parts.firing import shakes_with_torque

if TYPE_CHECKING:
    from vibecalc.parts.machine import MachineParts
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# What a plan says of one stage.
# ----------------------------------------------------------------------------


class StagePlan(NamedTuple):
    """One stage of a run: its adapter, why it is there, what it reads and what it will make.

    `adapter` names the function that runs it as `package.module:function`; `is_last` marks a stage
    that no later one reads from.
    """

    stage: str
    adapter: str
    why: str
    parts: tuple[str, ...]
    orders: str
    cost: str
    quantities: tuple[str, ...]
    is_last: bool = False

    def as_texts(self) -> dict[str, str]:
        """The plan of this stage as short texts, for reports."""
        return {
            "stage": self.stage,
            "why": self.why,
            "parts": ", ".join(self.parts),
            "orders": self.orders,
            "cost": self.cost,
            "quantities": ", ".join(self.quantities),
        }


@lru_cache(maxsize=64)
def below(prefix: str, without: tuple[str, ...] = ()) -> tuple[str, ...]:
    return tuple(
        path
        for path in CATALOGUE
        if path.startswith(prefix) and not any(word in path for word in without)
    )


def orders_words(case: "Case") -> str:
    if case.excitation and case.excitation.orders:
        return f"1 to {case.excitation.orders}, as the case asks"
    if case.kinematics and case.kinematics.series == "truncated":
        last = (4 if shakes_with_torque(case) else 2) * (case.kinematics.terms or 1)
        return f"1 to {last}, all of the truncated series"
    return f"until the rest is below rtol = {case.accuracy.rtol:g}"


# ----------------------------------------------------------------------------
# A run in progress: the case, its machine and what the stages have made so far.
# ----------------------------------------------------------------------------


@dataclass(kw_only=True)
class Scene:
    """What stages read and write; `handed_on` holds what one stage leaves for the next.

    `wanted` names the results to keep, None all of them. `maker` has what runs before this one have
    made by `once`.
    """

    case: "Case"
    parts: "MachineParts"
    wanted: frozenset[str] | None = None
    record: Record = field(default_factory=Record)
    handed_on: dict[str, Any] = field(default_factory=dict)
    maker: "Callable[[str, Callable[[Case], Any]], Any] | None" = None

    def once(self, name: str, make: "Callable[[Case], Any]") -> Any:
        """What several stages need, made of the case by the first that asks for it."""
        if self.maker is not None:
            return self.maker(name, make)
        if name not in self.handed_on:
            self.handed_on[name] = make(self.case)
        return self.handed_on[name]

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

        `error` and `terms` are absolute, numbers or arrays; the largest counts. A value that is not
        a number is a failure here, at its source; an infinite one stands for an unbounded peak.
        """
        if not self.wants(path):
            return
        entry = CATALOGUE[path]
        given = axes or {}
        values = np.asarray(values)
        if np.isnan(values).any():
            raise NumericalFailure(f"{path} ({entry.long_name}) has no defined value in this case")
        finite_errors = np.asarray(error, dtype=float)
        estimate = float(np.max(finite_errors)) if finite_errors.size else 0.0
        self.record.add(
            Quantity(
                path=path,
                values=values,
                unit=entry.unit,
                long_name=entry.long_name,
                axes=tuple(self._axis(name, given[name]) for name in entry.axes),
                amplitude=entry.amplitude,
                error_estimate=estimate,
                standard_error=standard_error,
                terms=float(np.max(terms)),
            )
        )

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
