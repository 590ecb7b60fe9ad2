"""Claim: a body rests on curved mounts and stops where its energy is least, and moves about it."""

import itertools

import numpy as np
import pytest
from mounted_sets import ran, tables
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator
from scipy.optimize import brentq, minimize
from scipy.spatial.transform import Rotation

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.errors import NumericalFailure
from vibecalc.parts.cautions import implausible
from vibecalc.parts.mount_curves import Level, TangentByLoad
from vibecalc.parts.mount_state import mounts_of

CURVE = {"deflection": [-0.002, 0.0, 0.002, 0.004, 0.007], "load": [-300, 0, 500, 1400, 4500]}
STOPS = {"down": 0.0035, "up": 0.004, "stiffness": 3e6}


def with_mounts(kind: str) -> dict:
    """The set on mounts of some kind, all but the last one alike."""
    data = tables()
    mounts = data["machine"]["mounts"]
    places = mounts.pop("positions")
    static = {
        "cubic": {"dynamic_to_static": 1.4, "cubic_stiffness": 8e9},
        "curve": {"dynamic_to_static": 1.2, "load_deflection": CURVE},
        "stops": {"cubic_stiffness": 1e8, "stops": STOPS},
    }[kind]
    mounts["each"] |= {"static": static, "damping": 300.0}
    mounts["individual"] = [
        {"name": f"m{n}", "position": place, "orientation": [0.2 * s, -0.1 * s, 0.0]}
        for n, (place, s) in enumerate(zip(places, (1, -1, 1, -1), strict=True))
    ]
    mounts["individual"][3]["static"] = {"axis": "z"}  # straight, as its dynamic stiffness
    return data


class Plain:
    """The same body and mounts written anew: energy, loads on the body and its tangent."""

    def __init__(self, data: dict, ratio_of_dynamic: bool = False):
        machine = data["machine"]
        parts = machine["body"]["parts"]
        self.mass = np.array([part["mass"] for part in parts], dtype=float)
        self.centre = self.mass @ np.array([part["centre"] for part in parts]) / self.mass.sum()
        each = machine["mounts"]["each"]
        self.mounts = []
        for one in machine["mounts"]["individual"]:
            turn = Rotation.from_euler("xyz", one["orientation"]).as_matrix()
            static = one.get("static", each["static"])
            ratio = static.get("dynamic_to_static", 1.0)
            k = np.array([2e5, 2e5, 4e5]) / ratio
            self.mounts.append((np.array(one["position"]), turn, k, static, ratio))

    @staticmethod
    def load(static: dict, k: float, u: float) -> float:
        if "load_deflection" in static:
            curve = static["load_deflection"]
            found = float(PchipInterpolator(curve["deflection"], curve["load"])(u))
        else:
            found = k * u + static.get("cubic_stiffness", 0.0) * u**3
        stops = static.get("stops")
        if stops:
            found += stops["stiffness"] * (max(u - stops["down"], 0) - max(-u - stops["up"], 0))
        return found

    def of_origin(self, body: np.ndarray) -> np.ndarray:
        """Motion (6,) of the reference point for one of the mass centre."""
        return np.concatenate([body[:3] - np.cross(body[3:], self.centre), body[3:]])

    def loads(self, x: np.ndarray) -> np.ndarray:
        """Forces and couples (6,) of mounts and weight on the body."""
        weight = np.array([0.0, 0.0, -self.mass.sum() * 9.80665])
        total = np.concatenate([weight, np.cross(self.centre, weight)])
        for place, turn, k, static, _ in self.mounts:
            own = turn.T @ (x[:3] + np.cross(x[3:], place))
            force = turn @ np.array(
                [-k[0] * own[0], -k[1] * own[1], self.load(static, k[2], -own[2])]
            )
            total += np.concatenate([force, np.cross(place, force)])
        return total

    def energy(self, x: np.ndarray) -> float:
        height = x[2] + np.cross(x[3:], self.centre)[2]
        total = self.mass.sum() * 9.80665 * height
        for place, turn, k, static, _ in self.mounts:
            own = turn.T @ (x[:3] + np.cross(x[3:], place))
            total += 0.5 * k[0] * own[0] ** 2 + 0.5 * k[1] * own[1] ** 2
            corners = [c for c in (*CURVE["deflection"], STOPS["down"]) if 0 < c < -own[2]]
            total += quad(
                lambda u, s=static, kk=k[2]: self.load(s, kk, u), 0.0, -own[2],
                points=corners or None, epsabs=1e-11, epsrel=1e-12,
            )[0]  # fmt: skip
        return total


