"""Claim: each order, each mode and each speed has the stiffness of its own frequency."""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from mounted_sets import ran, tables
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator
from scipy.linalg import eigh
from scipy.optimize import minimize_scalar
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.results.store import read_result
from vibecalc.core.study.execute import load_checked
from vibecalc.parts.body import build_body

TURN = 2.0 * np.pi
ROWS = {
    "frequency": [2.0 * TURN, 8.0 * TURN, 30.0 * TURN, 120.0 * TURN],
    "stiffness_factor": [1.0, 1.15, 1.4, 2.1],
    "loss_factor": [0.06, 0.09, 0.11, 0.2],
}
PLACES = np.array([[0.1, -0.35, 0.0], [0.1, 0.35, 0.0], [1.7, -0.35, 0.0], [1.7, 0.35, 0.0]])


def case(**more: object) -> dict:
    """The set on rubber; the last mount has one stiffness and a damper."""
    data = tables()
    mounts = data["machine"]["mounts"]
    del mounts["positions"], mounts["each"]["loss_factor"]
    rubber = {"over_frequency": ROWS}
    mounts["individual"] = [
        {"name": str(n), "position": place.tolist(), **(rubber if n < 3 else {"damping": 900.0})}
        for n, place in enumerate(PLACES)
    ]
    return data | more


def flat_ends(at: Sequence[float], values: Sequence[float]) -> np.ndarray:
    slopes = PchipInterpolator(at, values).derivative()(at)
    slopes[[0, -1]] = 0.0
    return np.asarray(slopes)


def curve(values: list[float], at: float) -> float:
    """Monotone cubic, level at both ends and beyond."""
    rows = ROWS["frequency"]
    spline = CubicHermiteSpline(rows, values, flat_ends(rows, values))
    return float(spline(np.clip(at, rows[0], rows[-1])))


def passing(w: float) -> list[np.ndarray]:
    """What each mount passes on at a frequency, N/m."""
    s, eta = (curve(ROWS[key], w) for key in ("stiffness_factor", "loss_factor"))
    plain = np.diag([2e5, 2e5, 4e5]).astype(complex)
    return [s * (1.0 + 1j * eta) * plain] * 3 + [plain + 1j * w * 900.0 * np.eye(3)]


def there(place: np.ndarray) -> np.ndarray:
    return np.hstack([np.eye(3), np.cross(np.eye(3), place).T])


def suspension(w: float) -> np.ndarray:
    return np.sum(
        [there(p).T @ k @ there(p) for p, k in zip(PLACES, passing(w), strict=True)], axis=0
    )


def mass() -> np.ndarray:
    return np.asarray(build_body(validate(case()).machine.body).mass_matrix)


def forces(record: Record, speed: float, at: float) -> np.ndarray:
    """Complex forces (mounts, 3, orders) on the ground at a speed, by dense solves."""
    load = np.hstack([record["excitation/force"].values, record["excitation/couple"].values])
    found = []
    for n, one in enumerate(load, start=1):
        w = n * at
        body = np.linalg.solve(suspension(w) - w**2 * mass(), one * (at / speed) ** 2)
        found.append([k @ there(p) @ body for p, k in zip(PLACES, passing(w), strict=True)])
    return np.moveaxis(np.array(found), 0, -1)


def largest(force: np.ndarray) -> np.ndarray:
    """Largest length (mounts,) over a turn, by many angles and a refined one."""
    order = np.arange(1, force.shape[-1] + 1)

    def length(angle: float, one: np.ndarray) -> float:
        return float(np.linalg.norm((one * np.exp(1j * order * angle)).real.sum(-1)))

    peaks = []
    for one in force:
        angles = np.linspace(0.0, TURN, 61)
        best = angles[np.argmax([length(a, one) for a in angles])]
        found = minimize_scalar(
            lambda a, one=one: -length(a, one), bounds=(best - 0.11, best + 0.11), method="bounded",
            options={"xatol": 1e-9},
        )  # fmt: skip
        peaks.append(-found.fun)
    return np.array(peaks)


