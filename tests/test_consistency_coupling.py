"""Claim: elastic couplings are what dense solves under their own conditions say, use included.

The truth: the full matrices of `dense_line.py`, brackets halved for what heats; nothing of the
program takes part but the torques of its cylinders.
"""

import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pytest
from dense_line import Array, Conditions, DenseLine, ends, half_range
from long_but import long_but
from scipy.optimize import brentq
from shipped_cases import CASES

from vibecalc.core.case.data_files import attach_files
from vibecalc.core.case.load import resolve, validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure


class Standing(NamedTuple):
    """Torques (m,) of the coupling and angles (stations, m) by order, power loss, conditions."""

    order: Array
    torque: Array
    angle: Array
    power: float
    conditions: Conditions

    @property
    def lowest(self) -> float:
        return float(ends(self.order, self.torque)[0])

    @property
    def highest(self) -> float:
        return float(ends(self.order, self.torque)[1])

    @property
    def half_range(self) -> float:
        return float(half_range(self.order, self.torque))


class CoupledLine(DenseLine):
    """A line with one coupling, of a resolved case."""

    def __init__(self, case: Mapping[str, Any]):
        super().__init__(dict(case))
        shafts = self.line["shafts"]
        self.place = next(n for n, one in enumerate(shafts) if "coupling" in one)
        self.given = shafts[self.place]["coupling"]

    def in_conditions(self, speed: float, order: Array, load: Array, now: Conditions) -> Standing:
        """For torques (stations, m)."""
        found = self.under(speed, order * speed, load, np.zeros(self.count), now)
        heat = self.heat(found, speed)[0][self.place]
        return Standing(order, found.torque[self.place], found.angle, float(heat), now)

    def standing(self, speed: float, order: Array, load: Array, mean: float) -> Standing:
        """With the temperature and the vibratory torque that stand."""
        given = self.given
        air = given.get("ambient_temperature", 0.0)
        permitted = given.get("power_loss")
        if "power_loss_over_temperature" in given:
            rows = given["power_loss_over_temperature"]
            permitted = np.interp(air, rows["temperature"], rows["power_loss"])
        resistance = given.get("thermal_resistance", 0.0)
        if "temperature_rise" in given:
            resistance = given["temperature_rise"] / permitted
        start = given.get("temperature", air)

        def at(temperature: float) -> Standing:
            def missing(amplitude: float) -> float:
                now = Conditions(mean, temperature, amplitude)
                return self.in_conditions(speed, order, load, now).half_range - amplitude

            amplitude = 0.0
            if "over_amplitude" in given:
                amplitude = _root(missing, 0.0, 2.0 * given["over_amplitude"]["torque"][-1])
            return self.in_conditions(speed, order, load, Conditions(mean, temperature, amplitude))

        if not resistance or "over_temperature" not in given:
            found = at(start)
            warm = found.conditions._replace(temperature=start + resistance * found.power)
            return found._replace(conditions=warm)
        top = given["over_temperature"]["temperature"][-1]
        return at(_root(lambda one: air + resistance * at(one).power - one, air, top))

    def natural(self, now: Conditions, number: int) -> float:
        """Frequency of an undamped mode, counted from 0, of the line at this frequency itself."""
        w = 0.0
        for _ in range(200):
            w = float(self.undamped(self.speed, w, now)[number])
        return w


def _root(missing: Callable[[float], float], low: float, high: float) -> float:
    """The first root from below: steps until the sign changes, then a bracket closed."""
    steps = np.linspace(low, high, 41)
    for left, right in pairwise(steps.tolist()):
        if missing(right) <= 0.0:
            return float(brentq(missing, left, right, xtol=1e-12, rtol=1e-14))
    raise AssertionError("no root")


# ----------------------------------------------------------------------------
# What a run says.
# ----------------------------------------------------------------------------

