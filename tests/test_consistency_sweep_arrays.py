"""Claim: arrays give what single runs give, within both error estimates, over every key they know.

Where a point fails, status and words are those of a single run.
"""

import random
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from array_machines import CHANGES, designed, hold, keys_of, machine, paths_of
from fuzzing import leaves
from long_but import long_but
from shipped_cases import CASES
from sweep_blocks import quantities

from vibecalc.absorber.stage import PEAKS, TOGETHER
from vibecalc.core.case.load import load_case
from vibecalc.core.case.raw import get_key, parse_key
from vibecalc.core.results.layout import DONE, FAILED, REFUSED
from vibecalc.core.run.columns import PointsScene
from vibecalc.core.run.plan import plan_case, planned_quantities
from vibecalc.core.run.stage import Scene
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.at_once import compute, pattern, unsupported
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.core.study.sweep.checks import UNSHARED_AXES
from vibecalc.core.study.sweep.design import Design
from vibecalc.core.study.sweep.evaluate import Evaluator
from vibecalc.errors import KeyPath, dotted
from vibecalc.isolation.adapters import body

PEAK = "isolation/support_force/steady_peak"


@cache
def known_paths(name: str) -> tuple[str, ...]:
    return paths_of(machine(name))


@cache
def known_keys(name: str) -> tuple[KeyPath, ...]:
    return keys_of(machine(name))


def design_of(name: str, axes: list[dict[str, Any]], **more: Any) -> Design:
    return designed(machine(name), axes, **more)


def scattered(name: str, keys: tuple[KeyPath, ...], points: int, share: float) -> Design:
    """Points spread around the case as written, over all the keys at once."""
    axes = []
    for key in keys:
        value = get_key(machine(name).resolved, key)
        reach = share * abs(value) or 1e-3
        axes.append({"key": dotted(key), "from": value - reach, "to": value + reach})
    return design_of(name, axes, sampling="latin_hypercube", points=points)


def assert_equal(name: str, design: Design, paths: tuple[str, ...], fewest: int = 1) -> Block:
    return hold(machine(name), design, paths, fewest)


def test_the_machines_have_every_key_and_every_result() -> None:
    keys = {pattern(key) for name in CHANGES for key in known_keys(name)}
    paths = {path for name in CHANGES for path in known_paths(name)}
    stages = [stage for name in CHANGES for stage in plan_case(machine(name).case)]
    leading = [stage for stage in stages if stage.leading is not None and not stage.leading.why_not]
    assert keys == set().union(*(stage.leading.keys for stage in leading))
    assert paths == set().union(*(stage.leading.only or stage.quantities for stage in leading))


@pytest.mark.parametrize("name", long_but(CHANGES, "exact"))
def test_all_keys_at_once(name: str) -> None:
    keys = [key for key in known_keys(name) if key[-1] != "wrist_pin_offset" or name == "exact"]
    isolation = machine(name).resolved.get("isolation")
    if (
        isolation and isolation["model"] == "pitch" and isolation.get("lever") is None
    ):  # then equal distances count
        keys = [key for key in keys if key[1] != "mounts" or key[2] != "positions"]
    if name in ("classic", "own masses"):
        keys = [key for key in keys if key[-1] != "rotating_mass"]  # zero in the case, or below it
    assert len(keys) > 16
    # a share of one key may leave no two points alike, and no room beyond a bound
    design = scattered(name, tuple(keys[:16]), 8, 0.1)
    assert_equal(name, design, known_paths(name), fewest=2)
    for start in range(16, len(keys), 16):
        design = scattered(name, tuple(keys[start : start + 16]), 4, 0.1)
        assert_equal(name, design, known_paths(name), fewest=2)


def test_run_ups_of_what_nothing_damps_and_of_double_poles() -> None:
    """Modes that repeat; without damping peaks have no bound, at the critical one poles meet."""
    mass, stiffness = machine("equal mounts").resolved["machine"]["body"]["mass"], 4e4
    critical = 2.0 * float(np.sqrt(stiffness * mass)) / 4.0
    axis = {"key": "machine.mounts.each.damping", "values": [0.0, 0.3, 50.0, critical, 3000.0]}
    path = "isolation/support_force/run_up_peak"
    found = assert_equal("equal mounts", design_of("equal mounts", [axis]), (path,), fewest=3)
    assert np.isinf(quantities(found)[path].values[0]).any()


def test_points_that_keep_different_numbers_of_orders() -> None:
    key = "machine.crank_train.rod_length"
    axis = {"key": key, "from": 0.08, "to": 0.6, "points": 6, "spacing": "log"}
    block = assert_equal("exact", design_of("exact", [axis]), known_paths("exact"), fewest=5)
    force = quantities(block)["excitation/force"]
    kept = [int(np.flatnonzero(np.abs(row).sum(1))[-1]) for row in force.values]
    assert len(set(kept)) > 3 and sorted(kept, reverse=True) == kept


