"""Claim: weights of [balance] leave the least that any within their bounds and places can leave."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.optimize import minimize
from shipped_cases import CASES

from vibecalc.balance.pictures import draw_weights
from vibecalc.balance.weights import Places, Solution, counting, least_residual
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Record
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.numerics.bounded import Bounded

AXIS = np.array([1.0, 0.0, 0.0])
COUNTS = counting((1.0, 0.8, 0.3), 0.15, AXIS)


class Frame(NamedTuple):
    """What is read of a train."""

    origin: Any
    stroke: Any
    across: Any


FRAME = Frame(np.array([0.1, 0.0, -0.2]), np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]))


def least(
    force: Any, couple: Any, places: Places, frame: Any = FRAME, counts: Any = COUNTS
) -> Solution:
    load = np.concatenate([force, couple])
    return least_residual(Bounded(load, np.zeros(6)), places, frame, counts)


class Drawn:
    """A problem of one order, and the residual of weights by hand."""

    def __init__(self, seed: int, count: int, free: bool, phases: bool = False):
        random = np.random.default_rng(seed)
        self.order = int(random.integers(1, 3))
        start = random.normal(scale=0.2, size=(count, 3))
        end = start + (random.uniform(0.1, 0.4, count)[:, None] * AXIS if free else 0.0)
        phase = random.uniform(0.0, 6.0, count) if phases else np.full(count, np.nan)
        ratio = self.order * random.choice([-1, 1], count)
        self.places = Places(ratio, start, end, phase, random.uniform(0.1, 0.8, count))
        self.force: Any
        self.couple: Any
        drawn = random.normal(size=(2, 3)) + 1j * random.normal(size=(2, 3))
        self.force, self.couple = np.array([[1.0], [0.2]]) * drawn
        self.force[0] = 0.0

    def solve(self) -> Solution:
        return least(self.force, self.couple, self.places)

    def left(self, parts: np.ndarray, share: np.ndarray) -> float:
        """|what counts| with the parts (m, 2) at shares of the ways: vectors that turn, by hand."""
        force, couple = self.force.copy(), self.couple.copy()
        for i, (cosine, sine) in enumerate(parts):
            place = self.places.start[i] + share[i] * (self.places.end[i] - self.places.start[i])
            sense = np.sign(self.places.speed_ratio[i])
            # (cos p + i s sin p) (z - i s (-y)): at crank angle zero u (cos p z - sin p y)
            pull = self.order**2 * (cosine + 1j * sense * sine)
            pull = pull * np.array([0.0, 1j * sense, 1.0])
            force, couple = force + pull, couple + np.cross(FRAME.origin + place, pull)
        scaled = [force, 0.8 / 0.15 * couple[1:], 0.3 / 0.15 * couple[:1]]
        return float(np.linalg.norm(np.concatenate(scaled)))


def parts_of(found: Solution) -> np.ndarray:
    turned = found.unbalance.value * np.exp(1j * found.phase.value)
    return np.stack([turned.real, turned.imag], axis=1)


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_no_solver_finds_less_at_given_places(seed: int) -> None:
    drawn = Drawn(seed, 4, free=False)
    found, none = drawn.solve(), np.zeros(4)
    assert drawn.left(parts_of(found), none) == pytest.approx(found.left.value, rel=1e-12)
    assert np.all(found.unbalance.value <= drawn.places.largest * (1.0 + 1e-12))
    assert found.left.value - found.lower_bound <= 1e-11 * drawn.left(np.zeros((4, 2)), none)
    room = {
        "type": "ineq",
        "fun": lambda x: drawn.places.largest**2 - (x.reshape(4, 2) ** 2).sum(axis=1),
    }
    other = minimize(
        lambda x: drawn.left(x.reshape(4, 2), none) ** 2, np.zeros(8), method="SLSQP",
        constraints=[room], options={"ftol": 1e-14, "maxiter": 400},
    )  # fmt: skip
    assert found.left.value == pytest.approx(np.sqrt(other.fun), rel=1e-6)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_no_search_finds_less_where_places_are_free(seed: int) -> None:
    drawn = Drawn(20 + seed, 2, free=True)
    found = drawn.solve()
    assert np.all((found.share >= 0.0) & (found.share <= 1.0))
    assert drawn.left(parts_of(found), found.share) == pytest.approx(found.left.value, rel=1e-11)
    room = {
        "type": "ineq",
        "fun": lambda x: drawn.places.largest**2 - (x[:4].reshape(2, 2) ** 2).sum(axis=1),
    }
    best = min(
        minimize(
            lambda x: drawn.left(x[:4].reshape(2, 2), x[4:]) ** 2, start, method="SLSQP",
            constraints=[room], bounds=[(None, None)] * 4 + [(0.0, 1.0)] * 2,
            options={"ftol": 1e-14, "maxiter": 300},
        ).fun
        for start in np.random.default_rng(seed).uniform(0.0, 0.5, (4, 6))
    )  # fmt: skip
    assert found.left.value <= np.sqrt(best) * (1.0 + 1e-7)
    assert found.lower_bound <= found.left.value


#: what is sought stands at the ends: the longest levers need the least weight
THREE = """
schema = 1
title = "three in line, places sought"
[machine]
kind = "engine"
cycle = "four_stroke"
speed = "3000 rpm"
[machine.crank_train]
crank_radius = "45 mm"
rod_length = "150 mm"
reciprocating_mass = "600 g"
rotating_mass = "700 g"
firing_order = ["1", "3", "2"]
cylinders = [
  { name = "1", position = "-100 mm" }, { name = "2" }, { name = "3", position = "100 mm" },
]
[balance]
reference_length = "100 mm"
counterweights = [
  { name = "front", between = ["-140 mm", "-60 mm"], largest_unbalance = "40000 g*mm" },
  { name = "rear", position = "140 mm", radius = "45 mm" },
]
[[balance.shafts]]
name = "shaft"
speed_ratio = -1
position = [0, "90 mm", "50 mm"]
weights = [
  { between = ["-150 mm", "-20 mm"], largest_unbalance = "7000 g*mm" },
  { between = ["0 mm", "120 mm"] },
]
"""


@pytest.mark.long
def test_places_of_a_case_are_sought_and_what_is_not_proven_is_said(tmp_path: Path) -> None:
    path = tmp_path / "three.toml"
    path.write_text(THREE, encoding="utf-8")
    (loaded,) = load_checked([path])
    result = execute(loaded)
    record = result.record
    place = record["balance/weight/position"].values
    assert place[:, 0] == pytest.approx([-0.14, 0.14, -0.15, 0.12])
    assert place[2:, 1:] == pytest.approx(np.array([[0.09, 0.05]] * 2))
    unbalance = record["balance/weight/unbalance"].values
    assert record["balance/weight/mass"].values == pytest.approx(unbalance[1:2] / 0.045)
    # on the crank sqrt 3 (rotating mass and half of the other) r a over two arms of 140 mm
    assert unbalance[:2] == pytest.approx(np.sqrt(3.0) * 1.0 * 0.045 * 0.1 / 0.28, rel=1e-6)
    assert unbalance[2] == pytest.approx(0.007)
    assert "no lower bound is proven" in " ".join(render_report(result).split())
    assert draw_weights(result) is not None


#: one throw at 100 mm, which a weight opposite to it balances
ONE = """
schema = 1
title = "one throw"
[machine]
kind = "machine"
speed = 100.0
[machine.crank_train]
crank_radius = 0.05
rod_length = 0.2
reciprocating_mass = 0
rotating_mass = {mass}
cylinders = [{{ name = "1", position = 0.1 }}]
counterweights = [{{ name = "far", unbalance = 1e-9, position = 0.3 }}]
[balance]
reference_length = 0.1
{balance}
"""


def said_of(folder: Path, balance: str, mass: float = 1.0) -> tuple[Record, str]:
    """Results, and the report as one line."""
    path = folder / "one.toml"
    path.write_text(ONE.format(balance=balance, mass=mass), encoding="utf-8")
    (loaded,) = load_checked([path])
    result = execute(loaded)
    return result.record, " ".join(render_report(result).split())


def test_without_forces_the_couple_alone_is_balanced(tmp_path: Path) -> None:
    record, said = said_of(
        tmp_path, 'force_weight = 0\ncounterweights = [{ name = "a", position = -0.2 }]'
    )
    # 1 kg at 50 mm and 100 mm against a weight at -200 mm, on the same side
    expected = (1.0 * 0.05 * 0.1 + 1e-9 * 0.3) / 0.2
    assert record["balance/weight/unbalance"].values == pytest.approx(expected, rel=1e-12)
    assert record["balance/weight/phase"].values == pytest.approx(0.0, abs=1e-12)
    assert record["balance/after/force"].values[0] > record["balance/before/force"].values[0]
    assert "order 1 is fully balanced, except for its force (not counted)" in said


@pytest.mark.parametrize(
    ("mass", "weight", "head"),
    [
        (1.0, "50000 g mm", "unbalance phase position mass ratio g mm deg mm g -"),
        (400.0, "20.00 kg m", "unbalance phase position mass ratio kg m deg mm kg -"),
    ],
)
def test_weights_of_large_machines_are_in_kg_m(
    tmp_path: Path, mass: float, weight: str, head: str
) -> None:
    """A throw of 50 mm against a weight in its own plane, read in a unit of its size."""
    _, said = said_of(
        tmp_path, 'counterweights = [{ name = "a", position = 0.1, radius = 0.1 }]', mass
    )
    assert f"balance weight {weight} a at 180.0 deg" in said
    assert head in said


def test_weights_that_meet_at_one_place_are_said_to_be_one(tmp_path: Path) -> None:
    both = "between = [-0.2, 0.3]"
    record, said = said_of(
        tmp_path, f'counterweights = [{{ name = "a", {both} }}, {{ name = "b", {both} }}]'
    )
    place = record["balance/weight/position"].values[:, 0]
    assert place == pytest.approx(0.1, abs=1e-6)
    assert "a, b coincide: only their sum counts" in said
    _, said = said_of(tmp_path, f'counterweights = [{{ name = "a", {both} }}]')
    assert "coincide" not in said


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        (("", ""), "squares of the unbalances To"),
        (("0.1", "0.2"), "unbalances, each as a share of its maximum To"),
        (("", "0.2"), "share of its maximum, or of the largest maximum where it has none"),
    ],
)
def test_which_of_equally_good_weights_are_given(
    tmp_path: Path, bounds: tuple[str, str], words: str
) -> None:
    room = [f", largest_unbalance = {one}" if one else "" for one in bounds]
    rows = [
        f'{{ name = "{place}", position = {place}{more} }}'
        for place, more in zip((-0.1, 0.2), room, strict=True)
    ]
    record, said = said_of(tmp_path, f"couple_weight = 0\ncounterweights = [{', '.join(rows)}]")
    assert "not unique: 2 of " in said
    assert words in said
    share = [float(one or bounds[1] or 1.0) for one in bounds]
    least = np.square(share) / np.sum(np.square(share)) * (0.05 + 1e-9)
    assert record["balance/weight/unbalance"].values == pytest.approx(least, rel=1e-9)
    use = record.quantities.get("balance/weight/utilisation")
    given = [i for i, one in enumerate(bounds) if one]
    assert (use is None) == (not given)
    if use is not None:
        assert use.values == pytest.approx([least[i] / float(bounds[i]) for i in given], rel=1e-9)


def test_an_order_that_is_balanced_already_is_called_so(tmp_path: Path) -> None:
    text = (Path(__file__).parents[1] / "cases" / "balance_i4.toml").read_text(encoding="utf-8")
    text = text.replace("speed_ratio = 2", "speed_ratio = 1").replace("= -2", "= -1")
    path = tmp_path / "first.toml"
    path.write_text(text, encoding="utf-8")
    (loaded,) = load_checked([path])
    said = " ".join(render_report(execute(loaded)).split())
    assert "order 1 is balanced without weights" in said
    assert "no weight reduces" not in said


def test_what_is_left_of_all_orders_is_their_sum_over_a_turn() -> None:
    (loaded,) = load_checked([CASES["balance_i4"]])
    record = execute(loaded).record
    angle = np.linspace(0.0, 2.0 * np.pi, 4001)
    for when in ("before", "after"):
        by_order = record[f"balance/{when}/residual"].values
        whole = record[f"balance/{when}/all_orders"]
        away = abs(float(whole.values) - np.linalg.norm(by_order))
        assert away <= 1e-12 * np.linalg.norm(by_order)
    assert record["balance/after/all_orders"].values < record["balance/before/all_orders"].values
    for name in ("force", "couple"):
        left = record[f"balance/{name}"]
        wave = np.exp(1j * np.outer(left.axes[0].values, angle))
        size = np.linalg.norm((left.values.T @ wave).real, axis=0).max()
        peak = record[f"balance/after/{name}_peak"]
        assert abs(float(peak.values) - size) <= peak.error_estimate + 1e-5 * size
        shaking = np.max(record[f"excitation/{name}_peak"].values)
        assert record[f"balance/before/{name}_peak"].values >= shaking * (1.0 - 1e-9)
