"""Holds what finished runs took against what `vibecalc check` says of their cases.

    python tests/needs/check_needs.py outputs/golden/*.h5

Each result has to come from a process of its own, as `make golden` makes them: the modules that a
process has imported stand under /provenance. Compared are the modules and libraries, the stages
and the harmonics; exit code 1 and a table where something differs.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

from vibecalc.case.schema import Case
from vibecalc.pipeline.needs import (
    FRAME,
    OUTSIDE,
    Needs,
    StageNeeds,
    foreign,
    modules_needed,
    needs_of,
    own,
)
from vibecalc.results.record import Result
from vibecalc.results.store import read_result
from vibecalc.study.load import load_checked

CASES = Path(__file__).resolve().parents[2] / "cases"
AXES = ("order", "half_order")
#: libraries that reading and writing bring in, whatever the case computes
OF_FILES = ("h5py", "pint", "rich")


def differences(case: Case, result: Result) -> list[tuple[str, str]]:
    """(what, how it differs) of one run."""
    needs = needs_of(case)
    return [*module_differences(case, result), *stage_differences(needs, result)]


def module_differences(case: Case, result: Result) -> Iterator[tuple[str, str]]:
    """Modules and libraries imported but not foreseen, or foreseen but not imported."""
    roots = tuple(f"vibecalc.pipeline.stages.{s.plan.module}" for s in needs_of(case).stages)
    sure, perhaps = modules_needed(case, (*FRAME, *roots))
    texts = (str(result.provenance.get(key, "")).split() for key in ("modules", "libraries"))
    modules, libraries = (set(names) for names in texts)
    found = {name for name in modules if name.split(".")[0] not in (*OUTSIDE, "__main__")}
    yield from _sets("module", found, set(own(sure)), set(own(perhaps)))
    # a part of scipy brings in others, and which depends on its version
    scipy = {"scipy"} if any(name.startswith("scipy.") for name in libraries) else set()
    heavy = {name for name in libraries if not name.startswith("scipy.")} - set(OF_FILES)
    yield from _sets("library", heavy | scipy, _roots(foreign(sure)), _roots(foreign(perhaps)))


def stage_differences(needs: Needs, result: Result) -> Iterator[tuple[str, str]]:
    """Stages and harmonics of a result against what was said of them."""
    said = [stage.plan.stage for stage in needs.stages]
    ran = [name for name in result.timings if name in said]
    if ran != said:
        yield "stages", f"said {', '.join(said)}; ran {', '.join(ran)}"
    for stage in needs.stages:
        if stage.harmonics is None:
            continue
        number, highest = harmonics_found(stage, result)
        harmonics = stage.harmonics
        if harmonics.is_least and number >= harmonics.number and highest >= harmonics.highest:
            continue
        if number and (number, highest) != (harmonics.number, harmonics.highest):
            yield (
                f"harmonics of {stage.plan.stage}",
                (f"said {harmonics.words()}; computed {number}, the highest {highest:g}"),
            )


def harmonics_found(stage: StageNeeds, result: Result) -> tuple[int, float]:
    """Number and highest of the orders of a stage's results, the mean apart; 0 without any."""
    longest = (0, 0.0)
    for path in stage.plan.quantities:
        quantity = result.record.quantities.get(path)
        for axis in () if quantity is None else quantity.axes:
            if axis.name in AXES:
                orders = [float(order) for order in axis.values if order]
                longest = max(longest, (len(orders), max(orders, default=0.0)))
    return longest


def _sets(
    what: str, found: set[str], sure: set[str], perhaps: set[str]
) -> Iterator[tuple[str, str]]:
    for name in sorted(found - sure - perhaps):
        yield what, f"{name} imported, not said"
    for name in sorted(sure - found):
        yield what, f"{name} said, not imported"


def _roots(libraries: tuple[str, ...]) -> set[str]:
    return {name.split(".")[0] for name in libraries}


def main(paths: list[str]) -> int:
    rows: list[tuple[str, str, str]] = []
    read = 0
    for path in map(Path, paths):
        source = CASES / f"{path.stem}.toml"
        if not source.is_file():  # the stacked file of a sweep
            continue
        (loaded,) = load_checked([source])
        read += 1
        rows += [(path.stem, *row) for row in differences(loaded.case, read_result(path))]
    wide = [max((len(row[place]) for row in rows), default=0) for place in (0, 1)]
    for name, what, how in rows:
        print(f"{name:{wide[0]}}  {what:{wide[1]}}  {how}")
    print(f"needs: {read} runs, {len(rows)} differences from what `vibecalc check` says")
    return 1 if rows or not read else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
