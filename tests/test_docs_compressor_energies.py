"""Claim: the energies in docs/validation_compressor.md are those of the cases and of the source."""

import re

import numpy as np
import ong_tables as ong
import pytest
from compressor_page import (
    PAGE,
    RANGE,
    computed,
    found,
    is_printed,
    published,
    record,
    shown,
    table,
)

from vibecalc.units import convert

AT_WORK = {"A+B": "compressor", "A": "compressor_a", "B": "compressor_b"}
ENERGY = "in*lbf"
KINDS = {"KE": "kinetic", "PE": "potential"}
OPPOSED = "machine.crank_train.cylinders[1].bank_angle=180 deg"


@pytest.mark.parametrize(
    ("below", "kind"), [("### 3.3 Table 4.1", "kinetic"), ("### 3.4 Table 4.3", "potential")]
)
def test_energies_by_order(below: str, kind: str) -> None:
    path = f"response/{kind}_energy/peak_by_order"
    cells = table("order", below)
    assert [int(row[0]) for row in cells] == [*ong.ORDERS]
    for order, *numbers in cells:
        where = {"order": int(order)}
        for case, printed, ours in zip(AT_WORK.values(), numbers[::2], numbers[1::2], strict=True):
            assert is_printed(printed, case, path, where), (case, order, printed)
            shown(ours, computed(case, path, where, ENERGY))


def test_totals() -> None:
    cells = table("energy")
    assert len(cells) == 6
    for kind, at_work, printed, added, *over_a_turn in cells:
        case, path = AT_WORK[at_work], f"response/{KINDS[kind]}_energy"
        assert is_printed(printed, case, f"{path}/peak", {})
        each = record(case)[f"{path}/peak_by_order"]
        shown(added, convert(float(np.sum(each.values)), each.unit, ENERGY))
        for number, reading in zip(over_a_turn, ("mean", "peak"), strict=True):
            shown(number, computed(case, f"{path}/{reading}", {}, ENERGY))
    for literal in (ong.LITERAL_AB, ong.LITERAL_A):
        digits = re.findall(r"\d\.\d{15}e-\d", PAGE)
        assert literal in [float(one) for one in digits]


def test_table_4_2() -> None:
    cells = table("at work", "### 3.5")
    assert len(cells) == 7
    for at_work, balance, *numbers in cells:
        where = {"operation": at_work, "balance": balance}
        for kind, (printed, mean, peak) in zip(KINDS, (numbers[:3], numbers[3:]), strict=True):
            path = f"response/operations/{KINDS[kind]}_energy/rotating"
            assert is_printed(printed, "compressor", f"{path}_peak", where)
            for number, reading in ((mean, "mean"), (peak, "peak")):
                shown(number, computed("compressor", f"{path}_{reading}", where, ENERGY))


@pytest.mark.parametrize(
    ("below", "kind"), [("### 3.6 Tables 4.5", "kinetic"), ("### 3.7 Table 4.6", "potential")]
)
def test_tables_4_5_and_4_6(below: str, kind: str) -> None:
    cells = table("at work", below)
    assert len(cells) == 7
    for at_work, balance, printed, mean, mean_range, peak, peak_range in cells:
        where = {"operation": at_work, "balance": balance}
        path = f"response/operations/{kind}_energy"
        assert is_printed(printed, "compressor", f"{path}/peak", where), (where, printed)
        for number, both, reading in ((mean, mean_range, "mean"), (peak, peak_range, "peak")):
            shown(number, computed("compressor", f"{path}/{reading}", where, ENERGY))
            ends = RANGE.match(both)
            assert (ends is None) == (at_work == balance)
            if ends is not None:
                for end, side in zip(ends.groups(), ("low", "high"), strict=True):
                    value = computed("compressor", f"{path}/{reading}_{side}", where, ENERGY)
                    shown(end, value)


def means(*settings: str, reading: str = "mean") -> np.ndarray:
    """Energies of A+B, A and B, each balanced for itself: kinetic, then potential."""
    return np.array(
        [
            computed(
                "compressor",
                f"response/operations/{kind}_energy/{reading}",
                {"operation": name, "balance": name},
                ENERGY,
                *settings,
            )
            for kind in KINDS.values()
            for name in AT_WORK
        ]
    )