ROOT = "response/torsion"
PATH = CASES["genset_coupling"]
LIMITS = {
    "nominal_torque": "16 kN*m",
    "maximum_torque": "40 kN*m",
    "vibratory_torque": "5 kN*m",
    "power_loss": "1.2 kW",
    "maximum_speed": "1600 rpm",
}
OVER_FREQUENCY = {
    "frequency": ["0 Hz", "8 Hz", "30 Hz", "120 Hz"],
    "stiffness_factor": [1.0, 1.1, 1.3, 1.45],
    "relative_damping_factor": [0.8, 1.0, 1.5, 1.7],
}
OVER_TEMPERATURE = {
    "temperature": ["20 degC", "50 degC", "80 degC", "130 degC"],
    "stiffness_factor": [1.0, 0.9, 0.78, 0.65],
    "relative_damping_factor": [1.0, 0.9, 0.8, 0.7],
    "service_factor": [1.0, 1.2, 1.4, 2.0],
}
PLAIN = {"stiffness": "80 kN*m/rad", "relative_damping": 1.13, **LIMITS}
#: name -> a coupling instead of that of the case
COUPLINGS: dict[str, dict[str, Any] | None] = {
    "catalogue": None,
    "constant": PLAIN,
    "mean torque": {
        "relative_damping": 1.13,
        "over_mean_torque": {
            "torque": ["0 N*m", "6 kN*m", "12 kN*m", "18 kN*m"],
            "stiffness": ["50 kN*m/rad", "58 kN*m/rad", "77 kN*m/rad", "110 kN*m/rad"],
        },
        **LIMITS,
    },
    "frequency": {**PLAIN, "over_frequency": OVER_FREQUENCY},
    "temperature given": {**PLAIN, "over_temperature": OVER_TEMPERATURE, "temperature": "65 degC"},
    "temperature": {
        **PLAIN,
        "over_temperature": OVER_TEMPERATURE,
        "ambient_temperature": "40 degC",
        "thermal_resistance": "0.2 K/W",
        "maximum_temperature": "110 degC",
    },
    "amplitude": {
        **PLAIN,
        "over_amplitude": {
            "torque": ["0 N*m", "800 N*m", "6 kN*m"],
            "stiffness_factor": [1.2, 1.05, 0.8],
            "relative_damping_factor": [0.7, 1.0, 1.3],
        },
    },
    "behind a gear": {
        **PLAIN,
        "stiffness": "320 kN*m/rad",
        "over_mean_torque": {
            "torque": ["0 N*m", "18 kN*m", "36 kN*m"],
            "stiffness_factor": [0.8, 1.0, 1.3],
        },
        "over_frequency": OVER_FREQUENCY,
        "over_temperature": OVER_TEMPERATURE,
        "ambient_temperature": "40 degC",
        "thermal_resistance": "0.1 K/W",
    },
    "heat without rows": {
        **PLAIN,
        "ambient_temperature": "40 degC",
        "thermal_resistance": "0.2 K/W",
    },
}


def case_with(name: str, **torsion: Any) -> dict[str, Any]:
    """The shipped case as tables, with another coupling, without its range of speeds."""
    data = tomllib.loads(PATH.read_text(encoding="utf-8"))
    data = {key: one for key, one in data.items() if not key.startswith(("reference", "limit"))}
    if COUPLINGS[name] is not None:
        data["machine"]["shaft_line"]["shafts"][6]["coupling"] = dict(COUPLINGS[name] or {})
    data["response"]["torsion"].pop("speeds")
    data["response"]["torsion"].update(torsion)
    assert not attach_files(data, PATH.parent)
    if name == "behind a gear":
        put_behind_a_gear(data["machine"]["shaft_line"])
    return data


def put_behind_a_gear(line: dict[str, Any]) -> None:
    """At half the speed, the other way round."""
    behind = {"flywheel": 260.0, "wheel": 40.0, "hub": 56.0, "generator": 940.0}
    line["stations"][6:] = [{"name": name, "inertia": inertia} for name, inertia in behind.items()]
    names = [one["name"] for one in line["stations"]]
    ends = [*pairwise(names[:7]), ("wheel", "hub")]
    line["shafts"] = [
        *(
            {**one, "between": list(pair)}
            for one, pair in zip(line["shafts"][:7], ends, strict=True)
        ),
        {"name": "rotor shaft", "between": ["hub", "generator"], "stiffness": 44e6},
    ]
    line["gears"] = [{"between": ["flywheel", "wheel"], "ratio": 0.5}]


@cache
def ran(name: str, speed: float) -> tuple[dict[str, Any], Record]:
    data = case_with(name)
    data["machine"]["speed"] = speed
    case = validate(data)
    record = run_case(case)
    assert set(record) == set(planned_quantities(case))
    return resolve(case), record