def test_no_other_place_has_less_energy() -> None:
    data = with_mounts("stops")
    plain = Plain(data)
    scale = np.array([1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3])
    found = minimize(lambda y: plain.energy(scale * y), np.zeros(6), method="BFGS")
    rest = plain.of_origin(mounts_of(validate(data)).rest.body.value)
    assert np.abs(scale * found.x - rest).max() < 1e-7
    assert plain.energy(rest) <= found.fun + 1e-9 * abs(found.fun)


def test_one_mount_by_hand() -> None:
    """Four equal mounts under a body in their middle: a cube, and a straight stop."""
    data = tables()
    data["machine"]["body"]["parts"] = [
        {"name": "all", "mass": 800.0, "centre": [0.9, 0.0, 0.3], "inertia": [40, 90, 100]}
    ]
    weight, k, cubic = 200.0 * 9.80665, 4e5 / 1.3, 5e9
    each = data["machine"]["mounts"]["each"]
    each["static"] = {"dynamic_to_static": 1.3, "cubic_stiffness": cubic}
    record = ran(data)
    sag = brentq(lambda u: k * u + cubic * u**3 - weight, 0.0, 0.01, xtol=1e-16)
    assert record["isolation/support_displacement/static"].values == pytest.approx(sag, rel=1e-12)
    assert record["isolation/support_force/static"].values == pytest.approx(weight, rel=1e-12)
    tangent = k + 3.0 * cubic * sag**2
    assert record["isolation/mounts/static_stiffness"].values == pytest.approx(tangent, rel=1e-12)
    stiffness = record["isolation/mounts/stiffness"].values
    assert stiffness == pytest.approx(1.3 * tangent, rel=1e-12)
    heave = np.sqrt(4.0 * 1.3 * tangent / 800.0)
    frequency = record["isolation/modes/natural_frequency"].values
    assert np.abs(frequency / heave - 1.0).min() < 1e-12

    each["static"] = {"stops": {"down": 0.004, "stiffness": 2e6}}
    record = ran(data)
    deep = (weight + 2e6 * 0.004) / (4e5 + 2e6)
    assert record["isolation/mounts/deflection"].values == pytest.approx(deep, rel=1e-12)
    left = record["isolation/mounts/clearance_at_rest"].values
    assert left == pytest.approx(0.004 - deep, rel=1e-9)
    assert any("stands on its stop at rest" in text for text in record.warnings)

    each["static"] = {"dynamic_to_static": 1.25}  # the sag alone changes
    given = ran(data)
    del each["static"]
    plain = ran(data)
    for path, ratio in (
        ("isolation/support_displacement/static", 1.25),
        ("isolation/support_force/steady_peak", 1.0),
    ):
        assert given[path].values == pytest.approx(ratio * plain[path].values, rel=1e-12)


def test_over_load_picks_the_stiffness_of_the_load() -> None:
    data = tables()
    rows = {"load": [500.0, 1000.0, 1500.0, 2500.0], "stiffness_factor": [0.8, 0.9, 1.0, 1.35]}
    data["machine"]["mounts"]["each"]["over_load"] = rows
    mounts = mounts_of(validate(data))
    curve = PchipInterpolator(rows["load"], rows["stiffness_factor"])
    flat = curve.derivative()(rows["load"])
    flat[[0, -1]] = 0.0
    factor = CubicHermiteSpline(rows["load"], rows["stiffness_factor"], flat)(
        mounts.rest.load.value
    )
    expected = factor[:, None, None] * np.diag([2e5, 2e5, 4e5])
    assert mounts.stiffness == pytest.approx(expected, rel=1e-12)
    # at rest the tangent of the load over deflection is that of the load too
    static = np.array([np.diag([2e5, 2e5, 4e5 * one]) for one in factor])
    assert mounts.static == pytest.approx(static, rel=1e-12)
    rows["load"] = [10.0, 20.0, 30.0, 1700.0]
    record = ran(data)
    assert sum("beyond its rows of over_load" in text for text in record.warnings) == 2


def in_the_middle(**properties: object) -> dict:
    """800 kg above the middle of four equal mounts."""
    data = tables()
    data["machine"]["body"]["parts"] = [
        {"name": "all", "mass": 800.0, "centre": [0.9, 0.0, 0.3], "inertia": [40, 90, 100]}
    ]
    data["machine"]["mounts"]["each"] = {"loss_factor": 0.1, **properties}
    return data


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


