"""A result of `vibecalc accuracy` as its report reads it: topics with their rungs."""

import json
import math
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import ResultError
from vibecalc.results.accuracy_layout import (
    ALGEBRAIC,
    BETWEEN,
    DONE,
    FAILED,
    GEOMETRIC,
    MEASURED,
    TARGETS,
)
from vibecalc.results.record import Result


class RungView(NamedTuple):
    """One method at one setting; `setting` is empty where there is nothing to set.

    `seconds` is None where the rung was not run; errors are infinite where it was not measured,
    and `position` also where the method gives none.
    """

    method: str
    setting: str
    status: int
    cause: str
    work: float
    seconds: float | None
    relative: float
    level: float
    position: float
    is_default: bool
    in_work: bool
    in_seconds: bool

    @property
    def done(self) -> bool:
        """Whether it has an error."""
        return self.status == DONE


class MethodView(NamedTuple):
    """A method: what it is, what it steps, the order it shows, empty if none, and the theory."""

    name: str
    words: str
    setting: str
    shown: str
    theory: str


class TopicView(NamedTuple):
    """A topic. `cheapest_...` have the rung for each of `TARGETS`, None where none reaches it."""

    folder: str
    words: dict[str, str]
    agreement: float
    rungs: tuple[RungView, ...]
    methods: tuple[MethodView, ...]
    cheapest_in_work: tuple[RungView | None, ...]
    cheapest_in_seconds: tuple[RungView | None, ...]
    extra_work: float
    extra_seconds: float

    def of(self, method: str) -> list[RungView]:
        """The rungs of one method, from coarse to fine."""
        return [rung for rung in self.rungs if rung.method == method]

    @property
    def failed(self) -> list[RungView]:
        """Rungs that failed or were not run."""
        return [rung for rung in self.rungs if rung.status != DONE]

    @property
    def failures(self) -> int:
        """How many settings failed."""
        return sum(rung.status == FAILED for rung in self.rungs)


def topics_of(result: Result) -> tuple[TopicView, ...]:
    """All topics in the order they were measured; ResultError for a file that lacks parts."""
    try:
        measured = json.loads(str(result.provenance.get(MEASURED, "{}")))
        return tuple(
            _topic(result, row, dict(measured.get(row["folder"], {})))
            for row in (dict(row) for row in result.plan)
            if "method" not in row
        )
    except (KeyError, IndexError, ValueError, TypeError) as error:
        raise ResultError(
            f"the result of {result.name!r} lacks parts of its accuracy measurement: {error}"
        ) from error


def _topic(result: Result, words: dict[str, str], measured: dict[str, Any]) -> TopicView:
    folder = words["folder"]
    record = result.record
    names = [str(name) for name in record[f"{folder}/work"].axes[0].values]
    count = len(names)
    seconds = measured.get("seconds", [None] * count)
    in_seconds = measured.get("on_front", [0] * count)
    column = {
        name: record[f"{folder}/{name}"].values
        for name in ("status", "cause", "work", "worst_relative", "worst_level", "is_default",
                     "on_front")
    }  # fmt: skip
    away = record.quantities.get(f"{folder}/position_error")
    position = np.full(count, math.inf) if away is None else away.values
    rungs = tuple(
        RungView(
            method=names[i].partition(BETWEEN)[0],
            setting=_shown_setting(names[i].partition(BETWEEN)[2]),
            status=int(column["status"][i]),
            cause=str(column["cause"][i]),
            work=float(column["work"][i]),
            seconds=None if seconds[i] is None else float(seconds[i]),
            relative=float(column["worst_relative"][i]),
            level=float(column["worst_level"][i]),
            position=float(position[i]),
            is_default=bool(column["is_default"][i]),
            in_work=bool(column["on_front"][i]),
            in_seconds=bool(in_seconds[i]),
        )
        for i in range(count)
    )
    extra = measured.get("extra")
    return TopicView(
        folder=folder,
        words=words,
        agreement=float(record[f"{folder}/agreement"].values),
        rungs=rungs,
        methods=_methods(result, folder),
        cheapest_in_work=_picked(rungs, record[f"{folder}/cheapest_in_work"].values.tolist()),
        cheapest_in_seconds=_picked(rungs, measured.get("cheapest", [0] * len(TARGETS))),
        extra_work=float(record[f"{folder}/extra_work"].values),
        extra_seconds=math.inf if extra is None else float(extra),
    )


def _methods(result: Result, folder: str) -> tuple[MethodView, ...]:
    order = result.record[f"{folder}/order"]
    kind = result.record[f"{folder}/order_kind"].values
    rows = {
        row["method"]: row for row in result.plan if "method" in row and row["folder"] == folder
    }
    found = []
    for place, name in enumerate(str(label) for label in order.axes[0].values):
        row, value = rows[name], float(order.values[place])
        shown = {
            ALGEBRAIC: f"order {value:.2f}",
            GEOMETRIC: f"{value:.3g} digits per unit",
        }.get(str(kind[place]), "")
        found.append(MethodView(name, row["why"], row["setting"], shown, row["theory"]))
    return tuple(found)


def _picked(rungs: tuple[RungView, ...], numbers: list[int]) -> tuple[RungView | None, ...]:
    return tuple(rungs[number - 1] if number else None for number in numbers)


def _shown_setting(text: str) -> str:
    return f"{float(text):.6g}" if text else ""
