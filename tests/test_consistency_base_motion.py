"""Claim: a machine on a base that moves does what dense solves, quadrature and closed forms say."""

import copy
import itertools
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from shipped_cases import CASES

from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import NumericalFailure
from vibecalc.parts.machine import build_machine
from vibecalc.parts.matrices import displacement_at

MASS, FREQUENCY, RATIO = 120.0, 9.0, 0.03


def block(**base_motion: Any) -> dict[str, Any]:
    """A plain block on four springs at the height of its centre: its freedoms are apart."""
    w = 2.0 * np.pi * FREQUENCY
    k, c = MASS * w**2 / 4.0, 2.0 * RATIO * w * MASS / 4.0
    places = [[x, y, 0.0] for x in (-0.4, 0.4) for y in (-0.3, 0.3)]
    return {
        "schema": 1, "title": "block",
        "machine": {
            "kind": "plate",
            "body": {"mass": MASS, "inertia": [8.0, 9.0, 12.0]},
            "mounts": {"each": {"stiffness": k, "damping": c}, "positions": places},
        },
        "base_motion": base_motion,
    }  # fmt: skip


def spectrum(direction: str, low: float, high: float, value: float) -> dict[str, Any]:
    """White between two frequencies in Hz."""
    ends = [2.0 * np.pi * low, 2.0 * np.pi * high]
    return {"direction": direction, "acceleration": {"frequency": ends, "density": [value] * 2}}


def test_one_freedom_is_the_closed_form_and_miles() -> None:
    level = 0.02
    record = run_case(validate(block(spectra=[spectrum("z", 0.01, 2.0e4, level)])))
    r = record["base_motion/transmissibility"].axes[1].values / FREQUENCY
    drag, away = (2.0 * RATIO * r) ** 2, (1.0 - r**2) ** 2
    found = record["base_motion/transmissibility"].values[2]
    assert found == pytest.approx(np.sqrt((1.0 + drag) / (away + drag)), rel=1e-11)
    relative = record["base_motion/relative_transmissibility"].values[2]
    # against the base from the difference with it, which at low frequency is one of equal numbers
    assert relative == pytest.approx(r**2 / np.sqrt(away + drag), rel=1e-11, abs=1e-13)
    w = 2.0 * np.pi * FREQUENCY
    rms = record["base_motion/spectrum/relative_translation_rms"].values[2]
    # white at all frequencies: what is above 2000 times the resonance and below a thousandth of it
    missing = level * (0.01 + 1.0e-15) / w**4
    assert rms**2 + missing == pytest.approx(level / (8.0 * RATIO * w**3), rel=1e-9)
    accel = record["base_motion/spectrum/acceleration_rms"].values[2]
    tail = level * (2.0 * RATIO * FREQUENCY) ** 2 / 2.0e4
    exact = np.pi * FREQUENCY * level * (1.0 + 4.0 * RATIO**2) / (4.0 * RATIO)
    assert accel**2 + tail + 0.01 * level == pytest.approx(exact, rel=1e-7)
    miles = np.sqrt(0.5 * np.pi * FREQUENCY * level / (2.0 * RATIO))
    assert accel == pytest.approx(miles, rel=5e-3)
    peak = record["base_motion/spectrum/acceleration_peak"].values[2]
    assert peak == pytest.approx(3.0 * accel, rel=1e-15)
    assert record["base_motion/spectrum/base_acceleration_rms"].values[2] == pytest.approx(
        np.sqrt(level * (2.0e4 - 0.01)), rel=1e-12
    )
    assert record["base_motion/spectrum/acceleration_rms"].values[0] == pytest.approx(0.0, abs=1e-9)


@pytest.fixture(scope="module")
def deck() -> tuple[Any, Any]:
    (loaded,) = load_checked([CASES["genset_on_deck"]], [])
    table = copy.deepcopy(dict(loaded.resolved))
    table = {key: table[key] for key in ("schema", "title", "machine", "base_motion")}
    table["machine"]["mounts"]["positions"][0][2] = -0.3
    table["machine"]["mounts"]["each"]["damping"] = 500.0
    w = 2.0 * np.pi * np.array([2.0, 7.0, 31.0, 90.0])
    table["base_motion"]["spectra"] = [
        {"direction": "y", "velocity": {"frequency": w, "density": [1e-7, 4e-7, 2e-7, 1e-8]}},
        {"direction": "rx", "angular_acceleration": {
            "frequency": w[1:], "density": [2e-6, 9e-6, 1e-7]}},
    ]  # fmt: skip
    case = validate(table)
    return case, run_case(case)


#: by the number of a case: building one takes longer than a solve
BUILT: dict[int, Any] = {}


def machine_of(case: Any) -> Any:
    """Body and mounts of a case, built once."""
    if id(case) not in BUILT:
        BUILT[id(case)] = build_machine(case)
    return BUILT[id(case)]