def value(record: Record, path: str) -> np.ndarray:
    return np.asarray(record[f"{ROOT}/{path}"].values)


#: each law that random lines do not have; with these the others are left to the long tests
QUICK = ("catalogue", "temperature", "amplitude")
SPEEDS = (480.0 * np.pi / 30.0, 750.0 * np.pi / 30.0)


@pytest.mark.parametrize("speed", long_but(SPEEDS, SPEEDS[0]))
@pytest.mark.parametrize("name", long_but(COUPLINGS, *QUICK))
def test_coupling_is_what_a_dense_solve_says(name: str, speed: float) -> None:
    case, record = ran(name, speed)
    line = CoupledLine(case)
    load, order = value(record, "excitation/station_torque"), np.arange(1, 25) / 2.0
    # own values of its shaft, whose sense and speed a gear changes
    ratio = float(line.ratio[line.names.index(line.between[line.place][0])])
    mean = float(value(record, "excitation/mean_torque")) / ratio
    found = line.standing(speed, order, load, mean)
    place = list(record[f"{ROOT}/torque"].axes[0].values).index("elastic coupling")
    torque = value(record, "torque")[place]
    assert np.abs(torque - found.torque).max() < 1e-9 * np.abs(found.torque).max()

    def same(path: str, expected: float) -> None:
        assert float(value(record, f"coupling/{path}")[0]) == pytest.approx(expected, rel=1e-9)

    same("mean_torque", mean)
    same("vibratory_torque", found.half_range)
    same("power_loss", found.power)
    same("peak_torque", max(abs(mean + found.highest), abs(mean + found.lowest)))
    turning = found.angle[-1]
    electrical = half_range(order, turning)
    uneven = 2.0 * half_range(order, order * 1j * turning) / abs(ratio)
    assert value(record, "irregularity/degree") == pytest.approx([uneven], rel=1e-9)
    assert value(record, "irregularity/electrical_angle") == pytest.approx(
        [4.0 * electrical], rel=1e-9
    )
    if "ambient_temperature" in line.given or "temperature" in line.given:
        same("temperature", found.conditions.temperature)
    factor = np.sqrt(np.maximum(order * speed / (20.0 * np.pi), 1.0))
    by_orders = np.sqrt(np.sum(np.abs(factor * found.torque) ** 2))
    same("torque_by_orders", by_orders)
    may, hot = line.given, 1.0
    if "service_factor" in may.get("over_temperature", {}):
        rows = may["over_temperature"]
        hot = float(
            np.interp(found.conditions.temperature, rows["temperature"], rows["service_factor"])
        )
    power = may.get("power_loss") or np.interp(
        may["ambient_temperature"], *may["power_loss_over_temperature"].values()
    )
    main = factor[np.argmax(np.abs(found.torque))]
    expected = {
        "T_KN": abs(mean) * hot / may["nominal_torque"],
        "T_Kmax": max(mean + found.highest, -mean - found.lowest) * hot / may["maximum_torque"],
        "T_KW": found.half_range * main * hot / may["vibratory_torque"],
        "T_KW by orders": by_orders * hot / may["vibratory_torque"],
        "P_KV": found.power / power,
        "n_max": speed * abs(ratio) / may["maximum_speed"],
    }
    if "maximum_temperature" in may:
        air = may["ambient_temperature"]
        rise = found.conditions.temperature - air
        expected["temperature"] = rise / (may["maximum_temperature"] - air)
    use = record[f"{ROOT}/coupling/utilisation"]
    assert list(use.axes[1].values) == list(expected)
    assert use.values[0] == pytest.approx(list(expected.values()), rel=1e-9)


@pytest.mark.parametrize("name", ["catalogue", "constant", "amplitude"])
def test_modes_are_of_the_line_at_their_own_frequency(name: str) -> None:
    case, record = ran(name, SPEEDS[1])
    amplitude = float(value(record, "coupling/vibratory_torque")[0])
    known = f"{ROOT}/coupling/temperature" in record
    temperature = float(value(record, "coupling/temperature")[0]) if known else 0.0
    assert known == (name == "catalogue")  # none is no temperature of 0 K
    mean = float(value(record, "excitation/mean_torque"))
    line, now = CoupledLine(case), Conditions(mean, temperature, amplitude)
    expected = [line.natural(now, number) for number in range(1, 6)]
    for path in ("natural_frequency", "transfer_matrix_frequency"):
        assert value(record, f"modes/{path}")[1:6] == pytest.approx(expected, rel=1e-9)
    table, shape = value(record, "modes/holzer_residual"), value(record, "modes/holzer_torque")
    assert np.abs(table[1:4]).max() < 1e-6 * np.abs(shape[1:4]).max()


