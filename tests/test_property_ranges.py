"""A range of speeds is the user's own: part of it gives what all of it gives, none is left for it.

A range may have no peak, hold two points a rounding apart, or end on a resonance, on the operating
speed or on the last gas card: each is an ordinary range.
"""

import math
import tomllib
from typing import Any

import numpy as np
import pytest
from engine_mounted import ON_BODY
from shipped_cases import CASES, table_of

from vibecalc import api
from vibecalc.core.results.record import Result
from vibecalc.errors import CaseError
from vibecalc.isolation.torque_reaction import couple_by_differences
from vibecalc.numerics.bounded import Bounded

RPM = math.pi / 30.0
SPEEDS = "response.torsion.speeds"
#: a card of a few points, in rad and Pa
CARD = {
    "crank_angle": [0.0, 0.4, 1.0, 2.5, 4.0, 8.0, 10.5, 11.8, 4.0 * math.pi],
    "pressure": [90e5, 110e5, 45e5, 8e5, 1.5e5, 1e5, 4e5, 30e5, 90e5],
}


def engine(out: dict[str, Any], **response: Any) -> dict[str, Any]:
    """Three cylinders on a brake, with gas cards from 400 to 780 rpm; `out` is the shaft to it."""
    cards = [{"speed": speed, "gas_pressure": CARD} for speed in ("400 rpm", "780 rpm")]
    stations = [
        {"name": f"t{n}", "inertia": 24.0, "cylinder": str(n), "absolute_damping": 50.0}
        for n in (1, 2, 3)
    ]
    crank = [{"name": name, "stiffness": 60e6} for name in ("c12", "c23")]
    return {
        "schema": 1,
        "title": "Three cylinders",
        "machine": {
            "kind": "engine",
            "cycle": "four_stroke",
            "speed": "750 rpm",
            "crank_train": {
                "crank_radius": 0.2,
                "rod_length": 0.88,
                "bore": 0.32,
                "reciprocating_mass": 95.0,
                "gas_cards": cards,
                "cylinders": [{"name": str(n)} for n in (1, 2, 3)],
                "firing_order": ["1", "3", "2"],
            },
            "shaft_line": {
                "stations": [*stations, {"name": "brake", "inertia": 300.0}],
                "shafts": [*crank, {"name": "out", **out}],
            },
        },
        "response": {
            "torsion": {
                "orders": {"highest": 9.0},
                "speeds": {"from": "400 rpm", "to": "780 rpm", "points": 39},
                **response,
            }
        },
    }


STIFF: dict[str, Any] = {"stiffness": 20e6}
WARM: dict[str, Any] = {
    "coupling": {
        "stiffness": 0.25e6,
        "relative_damping": 1.0,
        "ambient_temperature": "40 degC",
        "thermal_resistance": "0.00002 K/W",
        "over_temperature": {
            "temperature": ["20 degC", "60 degC", "140 degC"],
            "stiffness_factor": [1.0, 0.85, 0.7],
        },
    }
}
LIMIT = {
    "torque": {"speed": ["400 rpm", "780 rpm"], "torque": ["5 kN*m", "5 kN*m"]},
    "sections": ["out"],
}


def pump_line(**shaft: Any) -> dict[str, Any]:
    """A motor and a propeller whose damping follows the speed, with its resonance at 215 rpm."""
    load = {
        "on": "propeller",
        "torque": "40 kN*m",
        "exponent": 2,
        "propeller_damping": {"method": "archer"},
    }
    return {
        "schema": 1,
        "title": "Propeller",
        "machine": {
            "kind": "drive_train",
            "speed": "120 rpm",
            "shaft_line": {
                "speed_of": "motor",
                "balanced_by": "motor",
                "absorbed_torques": [load],
                "stations": [
                    {"name": "motor", "inertia": 900.0},
                    {"name": "propeller", "inertia": 2500.0},
                ],
                "shafts": [{"name": "shaft", "stiffness": 2e6, "loss_factor": 0.01, **shaft}],
                "excitations": [{"on": "propeller", "blades": 4, "shares": [0.05]}],
            },
        },
        "response": {"torsion": {"speeds": {"from": "60 rpm", "to": "80 rpm", "points": 41}}},
    }


