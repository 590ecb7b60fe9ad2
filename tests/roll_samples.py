"""Results for the tests of the report: a two-stage compressor on its shell, made up by harmonics.

Amplitudes and phases have the size of those of Herold (1977), appendix A; nothing here solves an
equation of motion.
"""

from typing import Any

import numpy as np
from report_samples import quantity, result_of

from vibecalc.core.results.record import Axis, Quantity, Record, Result

RPM = 2.0 * np.pi / 60.0
SYNCHRONOUS, SPEED = 900.0 * RPM, 887.0 * RPM
ORDERS = Axis(name="order", values=np.arange(1, 11))
CYLINDERS = Axis(name="cylinder", values=np.array(["first stage", "second stage"], object))
TURN = Axis(name="crank_angle", values=np.linspace(0.0, 2.0 * np.pi, 361), unit="rad")
INTERPOLANTS = Axis(
    name="interpolant",
    values=np.array(["linear", "parabola", "cubic", "trigonometric"], object),
)
METHODS = Axis(name="method", values=np.array(["fourier", "euler"], object))
PARAMETERS = Axis(
    name="parameter",
    values=np.array(
        [
            "rotor_inertia",
            "shell_inertia",
            "crank_radius",
            "rod_length",
            "reciprocating_mass first stage",
            "gas_force second stage",
            "motor_torque",
        ],
        object,
    ),
)
LEVELS = np.array([4.3, 8.9, 0.2, 0.4, -22.2, -15.0, -18.5, -20.0, -25.1, -26.6])
LAGS = np.array([0.957, 3.789, 1.153, 3.492, 1.815, 0.455, 3.616, 6.156, 3.203, 4.455])
#: dB for one percent more of each parameter, at each order
SLOPES = np.array(
    [
        0.0012 * np.array([6.0, 5.0, 4.0, -8.0, 3.0, 2.0, -1.0, 1.0, 2.0, 1.0]),
        -0.0861 * np.ones(10),
        0.08 + 0.01 * np.arange(10),
        -0.003 * np.arange(1, 11),
        0.02 * np.cos(np.arange(10)),
        0.05 * np.sin(1.0 + np.arange(10)),
        np.full(10, 1e-9),
    ]
)
#: a straight machine: ten percent more or less are ten slopes
TEN_PERCENT = {"ten_percent_more": 10.0, "ten_percent_less": -10.0}
SLIP = RPM * np.array([0, 6, 11, 20, 34, 40, 70, 108, 180, 300, 500, 900.0])
TORQUE = np.array([0, 239, 361, 485, 616, 744, 949, 1009, 949, 746, 610, 542.0])
LEVEL = "response/roll/level/shell_acceleration"


def roll(*parts: list[Quantity], **tables: Any) -> Result:
    """A result of some parts, all of them unless named."""
    record = Record()
    chosen = parts or (running(), spectra(), forces(), spreads(), sensitivities())
    for item in (item for part in chosen for item in part):
        record.add(item)
    motor = {
        "kind": "slip_table",
        "synchronous_speed": SYNCHRONOUS,
        "slip_table": {"slip": SLIP.tolist(), "torque": TORQUE.tolist()},
        "interpolation": "linear",
    }
    case = {
        "schema": 1,
        "title": "Two-stage compressor on its shell",
        "machine": {"kind": "compressor", "motor": motor},
        "response": {"roll": {"method": "collocation", "orders": 10}},
        "reference": references(),
        **tables,
    }
    if not any(item.path == LEVEL for item in record.values()):
        case["reference"] = []
    return result_of(record, case, name="roll")


def references() -> list[dict[str, Any]]:
    """Published levels a little next to ours, and three measured ones."""
    rows = [
        {
            "quantity": LEVEL,
            "where": {"order": order},
            "value": f"{level + (0.4 if order == 7 else 0.0):.1f} dB",
            "source": "appendix A",
        }
        for order, level in zip(ORDERS.values.tolist(), LEVELS, strict=True)
    ]
    measured = {1: "7.4 dB", 2: "11.6 dB", 3: "-0.6 dB"}
    for order, value in measured.items():
        rows.append(
            {
                "quantity": LEVEL,
                "where": {"order": order},
                "value": value,
                "source": "table 1",
                "kind": "measured",
            }
        )
    return rows