def test_load_deflection_stands_for_the_stiffness_along_its_axis() -> None:
    static = {"dynamic_to_static": 1.2, "load_deflection": CURVE}
    given = in_the_middle(stiffness=[2e5, 2e5, 4e5], static=static)
    (said,) = machine_warnings(validate(given))
    assert "load_deflection sets the stiffness along its axis" in said and "'1', '2'" in said
    without = in_the_middle(stiffness=[2e5, 2e5, 0.0], static=static)
    assert machine_warnings(validate(without)) == []
    first, second = ran(given), ran(without)
    for path in (
        "support_displacement/static",
        "mounts/stiffness",
        "support_force/steady_peak",
    ):
        known = first[f"isolation/{path}"].values
        assert second[f"isolation/{path}"].values == pytest.approx(known, rel=1e-14)
    with pytest.raises(NumericalFailure, match="leave the body free in some direction"):
        ran(in_the_middle(static=static))
    # with over_load it is the dynamic stiffness where the factor is 1, and counts
    rows = {"load": [500.0, 3000.0], "stiffness_factor": [1.0, 1.0]}
    both = in_the_middle(stiffness=[2e5, 2e5, 4e5], static=static, over_load=rows)
    assert machine_warnings(validate(both)) == []
    assert ran(both)["isolation/mounts/stiffness"].values == pytest.approx(4e5, rel=1e-14)


def test_the_warning_of_the_sag_is_that_of_the_load_over_deflection() -> None:
    soft = {"deflection": [0.0, 1.0], "load": [0.0, 4000.0]}
    stiff = {"deflection": [0.0, 0.01], "load": [0.0, 4000.0]}
    for across, rows, deep in ((4e5, soft, "0.49 m"), (3e3, stiff, "")):
        data = in_the_middle(stiffness=[2e5, 2e5, across], static={"load_deflection": rows})
        said = [one for one in implausible(validate(data)) if "static deflection" in one]
        assert [f"is about {deep}," in one for one in said] == [True] * bool(deep)


def test_small_motions_in_time_are_those_about_the_rest() -> None:
    """The mounts' own cubes in time, six freedoms, under the orders of the crank train."""
    data = with_mounts("cubic")
    data["machine"]["mounts"]["each"] |= {"damping": 3000.0, "loss_factor": 0.0}
    for one in data["machine"]["mounts"]["individual"]:
        one["static"] = {"cubic_stiffness": 8e9}
    data["machine"]["crank_train"]["reciprocating_mass"] = 0.014
    data["excitation"]["orders"] = 2
    record = ran(data)
    plain = Plain(data)
    case = validate(data)
    from vibecalc.parts.body import build_body

    inverse = np.linalg.inv(build_body(case.machine.body).mass_matrix)
    rest = plain.of_origin(mounts_of(case).rest.body.value)
    force = np.concatenate(
        [record["excitation/force"].values, record["excitation/couple"].values], axis=-1
    )
    speed, orders = case.machine.speed, np.arange(1, len(force) + 1)
    damper = np.zeros((6, 6))
    for place, *_ in plain.mounts:
        there = np.hstack([np.eye(3), np.cross(np.eye(3), place).T])  # columns e_i x place
        damper += 3000.0 * there.T @ there

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        shaken = (force * np.exp(1j * orders * speed * t)[:, None]).real.sum(0)
        pull = plain.loads(y[:6]) - damper @ y[6:] + shaken
        return np.concatenate([y[6:], inverse @ pull])

    body = np.concatenate(
        [record[f"isolation/body/{name}_harmonics"].values for name in ("translation", "rotation")],
        axis=-1,
    )
    turn = 2.0 * np.pi / speed
    times = 1.0 * turn + np.arange(16) * turn / 16.0
    linear = (body[:, None] * np.exp(1j * np.outer(orders, speed * times))[..., None]).real.sum(0)
    first = np.concatenate([body.real.sum(0), (1j * (orders * speed)[:, None] * body).real.sum(0)])
    first[:6] += rest
    marched = solve_ivp(rates, (0.0, 2.0 * turn), first, "DOP853", times, rtol=1e-8, atol=1e-12)
    off = marched.y[:6].T - rest - linear
    assert np.abs(off).max() < 1e-4 * np.abs(linear).max()  # a tenth of the mass: a hundredth of it


def test_loads_beyond_the_rows_and_bodies_adrift_are_failures() -> None:
    data = with_mounts("curve")
    data["machine"]["body"]["parts"][0]["mass"] = 20000.0
    with pytest.raises(NumericalFailure, match=r"carries .* beyond its rows of load_deflection"):
        ran(data)
