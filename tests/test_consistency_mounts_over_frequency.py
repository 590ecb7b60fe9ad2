"""Claim: `[response]` has the stiffness of each frequency, as `[isolation]` has it.

That one `test_consistency_random_machines.py` holds against the equations of motion.
"""

import numpy as np
import pytest
from mounted_sets import ran, tables

ROWS = {
    "frequency": [12.0, 50.0, 190.0, 750.0],
    "stiffness_factor": [1.0, 1.15, 1.4, 2.1],
    "loss_factor": [0.06, 0.09, 0.11, 0.2],
}


def test_response_has_the_modes_and_the_forces_of_isolation() -> None:
    data = tables() | {"response": {}}
    mounts = data["machine"]["mounts"]
    del mounts["each"]["loss_factor"]
    mounts["individual"] = [
        {"name": str(n), "position": place, **({"over_frequency": ROWS} if n else {"damping": 9e2})}
        for n, place in enumerate(mounts.pop("positions"))
    ]
    record = ran(data)
    known = record["isolation/modes/natural_frequency"].values
    assert record["response/modes/natural_frequency"].values == pytest.approx(known, rel=1e-12)
    sent = record["isolation/support_force/steady_harmonics"].values.sum(axis=0).T
    away = np.abs(record["response/ground_force"].values - sent)
    assert away.max() < 1e-11 * np.abs(sent).max() and np.abs(sent).max() > 1.0
