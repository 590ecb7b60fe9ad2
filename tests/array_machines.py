"""Cases with every key that arrays can vary, and arrays of them held against single runs."""

import json
from collections.abc import Mapping
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from fuzzing import leaves
from shipped_cases import CASES
from sweep_blocks import quantities

from vibecalc.core.case.load import LoadedCase, load_case, resolve, validate
from vibecalc.core.case.raw import NOT_COMPUTED, get_key, parse_key, set_key
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.results.layout import DONE
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.study.sweep.at_once import unsupported
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.core.study.sweep.design import Design, make_design
from vibecalc.core.study.sweep.evaluate import ArrayEvaluator, Evaluator, Quantities
from vibecalc.errors import KeyPath

#: tables put in place of those of the shipped generator, or of another `case`
CHANGES: dict[str, dict[str, Any]] = json.loads(
    Path(__file__).with_suffix(".json").read_text(encoding="utf-8")
)


@cache
def machine(name: str) -> LoadedCase:
    """One of the cases, as if read from a file."""
    changes = dict(CHANGES[name])
    loaded = load_case(CASES[str(changes.pop("case", "generator"))])
    own = changes.pop("own", False)
    tables = changed(loaded, changes)
    if own:
        for cylinder in tables["machine"]["crank_train"]["cylinders"][:2]:
            cylinder |= {"reciprocating_mass": 0.6, "rotating_mass": 0.1}
    return as_read(loaded, tables)


def changed(loaded: LoadedCase, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Tables of a case with other values by key; those of None are left out."""
    tables = deepcopy({k: v for k, v in loaded.resolved.items() if k not in NOT_COMPUTED})
    for key, value in changes.items():
        path = parse_key(key)
        if value is not None:
            set_key(tables, key, value)
        else:
            above = get_key(tables, path[:-1]) if path[:-1] else tables
            above.pop(path[-1], None)
    return tables


def as_read(loaded: LoadedCase, tables: dict[str, Any]) -> LoadedCase:
    """Tables in place of those of a file."""
    case = validate(tables)
    return LoadedCase(
        case=case, name=loaded.name, path=loaded.path, text="", overrides=(),
        resolved=resolve(case), resolved_toml="", sha256="",
    )  # fmt: skip


# ----------------------------------------------------------------------------
# Arrays and single runs.
# ----------------------------------------------------------------------------


class Counting(ArrayEvaluator):
    """Counts the points that a single run has done."""

    alone = 0

    def run_point(self, settings: Mapping[str, Any]) -> tuple[int, str, Quantities]:
        status, message, found = super().run_point(settings)
        self.alone += status == DONE
        return status, message, found


def paths_of(loaded: LoadedCase) -> tuple[str, ...]:
    """All results of a case that arrays can give."""
    case = loaded.case
    return tuple(p for p in planned_quantities(case) if unsupported(case, [], [p]) is None)


def keys_of(loaded: LoadedCase) -> tuple[KeyPath, ...]:
    """All numbers of a case that arrays can vary for these results."""
    paths, every = paths_of(loaded), leaves(loaded.resolved)
    return tuple(key for key in every if unsupported(loaded.case, [key], paths) is None)


def designed(loaded: LoadedCase, axes: list[dict[str, Any]], **more: Any) -> Design:
    return make_design(Sweep.model_validate({"axes": axes, **more}), loaded.resolved)


def hold(
    loaded: LoadedCase,
    design: Design,
    paths: tuple[str, ...],
    fewest: int,
    generous: float | None = 1.5,
) -> Block:
    """Hold arrays against single runs at all points; at least `fewest` come from arrays.

    Estimates of arrays are at most `generous` times those of single runs; None: any.
    """
    every = np.arange(design.count)
    by_arrays = Counting(loaded, design, paths)
    together, alone = by_arrays(every), Evaluator(loaded, design, paths)(every)
    assert together.status.tolist() == alone.status.tolist()
    assert together.message == alone.message
    done = alone.status == DONE
    assert done.sum() - by_arrays.alone >= fewest
    for path, single in quantities(alone).items():
        found = quantities(together)[path]
        assert (found.unit, found.long_name) == (single.unit, single.long_name)
        assert found.amplitude == single.amplitude
        assert [a.name for a in found.axes] == [a.name for a in single.axes]
        for axis, other in zip(found.axes, single.axes, strict=True):
            assert axis.values.tolist() == other.values.tolist()
            assert (axis.unit, axis.long_name) == (other.unit, other.long_name)
        assert np.isnan(found.values[~done]).all() and np.isnan(found.errors[~done]).all()
        same = found.values == single.values  # also where both are infinite
        one, two = (np.where(same, 0.0, part.values) for part in (found, single))
        apart = np.abs(one - two)[done].reshape(int(done.sum()), -1)
        uncertainty = (found.errors + single.errors)[done]
        assert (apart <= uncertainty[:, None]).all(), (path, apart.max(), uncertainty)
        if generous is not None:
            assert (found.errors[done] <= generous * single.errors[done] + 1e-300).all(), path
    return together