def test_forces_and_stiffness_of_each_order() -> None:
    record = ran(case(response={}))
    speed = validate(case()).machine.speed
    found, expected = (
        record["isolation/support_force/steady_harmonics"],
        forces(record, speed, speed),
    )
    kept = found.values.shape[-1]
    assert np.abs(found.values - expected[..., :kept]).max() < 1e-12 * np.abs(expected).max()
    assert found.error_estimate < 1e-11 * np.abs(expected).max()
    assert record["isolation/support_force/steady_peak"].values == pytest.approx(
        largest(expected), rel=1e-10
    )
    ground = record["response/ground_force"].values
    assert np.abs(ground - expected[..., :kept].sum(0).T).max() < 1e-11 * np.abs(expected).max()
    stiffness = record["isolation/mounts/order_stiffness"].values
    loss = record["isolation/mounts/order_loss_factor"].values
    for n in range(kept):
        w = (n + 1) * speed
        k = [one[2, 2] for one in passing(w)]
        assert stiffness[:, n] == pytest.approx([one.real for one in k], rel=1e-13)
        assert loss[0, n] == pytest.approx(k[0].imag / k[0].real, rel=1e-13)
        assert loss[3, n] == 0.0


def test_each_mode_is_that_of_its_own_frequency() -> None:
    record = ran(case(response={}))
    found = record["isolation/modes/natural_frequency"]
    for r, w in enumerate(found.values):
        squares, shapes = eigh(suspension(w).real, mass())
        assert squares[r] == pytest.approx(w**2, rel=1e-11)
        shape = record["isolation/modes/shape"].values[r]
        assert np.abs(np.abs(shapes[:, r] @ mass() @ shape) - 1.0) < 1e-9
        lag = shape @ suspension(w).imag @ shape / (2.0 * w**2)
        assert record["isolation/modes/damping_ratio"].values[r] == pytest.approx(lag, rel=1e-9)
    assert found.error_estimate < 1e-10 * found.values.max()
    modes = record["response/modes/natural_frequency"].values
    assert modes == pytest.approx(found.values, rel=1e-12)


def motions(record: Record, speed: float, at: float) -> np.ndarray:
    """Complex vertical motions (mounts, orders) at a speed."""
    load = np.hstack([record["excitation/force"].values, record["excitation/couple"].values])
    found = []
    for n, one in enumerate(load, start=1):
        body = np.linalg.solve(suspension(n * at) - (n * at) ** 2 * mass(), one * (at / speed) ** 2)
        found.append([(there(p) @ body)[2] for p in PLACES])
    return np.array(found).T


def test_travel_and_clearance_at_speed_and_in_the_run_up() -> None:
    data = case()
    for one in data["machine"]["mounts"]["individual"]:
        one["static"] = {"stops": {"down": 0.0055, "up": 0.02, "stiffness": 1e6}}
    data["isolation"]["run_up"] = {"from": 0.0, "to": "1500 rpm"}
    record, speed = ran(data), validate(data).machine.speed
    sag = record["isolation/support_displacement/sag"].values
    at_rest = record["isolation/mounts/clearance_at_rest"].values
    assert at_rest == pytest.approx(0.0055 - sag, rel=1e-9)
    travel, left = (record[f"isolation/mounts/{name}"].values for name in ("travel", "clearance"))
    angle = np.linspace(0.0, TURN, 7201)
    moving = motions(record, speed, speed)
    order = np.arange(1, moving.shape[-1] + 1)
    height = (moving[:, :, None] * np.exp(1j * np.outer(order, angle))).real.sum(1)
    assert travel == pytest.approx(np.abs(height).max(-1), rel=1e-6)
    assert left == pytest.approx(at_rest + height.min(-1), rel=1e-6)
    top = record["isolation/mounts/run_up_travel"].values
    at = record["isolation/mounts/run_up_travel_speed"].values
    for mount in range(4):
        moving = motions(record, speed, float(at[mount]))[mount]
        height = (moving[:, None] * np.exp(1j * np.outer(order, angle))).real.sum(0)
        assert top[mount] == pytest.approx(np.abs(height).max(), rel=1e-6)
    clearance = record["isolation/mounts/run_up_clearance"].values
    assert clearance == pytest.approx(at_rest - top, abs=1e-15)
    assert (clearance < 0.0).any() == any("in the run-up mount" in w for w in record.warnings)