def harmonics() -> dict[str, np.ndarray]:
    """Complex harmonics of orders 1 to 10, of the sizes that belong together."""
    shell = 10.0 ** (LEVELS / 20.0) * np.exp(-1j * LAGS)
    rotor = -72.0 * shell
    speed = (rotor - shell) / (1j * ORDERS.values * SPEED)
    return {
        "shell_acceleration": shell,
        "rotor_acceleration": rotor,
        "crank_speed": speed,
        "slip": -speed,
        "motor_torque": -203.4 * speed,
        "gas_torque": 2.1 * rotor + 203.4 * speed,
        "mount_torque": np.zeros(10, complex),
    }


UNITS = {
    "shell_acceleration": "rad/s^2",
    "rotor_acceleration": "rad/s^2",
    "crank_speed": "rad/s",
    "slip": "rad/s",
    "motor_torque": "N*m",
    "gas_torque": "N*m",
    "mount_torque": "N*m",
}
MEANS = {
    "crank_speed": SPEED,
    "slip": SYNCHRONOUS - SPEED,
    "motor_torque": 303.3,
    "gas_torque": -303.3,
}


def running() -> list[Quantity]:
    """The running state: speed, slip, torque, stability and balances."""
    stem = "response/roll/"
    found = [
        quantity(stem + name, value, unit)
        for name, value, unit in (
            ("speed", SPEED, "rad/s"),
            ("speed_variation", 0.0374, ""),
            ("mean_slip", SYNCHRONOUS - SPEED, "rad/s"),
            ("largest_slip", 3.9, "rad/s"),
            ("mean_torque", 303.3, "N*m"),
            ("breakdown_margin", 1009.0 / 303.3 - 1.0, ""),
            ("shell_drift", 0.0131, "rad/s"),
            ("angular_momentum", 198.9, "N*m*s"),
            ("largest_multiplier", 0.081, ""),
            ("energy/motor", 1905.7, "J"),
            ("energy/gas", 1905.7, "J"),
            ("energy/friction", 0.0, "J"),
            ("energy/mounts", 0.0, "J"),
        )
    ]
    multiplier = Axis(name="multiplier", values=np.array([1]))
    return [
        *found,
        quantity(stem + "multiplier", [0.081 + 0j], "", multiplier),
        quantity(stem + "trivial_multipliers", 3, ""),
        quantity(stem + "energy/residual", 2.3e-10, "J", error=1e-9, terms=1905.7),
        quantity(stem + "momentum_residual", 4.4e-13, "N*m*s", error=1e-12, terms=20.5),
    ]


def spectra() -> list[Quantity]:
    """Harmonics, levels, lags and the course over a turn of every variable."""
    found = []
    stem = "response/roll/"
    angle = TURN.values
    waves = np.exp(1j * np.outer(ORDERS.values, angle))
    for name, values in harmonics().items():
        with np.errstate(divide="ignore"):
            level = 20.0 * np.log10(np.abs(values))
        lag = np.mod(-np.angle(values), 2.0 * np.pi)
        error = 1e-9 * float(np.max(np.abs(values)))
        curve = MEANS.get(name, 0.0) + np.real(values @ waves)
        unit = UNITS[name]
        if name == "motor_torque":
            curve = np.interp(SYNCHRONOUS - SPEED - np.real(harmonics()["crank_speed"] @ waves),
                              np.r_[-SLIP[:0:-1], SLIP], np.r_[-TORQUE[:0:-1], TORQUE])  # fmt: skip
        found += [
            quantity(stem + name, values, unit, ORDERS, amplitude="0-pk", error=error),
            quantity(f"{stem}level/{name}", level, "dB", ORDERS, error=1e-9),
            quantity(f"{stem}phase_lag/{name}", lag, "rad", ORDERS, error=1e-9),
            quantity(f"{stem}cycle/{name}", curve, unit, TURN),
        ]
    found.append(quantity(stem + "cycle/time", angle / SPEED, "s", TURN))
    return found