def test_refusals_and_failures_have_the_words_of_single_runs() -> None:
    free = machine("classic").resolved
    model = Evaluator(
        machine("classic"),
        design_of("classic", [{"key": "machine.speed", "values": [100.0, 200.0]}]),
        ("isolation/pitch/natural_frequency",),
    )(np.arange(1))
    natural = float(quantities(model)["isolation/pitch/natural_frequency"].values[0])
    axes = [
        {"key": "machine.crank_train.rod_length", "values": [0.05, 0.06, 0.0601, 0.2]},
        {"key": "machine.mounts.each.damping", "values": [0.0, 50.0]},
        {"key": "machine.speed", "values": [natural, 1.5 * natural, natural * (1.0 + 1e-13)]},
        {"key": "machine.body.mass", "values": [0.9, free["machine"]["body"]["mass"]]},
    ]
    paths = (PEAK, "isolation/pitch/angle_peak", "excitation/force")
    block = assert_equal("classic", design_of("classic", axes), paths, fewest=3)
    assert {DONE, REFUSED, FAILED} == set(block.status.tolist())
    words = " ".join(block.message)
    for part in ("connecting rod must be longer", "is on the undamped natural", "weigh more"):
        assert part in words


CYLINDERS = "machine.crank_train.cylinders"


@pytest.mark.parametrize(
    ("name", "key", "values", "path", "part"),
    [
        ("balance_v8", f"{CYLINDERS}[2].position", [-0.05, -0.15], "excitation/force_peak",
         "are at the same place"),
        ("compressor_impact", "machine.speed", [361.0, 0.5],
         "excitation/force_peak", "would take too long"),
        ("absorber", "machine.secondary.mass_ratio", [0.1, 2e4], "tuning/peak",
         "no tuning is found"),
        ("genset_points", f"{CYLINDERS}[2].crank_phase", None, "isolation/modes/shape",
         "not at top dead centre"),
    ],
)  # fmt: skip
def test_checks_of_what_is_not_computed_refuse_points_as_well(
    name: str, key: str, values: list[float] | None, path: str, part: str
) -> None:
    loaded = load_case(CASES[name])
    written = get_key(loaded.resolved, parse_key(key))
    axes = [{"key": key, "values": values or [written, written + 0.1]}]
    found = hold(loaded, designed(loaded, axes), (path,), fewest=0, generous=None)
    assert found.status.tolist() == [DONE, REFUSED] and part in found.message[1]


@pytest.mark.parametrize("name", long_but(sorted(CASES), "generator_180", "balance_i4"))
def test_random_sweeps_of_shipped_cases(name: str) -> None:
    loaded, draw = load_case(CASES[name]), random.Random(name)
    case = loaded.case
    paths = [
        path
        for path, entry in planned_quantities(case).items()
        if unsupported(case, [], [path]) is None and not set(UNSHARED_AXES) & set(entry.axes)
    ]
    if not paths:
        pytest.skip("arrays give no result of this case")
    for _ in range(8):
        some = tuple(draw.sample(paths, min(len(paths), 3)))
        every = leaves(loaded.resolved)
        drawn = draw.sample(every, min(len(every), 25))
        keys = [k for k in drawn if unsupported(case, [k], some) is None]
        axes = []
        for key in draw.sample(keys, min(len(keys), 3)):
            value = get_key(loaded.resolved, key)
            reach = abs(value) * draw.choice([1e-3, 0.1, 0.5, 2.0]) or 0.1
            axes.append({"key": dotted(key), "from": value - reach, "to": value + reach})
        together = [parse_key(axis["key"]) for axis in axes]
        if not axes or unsupported(case, together, some) is not None:
            continue  # no key that was drawn, or each by itself and not these together
        design = designed(loaded, axes, sampling="latin_hypercube", points=5)
        hold(loaded, design, some, fewest=0, generous=None)


@pytest.mark.parametrize(
    ("key", "values", "part"),
    [
        ("machine.body.inertia[1]", [8.0, 0.5, 14.1], "impossible moments"),
        ("machine.body.inertia_products[2]", [0.1, 8.4, 9.0], "impossible"),
        ("machine.mounts.each.stiffness", [0.0, 1e4], "do not restrain the body in pitch"),
        ("machine.mounts.positions[0][0]", [-0.4, -0.5], ""),
        ("machine.speed", [1e-21, 100.0], "too small"),
        ("machine.crank_train.cylinders[0].crank_phase", [1.0, 2e6], "too large"),
        ("machine.crank_train.rod.reciprocating_fraction", [0.0, 1.0], ""),
    ],
)
def test_edges_of_what_is_possible(key: str, values: list[float], part: str) -> None:
    design = design_of("moments", [{"key": key, "values": values}])
    block = assert_equal("moments", design, (PEAK, "excitation/couple"))
    assert part in " ".join(block.message)


