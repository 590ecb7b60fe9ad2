"""Claim: the balance sums and the couples of Gibson 2008 (Dynamics 3 assignment) come out.

Every entry and total of Tables 1 to 4 agrees, four garbled entries of Table 3 excepted: they
are reproduced from the slip. The forces of section 2.2 are the pitch couples / lever of 0.4 m.
"""

import math

import numpy as np
import pytest

from vibecalc.excitation.balance import balance_table
from vibecalc.excitation.cylinder_torque import bank_sums

ROOT3 = math.sqrt(3.0)
POSITION = [-0.3, 0.0, 0.3]
PHASES = {120: np.radians([120.0, 0.0, 240.0]), 180: np.radians([0.0, 180.0, 0.0])}

# Rows sin a, cos a, sin 2a, cos 2a; columns cranks 1, 2, 3 and the total.
TABLE_1 = [
    [ROOT3 / 2, 0, -ROOT3 / 2, 0],
    [-1 / 2, 1, -1 / 2, 0],
    [-ROOT3 / 2, 0, ROOT3 / 2, 0],
    [-1 / 2, 1, -1 / 2, 0],
]
TABLE_2 = [[0, 0, 0, 0], [1, -1, 1, 1], [0, 0, 0, 0], [1, 1, 1, 3]]
# The same times z, as printed.
TABLE_3 = [
    [-0.3 * ROOT3, 0, 0.3 * -ROOT3 / 2, -0.3 * ROOT3],
    [0.3 / 2, 0, 0.3 / 2, 0],
    [-ROOT3 / 2, 0, ROOT3 / 2, 0.3 * ROOT3],
    [0.3 / 2, 0, -0.3 / 2, 0],
]
TABLE_4 = [[0, 0, 0, 0], [-0.3, 0, 0.3, 0], [0, 0, 0, 0], [-0.3, 0, 0.3, 0]]
#: Entry of Table 3 -> what the slip makes of the right value.
SLIPS = {
    (0, 0): ("the half is missing", lambda right: 2.0 * right),
    (1, 2): ("the sign of cos 240 deg is missing", lambda right: -right),
    (2, 0): ("z is missing, and its sign", lambda right: right / 0.3 * -1.0),
    (2, 2): ("z is missing", lambda right: right / 0.3),
}


def rows(scheme: int, place: str) -> tuple[np.ndarray, np.ndarray]:
    """Rows as printed, with totals, and their error estimates."""
    table = balance_table(
        [1, 2], crank_phase=PHASES[scheme], bank_angle=np.zeros(3), position=POSITION
    )
    order = [(n, name) for n in (0, 1) for name in ("sine", "cosine")]
    parts = [(table[place + name][n], table[f"total_{place}{name}"][n]) for n, name in order]
    values = [[*entries.value, total.value] for entries, total in parts]
    errors = [[*entries.error, total.error] for entries, total in parts]
    return np.array(values), np.array(errors)


@pytest.mark.parametrize(
    ("scheme", "place", "printed"),
    [(120, "", TABLE_1), (180, "", TABLE_2), (180, "position_", TABLE_4)],
    ids=["table 1", "table 2", "table 4"],
)
def test_tables_agree_entry_by_entry(scheme: int, place: str, printed: list[list[float]]) -> None:
    values, errors = rows(scheme, place)
    # Angles are stored as doubles: a printed zero is one within the table's own error estimate.
    assert np.all(np.abs(values - printed) <= errors + 4e-16)
    assert errors.max() < 1e-14


def test_garbled_entries_of_table_3() -> None:
    values, errors = rows(120, "position_")
    for place, printed in np.ndenumerate(np.array(TABLE_3)):
        value = values[place]
        if place in SLIPS:
            assert abs(value - printed) > 0.1
            value = SLIPS[place][1](value)
        assert value == pytest.approx(printed, rel=1e-14, abs=errors[place])


def test_totals_of_table_3_contradict_its_garbled_entries() -> None:
    printed = np.array(TABLE_3)
    sums = printed[:, :3].sum(axis=1)
    assert np.abs(sums - printed[:, 3]).tolist() == pytest.approx(
        [0.15 * ROOT3, 0.3, 0.3 * ROOT3, 0.0], abs=1e-12
    )


def test_missing_firing_of_three_cylinders_on_a_flat_crank():
    """Section 2.1: torque of the three over that of one, orders 0.5 to 3 of the four-stroke."""
    orders = np.arange(0.5, 3.1, 0.5)
    for firing, sums in (((0.0, 240.0, 480.0), (0, 0, 3, 0, 0, 3)),
                         ((0.0, 180.0, 360.0), (1, 1, 1, 3, 1, 1))):  # fmt: skip
        found = np.abs(bank_sums(np.radians(firing), orders, 0.0))[0]
        np.testing.assert_allclose(found, sums, atol=1e-14)
