"""Claim: rings hung on a line that is solved without them are those of the whole, by arrays too.

Against whole runs and single runs: within both error estimates, for every number of a ring that
arrays can vary, alone and all at once.
"""

from copy import deepcopy
from functools import cache

import numpy as np
import pytest
from array_machines import as_read, changed, designed, hold
from long_but import long_but
from shipped_cases import CASES
from sweep_blocks import quantities
from torsion_lines import ring_on

from vibecalc.core.case.load import LoadedCase, load_case, validate
from vibecalc.core.case.raw import NOT_COMPUTED, parse_key, set_key
from vibecalc.core.results.layout import DONE
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import StageCache, checked_case, run_case
from vibecalc.core.study.sweep.at_once import compute, pattern, unsupported
from vibecalc.torsion.adapters.largest_alone import bare_line, hung, ring_stiffness
from vibecalc.torsion.asked import RING_KEYS, TOGETHER
from vibecalc.torsion.line import Line

RING = "machine.shaft_line.dampers[0]"
ROOT = "response/torsion"


def test_a_ring_where_the_bare_line_has_no_response() -> None:
    """On a resonance of the bare line, which nothing damps, no answer is claimed."""
    line = Line(*(np.array(one) for one in (
        [1.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0], [1], [1e4], [0.0], [0.0],
    )))  # fmt: skip
    w = np.array([[np.sqrt(2e4), 50.0]])
    bare = bare_line(line, w, np.ones((1, 2, 1), complex), np.array([0]), 0)
    pull, _ = ring_stiffness(ring_on(line, 0, (1.0, 100.0, 3.0, 0.0)), 1, w)
    found = hung(bare, pull)
    assert not found.error[0, 0] <= 1e-6 * abs(found.angle[0, 0])
    assert found.error[0, 1] <= 1e-12 * abs(found.angle[0, 1])


#: what a study of dampers asks for
WANTED = frozenset(
    f"{ROOT}/{name}"
    for name in (
        *("largest/torque_half_range", "largest/twist_half_range", "largest/speed"),
        *("largest/mode", "largest/order", "reduction", "speeds/heat"),
    )
)


@pytest.mark.parametrize("name", long_but(["engine_damped", "engine_two_stroke"], "engine_damped"))
def test_largest_torques_alone_are_those_of_a_whole_run(name: str) -> None:
    """Over other dampers, the first of them solved as a whole, the others hung on the bare line."""
    loaded = load_case(CASES[name])
    resolved = {key: part for key, part in loaded.resolved.items() if key not in NOT_COMPUTED}
    ring, cache = loaded.case.machine.shaft_line.dampers[0], StageCache()  # type: ignore[union-attr]
    for factor in (1.0, 2.5):
        settings = {f"{RING}.damping": factor * ring.damping}
        if ring.stiffness:
            settings[f"{RING}.stiffness"] = factor * ring.stiffness
        settings["response.torsion.speeds.points"] = 151
        case = checked_case(resolved, settings, cache)
        alone = run_case(case, wanted=WANTED, cache=cache)
        # who asks for a curve gets all that a whole run computes for it
        whole = run_case(case, wanted=WANTED | {f"{ROOT}/speeds/torque_half_range"})
        for path in WANTED:
            one, other = alone[path], whole[path]
            room = one.error_estimate + other.error_estimate
            assert np.all(np.abs(one.values - other.values) <= room), path


#: of each case: ranges of the numbers of its ring, in SI
RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "engine_damped": {
        "inertia": (5.0, 60.0),
        "stiffness": (1e5, 3e6),
        "damping": (200.0, 2e4),
        "loss_factor": (0.0, 0.3),
    },
    "engine_two_stroke": {"inertia": (0.01, 0.5), "damping": (1.0, 200.0)},
    # steps that narrow resonances stand between
    "coarse": {"stiffness": (1e5, 3e6), "damping": (20.0, 2e3)},
}


@cache
def machine(name: str, points: int = 151) -> LoadedCase:
    loaded = load_case(CASES["engine_damped" if name == "coarse" else name])
    points = 41 if name == "coarse" else points
    return as_read(loaded, changed(loaded, {"response.torsion.speeds.points": points}))


def assert_alike(
    loaded: LoadedCase, ranges: dict[str, tuple[float, float]], points: int, seed: int = 1
) -> None:
    axes = [
        {"key": f"{RING}.{key}", "from": low, "to": high} for key, (low, high) in ranges.items()
    ]
    design = designed(loaded, axes, sampling="monte_carlo", points=points, seed=seed)
    keep = tuple(path for path in TOGETHER if path in planned_quantities(loaded.case))
    assert unsupported(loaded.case, [parse_key(key) for key in design.keys], keep) is None
    found = hold(loaded, design, keep, fewest=0, generous=None)
    assert np.all(found.status == DONE)
    for path, one in quantities(found).items():
        # estimates are those of the same formulas at the same speeds
        assert np.all(one.errors <= 1e-9 * np.max(np.abs(one.values))), path


@pytest.mark.parametrize(
    ("name", "key"),
    [
        pytest.param(name, key, marks=[] if key == "all" else pytest.mark.long)
        for name, ranges in RANGES.items()
        for key in [*ranges, "all"]
    ],
)
def test_rings_by_arrays_are_those_of_single_runs(name: str, key: str) -> None:
    ranges = RANGES[name] if key == "all" else {key: RANGES[name][key]}
    assert_alike(machine(name), ranges, 3)


@pytest.mark.long
@pytest.mark.parametrize("name", RANGES)
def test_a_hundred_rings_by_arrays(name: str) -> None:
    assert_alike(machine(name, 300), RANGES[name], 100, seed=7)


def test_every_key_is_varied_here() -> None:
    varied = {pattern(parse_key(f"{RING}.{key}")) for one in RANGES.values() for key in one}
    assert varied == RING_KEYS


def test_rings_that_leave_modes_undamped_run_alone() -> None:
    """Of a line that nothing else damps; over other keys, and for other results, all points do."""
    loaded = machine("engine_damped", 31)
    tables = deepcopy(loaded.resolved)
    for part in ("stations", "shafts"):
        for one in tables["machine"]["shaft_line"][part]:
            one.pop("absolute_damping" if part == "stations" else "damping")
    case = validate(tables)
    key, keep = parse_key(f"{RING}.damping"), frozenset([TOGETHER[0]])
    damping = np.array([0.0, 1e-6, 300.0, 600.0])
    parts, left = compute(case, {key: damping}, 4, keep)
    assert left.tolist() == [0, 1] and [part.places.tolist() for part in parts] == [[2, 3]]
    largest = parts[0].columns[TOGETHER[0]]
    for row, value in enumerate((300.0, 600.0)):
        set_key(tables, f"{RING}.damping", value)
        alone = run_case(validate(tables), wanted=keep)[TOGETHER[0]]
        room = largest.errors[row] + alone.error_estimate
        assert np.all(np.abs(largest.values[row] - alone.values) <= room)
    assert unsupported(case, [key], keep) is None
    assert unsupported(case, [parse_key("machine.crank_train.rod_length")], keep) is not None
    assert unsupported(case, [key], ["response/torsion/torque_half_range"]) is not None