def forces() -> list[Quantity]:
    """Forces in rods and on walls: harmonics, courses, peaks, and what constant speed misses."""
    found = []
    stem = "response/roll/"
    angle = TURN.values
    size = 2.0e4 * np.array([[1.0], [1.3]]) / ORDERS.values**1.5
    harmonic = size * np.exp(-0.4j * ORDERS.values)
    curve = np.real(harmonic @ np.exp(1j * np.outer(ORDERS.values, angle)))
    for name, share in (("rod_force", 1.0), ("wall_force", 0.17)):
        peak = share * np.max(np.abs(curve), axis=-1)
        found += [
            quantity(stem + name, share * harmonic, "N", CYLINDERS, ORDERS, amplitude="0-pk"),
            quantity(
                f"{stem}level/{name}", 20.0 * np.log10(share * size), "dB", CYLINDERS, ORDERS
            ),
            quantity(
                f"{stem}phase_lag/{name}", 0.4 * ORDERS.values * np.ones((2, 1)), "rad",
                CYLINDERS, ORDERS,
            ),
            quantity(f"{stem}cycle/{name}", share * curve, "N", CYLINDERS, TURN),
            quantity(f"{stem}{name}_peak", peak, "N", CYLINDERS),
            quantity(f"{stem}classical/{name}_peak", [1.004, 0.991] * peak, "N", CYLINDERS),
            quantity(f"{stem}classical/{name}_error", [0.012, 0.0213], "", CYLINDERS),
            quantity(
                f"{stem}classical/{name}_error_by_order",
                0.02 * share * harmonic * np.exp(-((ORDERS.values - 2.0) ** 2)),
                "N", CYLINDERS, ORDERS,
            ),
        ]  # fmt: skip
    found.append(quantity(stem + "cycle/gas_force", 1.1 * curve, "N", CYLINDERS, TURN))
    return found


def spreads() -> list[Quantity]:
    """Levels with each interpolation of the gas tables, and with other methods."""
    stem = "response/roll/"
    order = ORDERS.values
    away = np.outer([1.0, 0.0, -0.6, -0.8], 0.001 * order**3)
    levels = LEVELS + away
    misses = np.stack([1e-7 * order, 0.065 * order - 0.02 * order**1.5])
    return [
        quantity(stem + "interpolation/level", levels, "dB", INTERPOLANTS, ORDERS),
        quantity(stem + "interpolation/spread", np.ptp(levels, axis=0), "dB", ORDERS),
        quantity(stem + "method/level", LEVELS + misses, "dB", METHODS, ORDERS),
        quantity(stem + "method/difference", misses, "dB", METHODS, ORDERS),
        quantity(stem + "method/work", [512, 406], "", METHODS),
    ]


def sensitivities() -> list[Quantity]:
    """Slopes of the levels; the last parameter does nothing that can be seen."""
    stem = "response/roll/sensitivity/"
    return [
        quantity(stem + "level", SLOPES, "dB", PARAMETERS, ORDERS, error=1e-7),
        *(
            quantity(stem + name, factor * SLOPES, "dB", PARAMETERS, ORDERS, error=1e-7)
            for name, factor in TEN_PERCENT.items()
        ),
    ]


def with_changes(
    result: Result, values: np.ndarray, error: float = 1e-7, orders: Axis = ORDERS
) -> Result:
    """The result with changes for ten percent of ten times these slopes, up and down."""
    for name, factor in {"level": 1.0, **TEN_PERCENT}.items():
        path = f"response/roll/sensitivity/{name}"
        result.record.quantities[path] = quantity(
            path, factor * values, "dB", PARAMETERS, orders, error=error
        )
    return result


def symmetrical(floor: float = 0.0) -> Result:
    """The same with odd harmonics that vanish, or are left with round-off of size `floor`."""
    found = roll()
    quantities = found.record.quantities
    odd = ORDERS.values % 2 == 1
    for name, values in harmonics().items():
        values = np.where(odd, floor, values)
        with np.errstate(divide="ignore"):
            level = 20.0 * np.log10(np.abs(values))
        for path, other in ((name, values), (f"level/{name}", level)):
            old = quantities[f"response/roll/{path}"]
            quantities[old.path] = quantity(old.path, other, old.unit, ORDERS, error=1e-12)
    with_changes(found, np.where(odd, 0.0, SLOPES))
    del found.case["reference"]  # type: ignore[attr-defined]
    return found
