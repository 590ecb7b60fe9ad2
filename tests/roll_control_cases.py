"""Cases with a controlled motor, run with some keys changed."""

from copy import deepcopy
from functools import cache
from typing import Any

from shipped_cases import CASES, result_of

from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import case_at
from vibecalc.core.results.record import Record, Result
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.schema import Case

PATH = "response/control/"
#: studies left out, references too: what is asked is asked by the test
BARE = ("reference=[]", "reference_table=[]")
#: a key of the control and its value that leaves it out
NO_STUDIES = {
    "response.control.motor_gains": [],
    "response.control.gains": [],
    "response.control.feedbacks": [],
    "response.control.tune": None,
    "response.control.full_model": False,
}


@cache
def _resolved() -> dict[str, Any]:
    (loaded,) = load_checked([CASES["roll_control"]], BARE)
    return loaded.resolved


def case_of(*, studies: bool = False, **settings: Any) -> Case:
    """The shipped case; a setting is a key of [response.control], or with `__` of the machine."""
    changed: dict[str, Any] = {} if studies else dict(NO_STUDIES)
    for key, value in settings.items():
        name = key.replace("__", ".")
        changed[name if "." in name else f"response.control.{name}"] = value
    dropped = [key for key, value in changed.items() if value is None]
    kept = {key: value for key, value in changed.items() if value is not None}
    table = deepcopy(case_at(_resolved(), kept))
    for key in dropped:
        *above, last = key.split(".")
        place = table
        for name in above:
            place = place[name]
        place.pop(last, None)
    return validate(table)


def record_of(*, studies: bool = False, **settings: Any) -> Record:
    """Results of such a case."""
    return run_case(case_of(studies=studies, **settings))


def value_of(record: Record, name: str) -> Any:
    """Values below the root of the stage."""
    return record[PATH + name].values


@cache
def shipped(*settings: str) -> Result:
    """The shipped case with all its studies; with settings, a run of it without them."""
    if not settings:
        return result_of("roll_control")
    (loaded,) = load_checked([CASES["roll_control"]], (*BARE, *settings))
    return execute(loaded)