def test_the_run_up_finds_the_maximum_of_all_speeds() -> None:
    data = case()
    data["isolation"]["run_up"] = {"from": 0.0, "to": "1500 rpm"}
    record, speed = ran(data), validate(data).machine.speed
    top = record["isolation/support_force/run_up_peak"].values
    at = record["isolation/support_force/run_up_peak_speed"].values
    for mount in (0, 3):
        here = largest(forces(record, speed, float(at[mount])))[mount]
        assert top[mount] == pytest.approx(here, rel=1e-9)
        share = 1.0 + (-1e-3 if mount else 1e-3)
        assert largest(forces(record, speed, float(at[mount] * share)))[mount] < here
    for rate in np.linspace(0.3, 1.0, 3) * speed:
        assert np.all(largest(forces(record, speed, float(rate))) <= top * (1.0 + 1e-9))
    curve_of = record["isolation/support_force/run_up"]
    speeds = curve_of.axes[1].values
    for place in range(5, len(speeds), len(speeds)):
        expected = largest(forces(record, speed, float(speeds[place])))
        assert curve_of.values[:, place] == pytest.approx(expected, rel=1e-8)


def test_the_set_on_its_skid_under_the_torque_of_its_cylinders() -> None:
    """Of the shipped case: loads of an order on the body, forces of its mounts, from its motion."""
    result = read_result(CASES["genset_skid"].parents[1] / "tests" / "golden" / "genset_skid.h5")
    record, loaded = result.record, load_checked([CASES["genset_skid"]])[0]
    root = "isolation/torque_reaction/"
    order = record[f"{root}couple"].axes[0].values
    motion = np.hstack(
        [record[f"isolation/body/{name}_harmonics"].values for name in ("translation", "rotation")]
    )
    nominal = record["isolation/mounts/stiffness"].values  # along z; across by the same rows
    rows = loaded.case.machine.mounts.each.over_frequency
    mounts, m = loaded.case.machine.mounts, build_body(loaded.case.machine.body).mass_matrix
    places = np.array(mounts.positions) + np.array(mounts.datum)
    matrix = np.array([[260e3, 260e3, 420e3]]) * (nominal / 420e3)[:, None]
    for n in (2.0, 4.0):
        at, w = int(np.argmin(np.abs(order - n))), n * loaded.case.machine.speed
        s, eta = (
            float(CubicHermiteSpline(rows.frequency, values, flat)(w))
            for values in (rows.stiffness_factor, rows.loss_factor)
            for flat in [flat_ends(rows.frequency, values)]
        )
        passes = [s * (1.0 + 1j * eta) * np.diag(one) for one in matrix]
        found = record["isolation/support_force/steady_harmonics"].values[:, :, at]
        force = [k @ there(p) @ motion[at] for k, p in zip(passes, places, strict=True)]
        assert np.abs(found - force).max() < 1e-9 * np.abs(found).max()
        dynamic = sum(there(p).T @ k @ there(p) for k, p in zip(passes, places, strict=True))
        load = (dynamic - w**2 * m) @ motion[at]
        shaking = record["excitation/force"].values[int(n) - 1]
        couple = np.cross(loaded.case.machine.crank_train.origin, shaking)
        couple[0] += record[f"{root}couple"].values[at]
        expected = np.concatenate([shaking, couple])
        assert np.abs(load - expected).max() < 1e-8 * np.abs(expected).max()


# ----------------------------------------------------------------------------
# On a foundation that is a body, and on a base that moves.
# ----------------------------------------------------------------------------

PLATE = np.array([0.9, 0.0, -0.5])
FEET = PLATE + np.array([[-1.2, -0.7, 0.0], [-1.2, 0.7, 0.0], [1.2, -0.7, 0.0], [1.2, 0.7, 0.0]])
BLADES = 14.0 * TURN
SENSOR = np.array([0.4, 0.2, 0.6])


def on_plate(**more: object) -> dict:
    """The set on a plate on springs, its base shaken, with a point that is read."""
    given = case(
        foundation={
            "kind": "body",
            "position": PLATE.tolist(),
            "body": {"mass": 900.0, "inertia": [150.0, 600.0, 700.0]},
            "springs": {
                "positions": (FEET - PLATE).tolist(),
                "each": {"stiffness": [2e7, 2e7, 8e6], "loss_factor": 0.05},
            },
        },
        base_motion={
            "harmonics": [
                {"name": "blades", "frequency": BLADES, "displacement": [1e-5, 0.0, 4e-5]}
            ]
        },
        point=[{"name": "top", "position": SENSOR.tolist()}],
    )
    given["isolation"] |= {"efficiency": True}
    return given | more


