"""Claim: sag and stiffness of curved mounts and stops are those by hand; what none bears is said.

Bodies on such mounts `test_consistency_random_machines.py` holds against the dense model.
"""

import itertools

import numpy as np
import pytest
from mounted_sets import ran, tables
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from vibecalc.core.case.load import validate
from vibecalc.errors import NumericalFailure
from vibecalc.parts.cautions import implausible
from vibecalc.parts.mount_curves import Level, TangentByLoad

CURVE = {"deflection": [-0.002, 0.0, 0.002, 0.004, 0.007], "load": [-300, 0, 500, 1400, 4500]}


def in_the_middle(**properties: object) -> dict:
    """800 kg above the middle of four equal mounts."""
    data = tables()
    data["machine"]["body"]["parts"] = [
        {"name": "all", "mass": 800.0, "centre": [0.9, 0.0, 0.3], "inertia": [40, 90, 100]}
    ]
    data["machine"]["mounts"]["each"] = {"loss_factor": 0.1, **properties}
    return data


def test_a_straight_stop_by_hand() -> None:
    data = in_the_middle(stiffness=4e5, static={"stops": {"down": 0.004, "stiffness": 2e6}})
    record = ran(data)
    deep = (200.0 * 9.80665 + 2e6 * 0.004) / (4e5 + 2e6)
    assert record["isolation/mounts/deflection"].values == pytest.approx(deep, rel=1e-12)
    left = record["isolation/mounts/clearance_at_rest"].values
    assert left == pytest.approx(0.004 - deep, rel=1e-9)
    assert any("stands on its stop at rest" in text for text in record.warnings)


@pytest.mark.parametrize(
    "load",
    [[0.0, 800.0, 1700.0, 2600.0], [2500.0, 4000.0, 4100.0, 5e3]],
)
def test_the_sag_is_the_integral_of_the_stiffness_over_the_load(load: list[float]) -> None:
    """dF = k(F) du / ratio up to the weight of each mount, within the rows and beyond them."""
    stiffness, weight = [1.5e5, 2.2e5, 4.4e5, 9e5], 200.0 * 9.80665
    slopes = PchipInterpolator(load, stiffness).derivative()(load)
    slopes[[0, -1]] = 0.0
    curve = CubicHermiteSpline(load, stiffness, slopes)

    def inverse(force: float) -> float:
        return 1.3 / float(curve(min(max(force, load[0]), load[-1])))

    ends = [0.0, *(one for one in load if 0.0 < one < weight), weight]
    sag = sum(quad(inverse, a, b, epsrel=1e-13)[0] for a, b in itertools.pairwise(ends))
    static = {"dynamic_to_static": 1.3}
    by_rows = ran(in_the_middle(over_load={"load": load, "stiffness": stiffness}, static=static))
    assert by_rows["isolation/support_displacement/static"].values == pytest.approx(sag, rel=1e-11)
    assert by_rows["isolation/mounts/deflection"].values == pytest.approx(sag, rel=1e-11)
    tangent = by_rows["isolation/mounts/static_stiffness"].values
    assert tangent == pytest.approx(1.0 / inverse(weight), rel=1e-11)
    moving = by_rows["isolation/mounts/stiffness"].values
    assert moving == pytest.approx(1.3 / inverse(weight), rel=1e-11)
    factors = {"load": load, "stiffness_factor": [one / 2.2e5 for one in stiffness]}
    other = ran(in_the_middle(stiffness=2.2e5, over_load=factors, static=static))
    for path in (
        "support_displacement/static",
        "mounts/stiffness",
        "support_force/steady_peak",
    ):
        known = by_rows[f"isolation/{path}"].values
        assert other[f"isolation/{path}"].values == pytest.approx(known, rel=1e-10)
    # what the law itself says: its load and work are integrals of its slope
    law = TangentByLoad(Level(load, stiffness))
    solved = solve_ivp(lambda u, y: [law(u)[1], y[0]], (0.0, 0.02), [0.0, 0.0], "DOP853",
                       rtol=1e-12, atol=1e-9)  # fmt: skip
    found, _, work = law(0.02)
    assert solved.y[:, -1] == pytest.approx([found, work], rel=1e-9)


def test_the_warning_of_the_sag_is_that_of_the_load_over_deflection() -> None:
    soft = {"deflection": [0.0, 1.0], "load": [0.0, 4000.0]}
    stiff = {"deflection": [0.0, 0.01], "load": [0.0, 4000.0]}
    for across, rows, deep in ((4e5, soft, "0.49 m"), (3e3, stiff, "")):
        data = in_the_middle(stiffness=[2e5, 2e5, across], static={"load_deflection": rows})
        said = [one for one in implausible(validate(data)) if "static deflection" in one]
        assert [f"is about {deep}," in one for one in said] == [True] * bool(deep)


def test_loads_beyond_the_rows_and_bodies_adrift_are_failures() -> None:
    data = tables()
    data["machine"]["mounts"]["each"]["static"] = {"load_deflection": CURVE}
    data["machine"]["body"]["parts"][0]["mass"] = 20000.0
    with pytest.raises(NumericalFailure, match=r"carries .* beyond its rows of load_deflection"):
        ran(data)


# ----------------------------------------------------------------------------
# Mounts that follow the frequency, in [response] as in [isolation].
# ----------------------------------------------------------------------------


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
