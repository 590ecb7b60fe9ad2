"""Claim: on the front of the shipped counterweight one goal falls only as the other rises."""

import numpy as np
import pytest
from long_but import long_but
from shipped_cases import result_of, table_of

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case

KEYS = ("unbalance", "phase", "position")
SIZE = np.array([0.01, np.pi, 0.1524])


def front() -> np.ndarray:
    """Points (7, 3) of the front, the one of least weighted energy first."""
    record = result_of("compressor_balance").record
    path = "optimisation/front/variable/machine.crank_train.counterweights[0]"
    return np.array([record[f"{path}.{key}"].values for key in KEYS]).T


def goals(point: np.ndarray) -> tuple[float, float]:
    """Weighted energy, and its signed difference between the operations, of a counterweight."""
    case = table_of("compressor_balance")
    train = case["machine"]["crank_train"]
    weight = train["counterweights"][0] | dict(zip(KEYS, point.tolist(), strict=True))
    machine = case["machine"] | {"crank_train": train | {"counterweights": [weight]}}
    plain = {key: part for key, part in case.items() if key != "optimisation"}
    record = run_case(validate(plain | {"machine": machine}))
    path = "response/operations/kinetic_energy"
    mean = record[f"{path}/mean"].values.ravel()
    return float(record[f"{path}/weighted"].values.ravel()[0]), float(mean[1] - mean[0])


@pytest.mark.parametrize("share", long_but([-0.02, 0.02], 0.02))
def test_no_neighbour_of_the_first_point_is_better(share: float) -> None:
    best = front()[0]
    least = goals(best)[0]
    for place in range(3):
        assert goals(best * (1.0 + share * (np.arange(3) == place)))[0] > least


@pytest.mark.long
@pytest.mark.parametrize("place", [1, 2, 3, 4, 5])
def test_slopes_of_both_goals_are_opposite(place: int) -> None:
    point, slopes = front()[place], []
    for step in 1e-4 * np.diag(SIZE):
        slopes.append(np.subtract(goals(point + step), goals(point - step)) / 2e-4)
    weighted, difference = np.array(slopes).T
    cosine = weighted @ difference / np.linalg.norm(weighted) / np.linalg.norm(difference)
    assert cosine == pytest.approx(-1.0, abs=1e-6)