def test_arithmetic_that_fails_at_a_point_is_left_to_a_single_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    design = design_of(
        "classic",
        [{"key": "machine.body.mass", "from": 50.0, "to": 90.0, "points": 40}],
    )
    asked: list[int] = []
    run = body.run_isolation

    def failing(scene: Scene) -> None:
        if isinstance(scene, PointsScene):
            asked.append(scene.count)
            if (np.abs(np.asarray(scene.case.machine.body.mass) - 60.0) < 0.6).any():
                raise FloatingPointError("overflow")
        run(scene)

    monkeypatch.setattr(body, "run_isolation", failing)
    block = assert_equal("classic", design, (PEAK,), fewest=30)
    assert (block.status == DONE).all()
    assert len(asked) < 12  # halved until the point stands among few


def test_a_default_that_the_kind_of_a_table_does_not_have_is_left_to_single_runs() -> None:
    case = load_case(CASES["engine_two_stroke"]).case
    damper = ("machine", "shaft_line", "dampers", 0)
    reason = unsupported(
        case, [(*damper, "loss_factor")], ["response/torsion/largest/torque_half_range"]
    )
    assert reason is not None and "not a number in the case as written" in reason
    assert (
        unsupported(case, [(*damper, "damping")], ["response/torsion/largest/torque_half_range"])
        is None
    )


(LOADED,) = load_checked([CASES["absorber_design_chart"]], ("reference=[]", "limit=[]"))
DAMPING, MASS = (
    parse_key(key) for key in ("machine.primary.damping_ratio", "machine.secondary.mass_ratio")
)
KEEP = frozenset(TOGETHER)
UNIT = """
schema = 1
title = "an absorber in units"
[machine]
kind = "absorber"
primary = { mass = "100 kg", natural_frequency = "10 Hz", damping_ratio = 0.01 }
secondary = { mass = "5 kg", linear_stiffness = "17 N/mm", linear_damping = "60 N*s/m" }
[response.absorber]
frequencies = { from = "5 Hz", to = "15 Hz" }
"""


def test_arrays_are_single_runs() -> None:
    axes = [
        {"key": "machine.primary.damping_ratio", "values": [0.0, 0.69]},
        {"key": "machine.secondary.mass_ratio", "values": [0.01, 2.0]},
    ]
    hold(LOADED, designed(LOADED, axes), tuple(TOGETHER), fewest=4, generous=None)


PRIMARY, SECONDARY = "machine.primary.", "machine.secondary."
#: keys that vary, and how much of the value as written each point has
VARIED = {
    "absorber_curves": {f"{SECONDARY}mass_ratio": (1.0, 0.2, 3.0)},
    "unit": {
        f"{PRIMARY}natural_frequency": (0.4, 1.1), f"{PRIMARY}damping_ratio": (0.0, 9.0),
        f"{SECONDARY}linear_stiffness": (0.0, 2.0), f"{SECONDARY}linear_damping": (0.1, 8.0),
    },
}  # fmt: skip


@pytest.mark.parametrize("name", VARIED)
def test_peaks_by_arrays_are_those_of_single_runs(name: str, tmp_path: Path) -> None:
    path = CASES.get(name, tmp_path / "unit.toml")
    if name not in CASES:
        path.write_text(UNIT)
    (loaded,) = load_checked([path], ("reference=[]", "limit=[]"))
    axes = [
        {"key": key, "values": list(get_key(loaded.resolved, parse_key(key)) * np.array(shares))}
        for key, shares in VARIED[name].items()
    ]
    design = designed(loaded, axes)
    assert unsupported(loaded.case, [parse_key(key) for key in design.keys], PEAKS) is None
    hold(loaded, design, tuple(PEAKS), fewest=design.count, generous=1.0 + 1e-6)


def test_points_that_need_words_are_left_to_single_runs() -> None:
    z1, m = np.array([0.1, 0.8, -0.1, 0.1]), np.array([0.1, 0.1, 0.1, np.nan])
    parts, alone = compute(LOADED.case, {DAMPING: z1, MASS: m}, 4, KEEP)
    assert alone.tolist() == [1, 2, 3]
    assert parts[0].places.tolist() == [0]


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("tuning.norm='h2'", "found together"),
        ("tuning.mistuning=[0.1]", "point by point"),
        ("tuning.kind='viscous'", "found together"),
    ],
)
def test_what_arrays_do_not_do(setting: str, words: str) -> None:
    keys = [parse_key("machine.secondary.mass_ratio")]
    assert unsupported(LOADED.case, keys, ["tuning/peak"]) is None
    (other,) = load_checked([CASES["absorber_design_chart"]], (setting, "reference=[]", "limit=[]"))
    assert words in str(unsupported(other.case, keys, ["tuning/peak"]))
