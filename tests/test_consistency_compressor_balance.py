"""Claim: no neighbour of the shipped counterweight has less weighted energy."""

import numpy as np
import pytest
from long_but import long_but
from shipped_cases import result_of, table_of

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case

KEYS = ("unbalance", "phase", "position")


def least() -> np.ndarray:
    """The counterweight (3,) of least weighted energy, the first of the front."""
    record = result_of("compressor_balance").record
    path = "optimisation/front/variable/machine.crank_train.counterweights[0]"
    return np.array([record[f"{path}.{key}"].values[0] for key in KEYS])


def energy(point: np.ndarray) -> float:
    """Weighted energy of a counterweight."""
    case = table_of("compressor_balance")
    train = case["machine"]["crank_train"]
    weight = train["counterweights"][0] | dict(zip(KEYS, point.tolist(), strict=True))
    machine = case["machine"] | {"crank_train": train | {"counterweights": [weight]}}
    plain = {key: part for key, part in case.items() if key != "optimisation"}
    record = run_case(validate(plain | {"machine": machine}))
    return float(record["response/operations/kinetic_energy/weighted"].values.ravel()[0])


@pytest.mark.parametrize("share", long_but([-0.02, 0.02], 0.02))
def test_no_neighbour_of_the_first_point_is_better(share: float) -> None:
    best = least()
    for place in range(3):
        assert energy(best * (1.0 + share * (np.arange(3) == place))) > energy(best)