@cache
def of_plate() -> Record:
    return ran(on_plate())


def both_bodies(w: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness and mass (12, 12) of set and plate at a frequency; their motion with the base."""
    springs = np.diag([2e7, 2e7, 8e6]) * (1.0 + 0.05j)
    stiffness, inertia = np.zeros((12, 12), dtype=complex), np.zeros((12, 12))
    for p, k in zip(PLACES, passing(w), strict=True):
        rows = np.hstack([there(p), -there(p - PLATE)])
        stiffness += rows.T @ k @ rows
    for p in FEET - PLATE:
        stiffness[6:, 6:] += there(p).T @ springs @ there(p)
    inertia[:6, :6] = mass()
    inertia[6:, 6:] = np.diag([900.0] * 3 + [150.0, 600.0, 700.0])
    with_base = np.vstack([np.eye(6), np.eye(6)])
    with_base[6:9] = there(PLATE)
    return stiffness, inertia, with_base


def test_foundation_base_ground_and_points_see_the_stiffness_of_each_frequency() -> None:
    record, speed = of_plate(), validate(case()).machine.speed
    load = np.hstack([record["excitation/force"].values, record["excitation/couple"].values])
    force = record["isolation/support_force/steady_harmonics"].values
    ground = record["isolation/efficiency/force/ground"].values
    plate = record["foundation/coupled/body/translation"].values
    for n, one in enumerate(load):
        w = (n + 1) * speed
        stiffness, inertia, with_base = both_bodies(w)
        motion = np.linalg.solve(stiffness - w**2 * inertia, np.append(one, np.zeros(6)))
        expected = [
            k @ (there(p) @ motion[:6] - there(p - PLATE) @ motion[6:])
            for p, k in zip(PLACES, passing(w), strict=True)
        ]
        assert np.abs(force[..., n] - expected).max() < 1e-11 * np.abs(force).max()
        sent = (with_base.T @ stiffness @ motion)[:3]
        assert np.abs(ground[n] - sent).max() < 1e-11 * np.abs(ground).max()
        assert np.abs(plate[n] - motion[6:9]).max() < 1e-11 * np.abs(plate).max()
    stiffness, inertia, with_base = both_bodies(BLADES)
    carried = with_base @ np.array([1e-5, 0.0, 4e-5, 0.0, 0.0, 0.0])
    moved = np.linalg.solve(stiffness - BLADES**2 * inertia, stiffness @ carried)
    read = there(SENSOR) @ moved[:6]
    found = record["base_motion/harmonic/point_displacement"].values[:, 0]
    assert np.abs(found - read).max() < 1e-11 * np.abs(read).max()
    peak = record["base_motion/harmonic/point_velocity_peak"].values
    assert peak == pytest.approx(BLADES * np.abs(read), rel=1e-11)


def test_modes_of_set_and_plate_have_the_stiffness_of_their_own_frequency() -> None:
    frequency = of_plate()["foundation/coupled/modes/natural_frequency"].values
    for place, w in enumerate(frequency):
        stiffness, inertia, _ = both_bodies(float(w))
        own = np.sqrt(eigh(stiffness.real, inertia, eigvals_only=True)[place])
        assert own == pytest.approx(float(w), rel=1e-10)


def test_random_motion_of_the_base_at_a_point_is_that_of_the_body_there() -> None:
    density = {"frequency": [3.0 * TURN, 60.0 * TURN], "density": [1e-3, 1e-4]}
    base = {"spectra": [{"direction": "z", "acceleration": density}]}
    points = [{"name": "there", "position": [0.0, 0.0, 0.0]}]
    record = ran(on_plate(base_motion=base, point=points))
    for name, of_body in (
        ("displacement", "translation"), ("velocity", "velocity"), ("acceleration", "acceleration"),
    ):  # fmt: skip
        for kind in ("rms", "peak"):
            at_point = record[f"base_motion/spectrum/point_{name}_{kind}"].values
            own = record[f"base_motion/spectrum/{of_body}_{kind}"].values
            assert at_point == pytest.approx(own, rel=1e-6)