def test_what_each_step_of_the_source_does() -> None:
    part = published("ong_energies")
    right = part["energies_over_cycle"](
        part["MATRICES"], part["right_motion"](), ong.ORDERS, ong.SPEED
    )
    twice = 2.0 * np.concatenate([right.kinetic.mean, right.potential.mean]) / ong.ENERGY
    printed = np.concatenate([energy.sum(axis=0) for energy in part["shaking_tables"]()])
    added = [
        convert(float(np.sum(record(case)[f"response/{kind}_energy/peak_by_order"].values)),
                "J", ENERGY)
        for kind in KINDS.values()
        for case in AT_WORK.values()
    ]  # fmt: skip
    everyone, base = np.ones(6), means()
    stiffness, mass = "machine.mounts.stiffness_matrix.values", "machine.body.mass_matrix.values"
    split = [0.734 + 0.625 * 0.131 / length for length in (2.374, 2.375)]
    changes = {
        "magnitudes of the modes are added": printed / twice,
        "even orders of the two pistons cancel": means(OPPOSED) / base,
        "largest energies of the orders are added": np.array(added) / means(reading="peak"),
        "g = 386.4, text 386.088": everyone * (386.088 / 386.4) ** 2,
        "g = 384.088, script files": everyone * (386.088 / 384.088) ** 2,
        "L = 2.374 in the split of the rod": everyone * (split[0] / split[1]) ** 2,
        "K46 = 282, text": means(f"{stiffness}[3][5]=282", f"{stiffness}[5][3]=282") / base,
        "M56 = +0.49, text": means(f"{mass}[4][5]=0.49", f"{mass}[5][4]=0.49") / base,
    }
    cells = {name: numbers for name, *numbers in table("what, change in %")}
    assert set(cells) == set(changes)
    for name, change in changes.items():
        for number, value in zip(cells[name], 100.0 * (change - 1.0), strict=True):
            shown(number, value if abs(value) > 1e-9 else 0.0)


def test_numbers_in_the_words_on_energies() -> None:
    part = published("ong_energies")
    totals = [
        part["shaking_tables"](np.array([1.0, *signs]))[0].sum(axis=0)[1]
        for signs in np.array(np.meshgrid(*[[1.0, -1.0]] * 5)).reshape(5, -1).T
    ]
    shown(found(r"total of A runs from (\S+) to"), min(totals))
    shown(found(r"total of A runs from \S+ to ([\d.]+\d)"), max(totals))
    both = means()[0]
    shown(found(r"mean KE of A\+B is (\S+) times"), both / means(OPPOSED)[0])
    force = computed("compressor", "excitation/force", {"order": 2, "direction": "y"}, "N")
    shown(found(r"a force of (\S+) N shakes"), force)
    path = "response/kinetic_energy/peak_by_order"
    second = computed("compressor", path, {"order": 2}, ENERGY)
    shown(found(r"Order 2 of A\+B is (\S+) in lbf"), second)
    shown(found(r"not (0\.000\d+), 48 times"), float(ong.TABLE_4_1.split()[5]))
    assert round(second / float(ong.TABLE_4_1.split()[5])) == 48
    energy = "response/operations/kinetic_energy"

    def of(path: str, at_work: str, balance: str) -> float:
        where = {"operation": at_work, "balance": balance}
        return computed("compressor", f"{energy}/{path}", where, ENERGY)

    levers = of("rotating_mean", "A", "A+B") / of("rotating_mean", "B", "A+B")
    shown(found(r"differ by a factor of (\S+)\."), levers)
    shown(found(r"lowers the mean from (\S+) to"), both)
    shown(found(r"lowers the mean from \S+ to (\S+)\."), of("mean", "A+B", "B"))
    peaks = [
        of("rotating_peak", at_work, "A+B") / of("rotating_mean", at_work, "A+B")
        for at_work in ("A", "B")
    ]
    shown(found(r"its peak is (\S+) times its mean"), max(peaks))
    for side in ("A", "B"):
        load = part["TURNING"][side]
        motion = np.linalg.solve(ong.STIFFNESS - ong.SPEED**2 * ong.MASS, load)
        mean = ong.SPEED**2 * (motion.conj() @ ong.MASS @ motion).real / 4.0
        shown(found(r"prints (\S+) times the right mean"), part["crankshaft"](side)[0] / mean)
    rise = of("mean", "A", "A+B") / of("mean", "A", "A") - 1.0
    shown(found(r"has (\S+) % more mean energy"), 100.0 * rise)
    assert round(100.0 * (0.63686 / 0.61510 - 1.0), 1) == float(found(r"on its own, not (\S+) %"))