def over_speed(result: Result) -> Any:
    """Speeds (s,), torques of the sections (s, e) at them, and their error."""
    found = result["response/torsion/speeds/torque_half_range"]
    place = [axis.name for axis in found.axes].index("speed")
    torque = np.moveaxis(np.asarray(found.values), place, 0)
    return np.asarray(found.axes[place].values), torque, found.error_estimate


def reported(case: Any, speeds: dict[str, Any], **keys: Any) -> Result:
    """A run that check has nothing against, with both reports made."""
    given = {SPEEDS: speeds, **keys}
    api.check(case, set=given)
    result = api.run(case, set=given)
    assert api.report(result, full=True)
    return result


def test_a_limit_exceeded_up_to_the_last_card_has_its_range_up_to_there() -> None:
    """The slope at an end of the range is one-sided: there is no card beyond."""
    result = api.run(engine(STIFF, limits=[LIMIT]))
    ends = np.asarray(result["response/torsion/exceeded/to"].values)
    assert len(ends)
    np.testing.assert_allclose(ends.max(), 780.0 * RPM, rtol=1e-12)


def test_criticals_with_a_coupling_are_sought_within_the_cards() -> None:
    """Modes of a coupling that warms meet orders beyond the range, where no card is."""
    result = api.run(engine(WARM))
    found = np.asarray(result["response/torsion/critical/speed"].values)
    assert np.any((found > 360.0 * RPM) & (found < 400.0 * RPM))


@pytest.mark.parametrize(
    "ends", [("400 rpm", "780 rpm"), ("6.66666666666666 Hz", "13.0000000000001 Hz")]
)
def test_the_last_card_counts_for_its_speed_in_other_units(ends: tuple[str, str]) -> None:
    """Roundings of a conversion leave neither check nor run without a card."""
    speeds = {"from": ends[0], "to": ends[1], "points": 5}
    assert len(over_speed(reported(engine(STIFF), speeds))[0]) == 5


RANGES = {
    "no peak": (0.995, 1.005),
    "operating speed at its end": (0.97, 1.0),
    "operating speed at its start": (1.0, 1.03),
    "narrow": (1.0, 1.0 + 1e-9),
    "two neighbouring numbers": (1.0, 1.0 + 4e-16),
}


@pytest.mark.parametrize("ends", RANGES.values(), ids=RANGES.keys())
@pytest.mark.parametrize("kind", ["cards", "coupling", "propeller"])
def test_any_range_is_an_ordinary_one(kind: str, ends: tuple[float, float]) -> None:
    """Also one that holds no peak."""
    case = {
        "cards": engine(STIFF, limits=[LIMIT]),
        "coupling": engine(WARM),
        "propeller": pump_line(),
    }[kind]
    speed = (120.0 if kind == "propeller" else 750.0) * RPM
    first, last = (speed * end for end in ends)
    result = reported(case, {"from": first, "to": last, "points": 3})
    found = over_speed(result)[1]
    assert np.all(np.isfinite(found)) and np.all(found >= 0.0)
    largest = np.asarray(result["response/torsion/largest/torque_half_range"].values)
    assert np.all(largest >= found.max(axis=0) * (1.0 - 1e-12))
    at = np.asarray(result["response/torsion/largest/speed"].values)
    assert np.all((at >= first) & (at <= last))


