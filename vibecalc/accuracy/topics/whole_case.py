"""What the tolerance of a case costs: a run at each, with its true and its estimated error."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.accuracy.table import WHOLE_CASE
from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.pipeline.run import run_case

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.results.record import Quantity, Record

#: [accuracy] rtol of the ladder, and what these are held against
TOLERANCES = (1e-3, 1e-6, 1e-9)
FINEST = 1e-12

#: what a run leaves out at its tolerance: no error, but another question at each
_OF_THE_TOLERANCE = frozenset({"kinematics/dropped_acceleration"})


def topics(case: "Case") -> list[Topic]:
    """Two topics: what a run gives, and what it says of itself, at each tolerance.

    All scalar results of a run are one vector, each over its value in the finest run. Left out are
    counts, statistics, what is unbounded, what is zero within its own estimate and what a run
    leaves out at its tolerance.
    """
    finest = run_case(_at(case, FINEST))
    truth = {
        path: float(np.abs(quantity.values))
        for path, quantity in finest.items()
        if _is_told(quantity)
    }
    if not truth:
        return []
    own = case.accuracy.rtol
    coarser = sorted({*TOLERANCES, *([own] if own > FINEST else [])}, reverse=True)
    reference = Reference(
        np.ones(len(truth)),
        _largest_estimate(finest, truth),
        f"the run at rtol = {FINEST:g}, agreement as it estimates itself",
    )
    ladder = Ladder(
        name="run",
        words="the whole run of the case",
        setting="[accuracy] rtol",
        settings=tuple(coarser),
        solve=lambda rtol: Answer(_shares(run_case(_at(case, rtol)), truth), 1.0),
        default=own if own > FINEST else None,
    )
    words = f"{len(truth)} scalar results of a run, each over its value in the finest run"
    topic = Topic(
        stage=WHOLE_CASE,
        name="true error of a run",
        words=words,
        quantity="",
        unit="",
        work="runs",
        reference=lambda: reference,
        ladders=(ladder,),
    )

    def estimated(rtol: float) -> Answer:
        worst = _largest_estimate(run_case(_at(case, rtol)), truth)
        return Answer(np.full(len(truth), 1.0 + worst), 1.0)

    of_itself = ladder._replace(
        settings=tuple(sorted({*coarser, FINEST, own}, reverse=True)), solve=estimated, default=own
    )
    return [
        topic,
        topic._replace(
            name="error that a run estimates",
            words=f"the largest error estimate of these {len(truth)} results, as relative error",
            reference=lambda: reference._replace(agreement=0.0, words="no error at all"),
            ladders=(of_itself,),
        ),
    ]


def _at(case: "Case", rtol: float) -> "Case":
    accuracy = case.accuracy.model_copy(update={"rtol": rtol})
    return case.model_copy(update={"accuracy": accuracy})


def _is_told(quantity: "Quantity") -> bool:
    values = quantity.values
    if quantity.path in _OF_THE_TOLERANCE:
        return False
    if quantity.axes or values.dtype.kind not in "fc" or quantity.standard_error is not None:
        return False
    size = float(np.abs(values))
    return np.isfinite(size) and size > quantity.error_estimate


def _shares(record: "Record", truth: dict[str, float]) -> np.ndarray:
    """Infinite where a run does not have the result at all."""
    return np.array(
        [
            float(np.abs(record[path].values)) / size if path in record else np.inf
            for path, size in truth.items()
        ]
    )


def _largest_estimate(record: "Record", truth: dict[str, float]) -> float:
    shares = (record[path].error_estimate / truth[path] for path in truth if path in record)
    return max(shares, default=np.inf)
