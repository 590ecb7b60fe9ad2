"""Claim: studies of a shaft line agree with runs of the line that they change."""

import numpy as np
import pytest
from engine_cases import ENGINE, GEARED, ran, replaced

from vibecalc.core.results.record import Record, Result

TORSION = "response/torsion/"
SPEEDS = 'speeds = { from = "800 rpm", to = "2000 rpm" }\n'
#: a light shaft damping throughout, so that a disturbance dies out in the time watched
DAMPED = replaced(
    ENGINE,
    ('"1e6 N*m/rad", diameter = "70 mm"', '"1e6 N*m/rad", damping = "40 N*m*s/rad"'),
    ('stiffness = "1e6 N*m/rad" }', 'stiffness = "1e6 N*m/rad", damping = "40 N*m*s/rad" }'),
    ('damping = "5 N*m*s/rad"', 'damping = "80 N*m*s/rad"'),
)


def of(extra: str, base: str = DAMPED, speeds: str = "") -> Result:
    return ran(replaced(base, (SPEEDS, speeds)) + extra)


def value(record: Record, path: str) -> np.ndarray:
    return np.asarray(record[TORSION + path].values)


@pytest.mark.long
def test_run_up_has_the_steady_curve_nearby_it_and_lags() -> None:
    change = ('transient = { kind = "run_up", from = "900 rpm", to = "1900 rpm", '
              'duration = "%s s", time_after = "0.05 s" }\n')  # fmt: skip
    slow, fast = (of(change % t).record for t in ("4", "0.5"))
    for record in (slow, fast):
        found, at = (value(record, f"transient/steady_half_range{end}") for end in ("", "_speed"))
        there = replaced(DAMPED, ('speed = "1500 rpm"', f'speed = "{float(at[0])!r} rad/s"'))
        assert found[0] == pytest.approx(value(of("", there).record, "torque_half_range")[0])
        assert np.all(value(record, "transient/quasi_steady").max(axis=1) >= 0.999 * found)
    # the faster, the less time to build up
    late = [np.abs(value(record, "transient/overshoot")[:3]).max() for record in (slow, fast)]
    assert late[0] < late[1]


def geared_ring(inertia: float) -> str:
    """A ring behind a gear of four to one, only its damping to be found."""
    speeds = 'speeds = { from = "500 rpm", to = "900 rpm", points = 101 }\n'
    geared = GEARED.replace(
        "[response.torsion]\n",
        f'dampers = [{{ name = "ring", on = "generator", kind = "spring", inertia = "{inertia} '
        'kg*m^2", stiffness = "2e3 N*m/rad", damping = "6 N*m*s/rad" }]\n'
        "[response.torsion]\norders = { highest = 4 }\n",
    )
    for stiffness in ('"1e6 N*m/rad"', '"4e5 N*m/rad"', '"2e5 N*m/rad"', '"3e4 N*m/rad"'):
        geared = replaced(geared, (stiffness, f'{stiffness}, damping = "30 N*m*s/rad"'))
    return geared + speeds + '[damper_design]\non = "ring"\nfind = ["damping"]\n'


@pytest.mark.long
def test_damper_on_a_geared_shaft_is_reported_in_its_own_values() -> None:
    # its damper put into the case as a part
    record = ran(
        geared_ring(0.05) + 'rings = ["0.05 kg*m^2"]\n'
        'compare = { stiffness = "2e3 N*m/rad", damping = "6 N*m*s/rad" }\n'
    ).record
    shafts = value(record, "largest/torque_half_range")[:5].max()
    assert float(record["damper_design/table/worst_torque"].values) == pytest.approx(shafts)
    path = TORSION + "speeds/travel"
    travel = float(record["damper_design/table/travel"].values)
    assert travel == pytest.approx(np.asarray(record[path].values).max(), rel=0.05)
    assert float(record["damper_design/stiffness"].values) == pytest.approx(2e3)
    assert not [w for w in record.warnings if "ring" in w]
    rings, own = (
        np.asarray(record[f"damper_design/{n}torque"].values) for n in ("ring/", "worst_")
    )
    assert rings[0] == pytest.approx(float(own), rel=1e-6)


#: two inertias and a ring in oil, excited by the first order alone
TWO = """schema = 1
title = "two inertias and a ring"
[machine]
kind = "drive_train"
speed = "100 rad/s"
[machine.shaft_line]
stations = [{ name = "hub", inertia = "0.1 kg*m^2" }, { name = "wheel", inertia = "2 kg*m^2" }]
shafts = [{ name = "shaft", stiffness = "1e6 N*m/rad" }]
excitations = [{ on = "hub", orders = [1], torques = ["50 N*m"] }]
dampers = [{ name = "ring", on = "hub", kind = "viscous", inertia = 0.05, damping = 30.0 }]
[response.torsion]
"""
RING = "machine.shaft_line.dampers[0].damping"


def test_find_a_shaft_for_a_frequency() -> None:
    search = """[[find]]
name = "shaft"
key = "machine.shaft_line.shafts[0].stiffness"
min = "1e4 N*m/rad"
max = "1e7 N*m/rad"
quantity = "response/torsion/modes/natural_frequency"
where = { mode = 2 }
target = "100 Hz"
points = 5
"""
    ring = next(line for line in TWO.splitlines() if line.startswith("dampers"))
    found = ran(replaced(TWO, (ring, "")) + search).record["find/shaft/value"]
    exact = (200.0 * np.pi) ** 2 * 0.1 * 2.0 / 2.1
    assert abs(float(found.values) - exact) <= found.error_estimate <= 1e-9 * exact


@pytest.mark.long
def test_the_damping_that_takes_the_most_heat() -> None:
    """A slip v between ring and hub is T / (c + Z), Z the impedance of both in series.

    T is what the dashpot would carry, were it rigid, times a share that c does not change; half of
    c |v|^2 is largest at c = |Z|, as Z is imaginary without any other damping.
    """
    search = f"""[optimisation]
variables = [{{ key = "{RING}", min = "0.5 N*m*s/rad", max = "50 N*m*s/rad" }}]
objective = {{ quantity = "response/torsion/damper/heat", where = {{ damper = "ring" }}, sense = "max" }}
starts = 1
"""  # noqa: E501
    record = ran(TWO + search).record
    w, k = 100.0, 1e6
    rest = -0.1 * w**2 + k - k * k / (k - 2.0 * w**2)  # dynamic stiffness at the hub
    best = abs(1.0 / (w / (-0.05 * w**2) + w / rest))
    found = record[f"optimisation/variable/{RING}"]
    assert abs(float(found.values) - best) <= found.error_estimate + 1e-12 * best
    assert found.error_estimate < 1e-4 * best
    heat = value(ran(replaced(TWO, ("30.0", repr(best)))).record, "damper/heat")[0]
    assert float(record["optimisation/objective"].values) == pytest.approx(heat, rel=1e-9)