@pytest.mark.parametrize("kind", ["cards", "coupling", "propeller"])
def test_a_range_may_end_on_a_resonance(kind: str) -> None:
    case = {"cards": engine(STIFF), "coupling": engine(WARM), "propeller": pump_line()}[kind]
    wide = api.run(case)
    speed = over_speed(wide)[0]
    critical = np.asarray(wide["response/torsion/critical/speed"].values).ravel()
    middle = speed[len(speed) // 2]
    inside = critical[np.isfinite(critical) & (critical > 0.0)]
    if kind == "propeller":  # outside of its range: the range goes there
        met = float(inside.min())
    else:
        met = float(inside[np.argmin(np.abs(inside - middle))])
    for first, last in ((met, 1.02 * met), (0.98 * met, met)):
        found = over_speed(reported(case, {"from": first, "to": last, "points": 4}))[1]
        assert np.all(np.isfinite(found))


@pytest.mark.parametrize(
    "speeds",
    [
        {"from": 70.0, "to": 70.0, "points": 2},
        {"from": 70.0, "to": 75.0, "points": 1},
        {"from": 75.0, "to": 70.0, "points": 5},
    ],
    ids=["from = to", "one point", "descending"],
)
def test_what_is_no_range_is_refused_by_check(speeds: dict[str, Any]) -> None:
    with pytest.raises(CaseError):
        api.check(engine(STIFF), set={SPEEDS: speeds})


@pytest.mark.parametrize(
    "name",
    ["pump_drive", *(pytest.param(one, marks=pytest.mark.long) for one in (
        "engine_geared", "genset_coupling"))],
)  # fmt: skip
def test_part_of_a_range_gives_what_the_whole_gives(name: str) -> None:
    """Curves at the same speeds agree, and the part has no larger value than the whole."""
    case, generator = CASES[name], np.random.default_rng(36)
    unset = sorted({"reference", "limit"} & table_of(name).keys())
    whole = api.run(case, unset=unset, set={f"{SPEEDS}.points": 31})
    speed, torque, error = over_speed(whole)
    top = np.asarray(whole["response/torsion/largest/torque_half_range"].values)
    for _ in range(1 if name == "genset_coupling" else 2):
        start = int(generator.integers(0, len(speed) - 7))
        count = int(generator.integers(2, 7))
        part = slice(start, start + count)
        speeds = {"from": float(speed[part][0]), "to": float(speed[part][-1]), "points": count}
        run = api.run(case, unset=unset, set={SPEEDS: speeds})
        at, found, off = over_speed(run)
        np.testing.assert_allclose(at, speed[part], rtol=1e-14)
        # speeds of both grids differ by roundings
        allowed = error + off + 1e-9 * np.abs(torque[part]).max()
        assert np.max(np.abs(found - torque[part])) <= allowed
        most = np.asarray(run["response/torsion/largest/torque_half_range"].values)
        assert np.all(most <= top + allowed)


def test_a_run_up_on_mounts_goes_from_the_first_card_to_the_last() -> None:
    """Through a line that damps against the body, whose couple has no closed form over speed."""
    case = tomllib.loads(ON_BODY)
    train = case["machine"]["crank_train"]
    del train["gas_cycle"], case["response"]["torsion"]["misfire"]
    del case["response"]["torsion"]["misfire_kind"]
    train["gas_cards"] = [
        {"speed": f"{speed} rpm", "gas_pressure": CARD} for speed in (1400, 1450, 1500)
    ]
    case["isolation"]["run_up"] = {"from": "1400 rpm", "to": "1500 rpm"}
    case["excitation"]["orders"] = 3
    api.check(case)
    found = api.run(case)["isolation/support_force/run_up"]
    speed = next(np.asarray(axis.values) for axis in found.axes if axis.name == "speed")
    np.testing.assert_allclose([speed.min(), speed.max()], [1400 * RPM, 1500 * RPM], rtol=1e-14)


@pytest.mark.parametrize("width", [1.0, 1e-4, 1e-9])
def test_derivatives_of_a_couple_need_no_speed_beyond_its_ends(width: float) -> None:
    """Central in the middle, moved inwards at the ends; of a parabola they are exact there too."""
    low, high = 100.0, 100.0 * (1.0 + width)
    least, most = [], []

    def law(speed: Any) -> Bounded:
        least.append(speed.min())
        most.append(speed.max())
        value = np.stack([3.0 * speed, 2.0 * speed**2], axis=-1) + 0j
        return Bounded(value, 1e-15 * np.abs(value))

    at = np.linspace(low, high, 7)
    couple = couple_by_differences(law, low, high)(at, slopes=True)
    assert min(least) >= low and max(most) <= high
    slope = np.stack([np.full(7, 3.0), 4.0 * at], axis=-1)
    assert np.all(np.abs(couple.slope - slope) <= couple.slope_error + 1e-4 * slope)