@pytest.mark.long
def test_largest_use_is_between_the_speeds_of_the_sweep() -> None:
    """Next to the resonance of order 0.5: single runs there and on both sides of it."""
    speeds = {"from": "380 rpm", "to": "520 rpm", "points": 15}
    record = run_case(validate(case_with("frequency", speeds=speeds)))
    use, at = (
        record[f"{ROOT}/coupling/largest_{name}"] for name in ("utilisation", "utilisation_speed")
    )
    for place, name in enumerate(use.axes[1].values):
        if name in ("T_KN", "n_max"):
            continue
        speed, top = float(at.values[0, place]), float(use.values[0, place])
        below, here, above = (
            float(value(ran("frequency", one)[1], "coupling/utilisation")[0, place])
            for one in (speed * 0.999, speed, speed * 1.001)
        )
        assert here == pytest.approx(top, rel=1e-9), name
        assert max(below, above) < here, name


@pytest.mark.long
def test_criticals_are_of_the_line_at_that_speed() -> None:
    """The resonance of order 0.5 of a coupling that stiffens with frequency and is softer warm."""
    speeds = {"from": "300 rpm", "to": "900 rpm", "points": 31}
    case = validate(case_with("frequency", speeds=speeds))
    met = value(run_case(case), "critical/speed")[1]
    line = CoupledLine(resolve(case))
    inside = (met > 0.9 * 10.0 * np.pi) & (met < 30.0 * np.pi)
    assert np.any(inside)
    for speed in met[inside]:
        order = round(line.natural(Conditions(0.0, 0.0, 0.0), 1) / speed * 2.0) / 2.0
        assert order * speed == pytest.approx(line.natural(Conditions(0.0, 0.0, 0.0), 1), rel=1e-9)


def test_thermal_runaway_is_named() -> None:
    data = case_with("temperature")
    data["machine"]["shaft_line"]["shafts"][6]["coupling"]["thermal_resistance"] = "20 K/W"
    data["machine"]["speed"] = "420 rpm"
    with pytest.raises(NumericalFailure, match=r"'elastic coupling' at 420 rpm: thermal runaway"):
        run_case(validate(data))


def test_a_line_with_a_damper_has_its_poles_at_their_own_frequency() -> None:
    """Each pole, put into the dense matrix at its own magnitude, leaves it singular."""
    data = case_with("frequency")
    ring = {"name": "ring", "on": "throw 1", "kind": "viscous", "inertia": 6.0, "damping": 2500.0}
    data["machine"]["shaft_line"]["dampers"] = [ring]
    data["machine"]["speed"] = SPEEDS[0]
    case = validate(data)
    record, line = run_case(case), CoupledLine(resolve(case))
    natural, ratio = (
        value(record, f"modes/{name}") for name in ("natural_frequency", "damping_ratio")
    )
    elastic = np.flatnonzero(natural > 0.0)[:5]
    assert len(elastic) == 5
    inertia = np.diag(line.inertia)
    for w, zeta in zip(natural[elastic], ratio[elastic], strict=True):
        pole = w * complex(-zeta, np.sqrt(1.0 - zeta**2))
        springs, dashpot = line.section_laws(SPEEDS[0], np.array([w]), np.zeros(len(line.rows)))
        # a loss factor is the dashpot eta k / w, here as everywhere
        elements = springs[:, 0].real + pole * (springs[:, 0].imag / w + dashpot)
        matrix = pole**2 * inertia + pole * np.diag(line.absolute(SPEEDS[0]))
        matrix = matrix + line.network.T @ (elements[:, None] * line.network)
        scale = np.sqrt(np.abs(np.diag(matrix)))
        small = np.linalg.svd(matrix / np.outer(scale, scale), compute_uv=False)
        assert small[-1] < 1e-9 * small[0]
