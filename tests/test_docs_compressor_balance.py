"""Claim: docs/validation_compressor.md shows searches, changes and counterweights as they are."""

from functools import cache

import numpy as np
import ong_tables as ong
import pytest
from compressor_page import (
    QUANTITY,
    computed,
    found,
    picked,
    published,
    references,
    shown,
    table,
)
from long_but import long_but
from ong_search import TARGET, corrective_energy, search
from shipped_cases import result_of, table_of

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case


def turning(angle: float, force: float, torque: float) -> np.ndarray:
    """Sine and cosine part of the source's corrective load, (2, 6)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        [
            [-force * s, force * c, 0.0, -torque * c, -torque * s, 0.0],
            [force * c, force * s, 0.0, -torque * s, torque * c, 0.0],
        ]
    )


def test_table_8_2() -> None:
    part = published("ong_search")
    columns = table("start")
    assert len(columns) == len(part["TABLE_8_2"]) == 7
    starts = [tuple(float(one) for one in row[0].split(",")) for row in columns]
    ends = search(np.array(starts).T)
    for start, cells, point, lowest in zip(
        starts, columns, ends.point.T, ends.objective, strict=True
    ):
        printed = part["TABLE_8_2"][start]
        assert (*cells[1:8:2], int(cells[9])) == printed
        for number, value in zip(cells[2:7:2], point, strict=True):
            shown(number, value)
        for digits in cells[1:8:2]:
            assert digits in {row[0] for row in references("compressor_balance")}
        # the goal is a difference of doubles near .28
        half_digit = 0.5 * part["last_digit"](cells[8])
        assert float(cells[8]) == pytest.approx(lowest, abs=half_digit + part["ROUNDING"])


def test_numbers_in_the_words_on_the_search() -> None:
    best = np.array([[3.8537], [72.2211], [84.2173]])
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    over = corrective_energy(np.array([angle, *np.outer(best[1:, 0], np.ones(721))]))
    shown(found(r"magnitudes let it run from (\S+) to"), over.min())
    shown(found(r"magnitudes let it run from \S+ to ([\d.]+\d),"), over.max())
    twice = []
    for turned in (0.0, 1.0, 3.8537):
        force, torque = best[1:, 0]
        load = np.array([force, -1j * force, 0.0, 1j * torque, torque, 0.0])
        motion = np.linalg.solve(
            ong.STIFFNESS - ong.SPEED**2 * ong.MASS, load * np.exp(1j * turned)
        )
        twice.append(ong.SPEED**2 * (motion.conj() @ ong.MASS @ motion).real / 2.0)
    assert np.ptp(twice) < 1e-14
    shown(found(r"best setting has (\S+) in lbf"), twice[0])
    # at order 1 the source's energy of the same load, out of that of all orders
    speed = np.array([ong.SPEED])
    parts = [
        published("ong_energies")["slipped"](one * ong.LOAD[None], speed)
        for one in turning(*best[:, 0])
    ]
    kinetic = published("ong_energies")["source_energies"](np.hypot(*parts), speed)[0]
    share = float(kinetic[0]) / corrective_energy(best)[0]
    shown(found(r"order 1 alone gives (\S+) %"), 100.0 * share)
    goal = TARGET - (ong.LITERAL_A - ong.LITERAL_AB) / 2.0
    shown(found(r"moves the goal itself by (\S+) in lbf"), goal)
    worst = max(float(row[7]) for row in table("start"))
    assert round(abs(goal) / worst, -4) == float(
        found(r"([\d,]+) times the worst").replace(",", "")
    )


def test_switching() -> None:
    """Both changes, and the steady energies of both operations."""
    cells = table("change")
    assert len(cells) == 12
    for label, cell, *numbers in cells:
        quantity = QUANTITY.match(cell)
        assert quantity is not None
        axis, names, case = "change", ("A+B to A", "A to A+B"), "compressor_switching"
        settings: tuple[tuple[str, ...], ...] = ((), ())
        if "steady_energy" in cell:
            axis, names = "operation", ("A+B", "A")
        if label.startswith("steady, force"):
            axis, case = "", "compressor"
            damped = "machine.mounts.modal_damping=0.03"
            settings = ((damped,), (damped, 'excitation.working=["A"]'))
        for number, name, some in zip(numbers, names, settings, strict=True):
            where = picked(quantity[2]) | ({axis: name} if axis else {})
            value = computed(case, quantity[1], where, "", *some)
            shown(number, value if number.startswith("-") else abs(value))
    numbers = {label: [float(one) for one in row] for label, _, *row in cells}
    over = max(numbers["reversal, force on the ground, N"])
    over /= max(numbers["steady, force on the ground, N: A+B; A"])
    shown(found(r"force on the ground is (\S+) times"), over)


BALANCE = ("unbalance", "phase", "position")


def design(*numbers: float) -> Record:
    """The balance case without its search, with that counterweight."""
    case = table_of("compressor_balance")
    train = case["machine"]["crank_train"]
    weight = train["counterweights"][0] | dict(zip(BALANCE, numbers, strict=True))
    machine = case["machine"] | {"crank_train": train | {"counterweights": [weight]}}
    plain = {key: part for key, part in case.items() if key != "optimisation"}
    return run_case(validate(plain | {"machine": machine}))


def readings(found_at: Record) -> list[float]:
    """Weighted energy, difference, and the two means."""
    path = "response/operations/kinetic_energy"
    each = [found_at[f"{path}/{name}"].values.ravel() for name in ("weighted", "difference")]
    return [float(each[0][0]), float(each[1][0]), *found_at[f"{path}/mean"].values.ravel()]


def test_counterweights_from_their_variables() -> None:
    cells = table("counterweight")
    assert len(cells) == 7
    for _, *numbers in cells:
        ours = readings(design(*map(float, numbers[:3])))
        for number, value in zip(numbers[3:], ours, strict=True):
            shown(number, value)
    none, best, alike = cells[0], cells[2], cells[-1]
    assert f"{100 * (1 - float(best[4]) / float(none[4])):.0f}" == found(r"energy is (\d+) % below")
    assert f"{100 * (float(alike[4]) / float(none[4]) - 1):.0f}" == found(r"alike for (\d+) % more")
    assert f"{float(alike[6]) / float(none[6]):.1f}" == found(r"A\+B has (\S+) times its energy")
    assert float(alike[7]) / float(none[7]) == pytest.approx(0.5, abs=0.05)


@cache
def first_of_the_front() -> float:
    return readings(design(*(float(one) for one in table("counterweight")[2][1:4])))[0]


@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("share", long_but([-0.02, 0.02], 0.02))
def test_no_neighbour_of_the_first_counterweight_is_better(place: int, share: float) -> None:
    numbers = [float(one) for one in table("counterweight")[2][1:4]]
    least = first_of_the_front()
    numbers[place] *= 1.0 + share
    assert readings(design(*numbers))[0] > least


@pytest.mark.parametrize("row", long_but([3, 4, 5, 6], 5))
def test_on_the_front_one_goal_falls_only_as_the_other_rises(row: int) -> None:
    """Both goals have opposite slopes there; alike needs the signed difference, which is smooth."""
    point = np.array([float(one) for one in table("counterweight")[row][1:4]])
    size = np.array([0.01, np.pi, 0.1524])
    slopes = []
    for place in range(3):
        step = np.zeros(3)
        step[place] = 1e-4 * size[place]
        up, down = (readings(design(*(point + side * step))) for side in (1.0, -1.0))
        signed = [(one[0], one[3] - one[2]) for one in (up, down)]
        slopes.append(np.subtract(*signed) / 2e-4)
    weighted, difference = np.array(slopes).T
    cosine = weighted @ difference / np.linalg.norm(weighted) / np.linalg.norm(difference)
    assert cosine == pytest.approx(-1.0, abs=1e-6)


@pytest.mark.long
def test_the_balance_case_finds_both_ends_of_its_front() -> None:
    result = result_of("compressor_balance").record
    cells = [[float(one) for one in row[1:]] for row in table("counterweight")]
    weighted = result["optimisation/front/objective"].values
    difference = result["optimisation/front/second_objective"].values
    for end, row in ((0, cells[2]), (-1, cells[-1])):
        assert weighted[end] == pytest.approx(row[3], abs=2e-6)
        assert difference[end] == pytest.approx(row[4], abs=2e-5)
    counts = result["optimisation/methods/evaluations"]
    methods = table("method")
    assert list(counts.axes[0].values) == [row[0] for row in methods]
    np.testing.assert_allclose([int(row[1]) for row in methods], counts.values, rtol=0.3)