def dense(case: Any, w: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[np.ndarray]]:
    """Dynamic and complex stiffness at w, motion of the reference point for one of the point."""
    machine = machine_of(case)
    arms = [displacement_at(place) for place in machine.mounts.position]
    parts = [k + 1j * (h + w * c) for k, c, h in zip(
        machine.mounts.stiffness, machine.mounts.damping, machine.mounts.structural,
        strict=True)]  # fmt: skip
    held = sum(a.T @ k @ a for a, k in zip(arms, parts, strict=True))
    x, y, z = case.base_motion.point
    turn = np.eye(6)
    turn[:3, 3:] = -np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return held - w**2 * machine.body.mass_matrix, held, turn, arms


def test_harmonics_are_dense_solves(deck: tuple[Any, Any]) -> None:
    case, record = deck
    root = "base_motion/harmonic"
    total = 0.0
    for n, one in enumerate(case.base_motion.harmonics):
        w = one.frequency
        dynamic, held, turn, arms = dense(case, w)
        said = np.zeros(6, dtype=complex)
        said[:3] = np.array(one.velocity) / (1j * w) * np.exp(1j * np.array(one.phase))
        if one.angular_velocity is not None:
            said[3:] = np.array(one.angular_velocity) / (1j * w)
        base = turn @ said
        motion = np.linalg.solve(dynamic, held @ base)
        assert record[f"{root}/translation"].values[n] == pytest.approx(motion[:3], rel=1e-9)
        assert record[f"{root}/relative_rotation"].values[n] == pytest.approx(
            motion[3:] - base[3:], rel=1e-9, abs=1e-15
        )
        assert record[f"{root}/acceleration"].values[n] == pytest.approx(
            -(w**2) * motion[:3], rel=1e-9
        )
        machine = machine_of(case)
        force = [
            (k + 1j * (h + w * c)) @ (a @ (motion - base))
            for k, c, h, a in zip(
                machine.mounts.stiffness, machine.mounts.damping, machine.mounts.structural, arms,
                strict=True,
            )
        ]  # fmt: skip
        mine = record[f"{root}/mount_force"].values[..., n]
        assert mine == pytest.approx(np.array(force), rel=1e-8, abs=1e-9)
        # what all mounts push on the base is what the body does not take for its inertia
        assert mine.sum(axis=0) == pytest.approx(
            (w**2 * machine.body.mass_matrix @ motion)[:3], rel=1e-8, abs=1e-8
        )
        angle = np.linspace(0.0, 2.0 * np.pi, 7201)
        course = (mine[0][:, None] * np.exp(1j * angle)).real
        total += np.linalg.norm(course, axis=0).max()
    assert record[f"{root}/mount_force_peak"].values[0] == pytest.approx(total, rel=1e-6)


def test_mean_squares_are_quadrature(deck: tuple[Any, Any]) -> None:
    case, record = deck
    first, second = case.base_motion.spectra

    def power(f: float, pick: str) -> float:
        w = 2.0 * np.pi * f
        dynamic, held, turn, arms = dense(case, w)
        whole = 0.0
        for one, column, factor in ((first.velocity, 1, w**2),
                                    (second.angular_acceleration, 3, 1.0)):  # fmt: skip
            if not one.frequency[0] <= w <= one.frequency[-1]:
                continue
            level = np.exp(np.interp(np.log(w), np.log(one.frequency), np.log(one.density)))
            base = -turn[:, column] / w**2
            motion = np.linalg.solve(dynamic, held @ base)
            found = {"acceleration": -(w**2) * motion[1], "rotation": motion[3],
                     "deflection": (arms[0] @ (motion - base))[1]}[pick]  # fmt: skip
            whole += float(np.abs(found) ** 2) * level * factor
        return whole

    free = np.linalg.solve(machine_of(case).body.mass_matrix, dense(case, 1e-9)[1].real)
    natural = np.sqrt(np.linalg.eigvals(free).real) / (2.0 * np.pi)
    ends = sorted({2.0, 7.0, 31.0, 90.0, *(f for f in natural if 2.0 < f < 90.0)})
    for pick, path, place in (
        ("acceleration", "acceleration_rms", 1), ("rotation", "rotation_rms", 0),
        ("deflection", "deflection_rms", (0, 1)),
    ):  # fmt: skip
        exact = sum(
            quad(power, low, high, args=(pick,), epsrel=1e-10, epsabs=0.0)[0]
            for low, high in itertools.pairwise(ends)
        )
        quantity = record[f"base_motion/spectrum/{path}"]
        assert quantity.values[place] == pytest.approx(np.sqrt(exact), rel=1e-9)
        assert quantity.error_estimate < 1e-9 * np.max(quantity.values)


def test_no_steady_motion_is_refused() -> None:
    table = block(harmonics=[{"name": "a", "frequency": 2.0 * np.pi * FREQUENCY,
                              "displacement": [0.0, 0.0, 1e-3]}])  # fmt: skip
    table["machine"]["mounts"]["each"]["damping"] = 0.0
    with pytest.raises(NumericalFailure, match=r"undamped|singular"):
        run_case(validate(table))
    table["base_motion"] = {"spectra": [spectrum("z", 5.0, 20.0, 1.0)]}
    with pytest.raises(NumericalFailure, match=r"mode 3 .* has no damping"):
        run_case(validate(table))
