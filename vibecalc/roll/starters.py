"""Starter cases: machines whose motor finds the speed, a plate whose motion is measured."""

from typing import Any

#: over a turn of each cylinder from its own top dead centre, every 30 degrees
_ANGLES = [f"{angle} deg" for angle in range(0, 361, 30)]
#: kN, a first stage from 0 to 2.5 bar in a bore of 200 mm
_FIRST = (7.9, 2.2, 0, 0, 0, 0, 0, 0.3, 1.1, 3.0, 6.7, 7.9, 7.9)
#: kN, a second stage from 2.5 to 8 bar in a bore of 120 mm
_SECOND = (9.0, 4.7, 2.8, 2.8, 2.8, 2.8, 2.8, 3.1, 4.0, 6.1, 9.0, 9.0, 9.0)
_SLIP = (0, 12, 24, 40, 70, 110, 160, 240, 400, 700, 1000)
_TORQUE = (0, 230, 420, 610, 800, 870, 840, 740, 590, 470, 420)


def _cylinder(name: str, phase: int, mass: str, force: tuple[float, ...]) -> dict[str, Any]:
    return {
        "name": name,
        "crank_phase": f"{phase} deg",
        "reciprocating_mass": mass,
        "gas_force": {"crank_angle": _ANGLES, "force": [f"{value:g} kN" for value in force]},
    }


def _machine(**shell: str) -> dict[str, Any]:
    return {
        "kind": "compressor",
        "crank_train": {
            "crank_radius": "50 mm",
            "rod_length": "230 mm",
            "gas_interpolation": "cubic",
            "cylinders": [
                _cylinder("low pressure", 0, "7.5 kg", _FIRST),
                _cylinder("high pressure", 180, "6 kg", _SECOND),
            ],
        },
        "motor": {
            "kind": "slip_table",
            "synchronous_speed": "1000 rpm",
            "slip_table": {
                "slip": [f"{value} rpm" for value in _SLIP],
                "torque": [f"{value} N*m" for value in _TORQUE],
            },
        },
        "rotor": {"inertia": "1.6 kg*m^2"},
        "shell": {"inertia": "85 kg*m^2", **shell},
    }


ROLL: dict[str, Any] = {
    "schema": 1,
    "title": "Roll of a two-stage compressor on soft mounts, with the speed that its motor finds",
    "machine": {
        **_machine(stiffness="90 kN*m/rad", damping="180 N*m*s/rad"),
        "friction": {"viscous": "0.15 N*m*s/rad", "piston_force": "60 N"},
    },
    "response": {"roll": {"orders": 10}},
}

ROLL_CONTROL: dict[str, Any] = {
    "schema": 1,
    "title": "A motor control that keeps a free shell quieter, with margins of its loop",
    "machine": _machine(),
    "response": {
        "control": {
            "gain": 4.0,
            "acceleration_feedback": "-0.5 s",
            "actuator_lag": "8 ms",
            "delay": "1 ms",
            "gains": [1.0, 2.0, 4.0],
            "feedbacks": ["-0.5 s", "0 s"],
        },
    },
}

#: dB re 1e-5 m/s^2, of a plate that rises, rolls and pitches
_LEVELS = {
    "front left": [100.1, 102.1],
    "front right": [107.2, 107.6],
    "rear left": [106.0, 101.9],
    "rear right": [109.8, 109.7],
}
PLATE: dict[str, Any] = {
    "schema": 1,
    "title": "Motion of a baseplate from accelerometers at its corners",
    "machine": {"kind": "plate"},
    "measurement": {
        "amplitude": "zero_to_peak",
        "reference_level": "1e-5 m/s^2",
        "orders": [1, 2],
        "base_frequency": "16.5 Hz",
        "positions": [
            {"name": "front left", "x": "0.6 m", "y": "-0.3 m"},
            {"name": "front right", "x": "0.6 m", "y": "0.3 m"},
            {"name": "rear left", "x": "-0.6 m", "y": "-0.3 m"},
            {"name": "rear right", "x": "-0.6 m", "y": "0.3 m"},
        ],
        "readings": [
            *({"at": name, "level": _LEVELS[name]} for name in list(_LEVELS)[:3]),
            {"between": ["front left", "front right"], "level": [109.5, 111.1]},
            {"between": ["front left", "rear left"], "level": [102.4, 103.2]},
            {"at": "rear right", "use": "choose", "level": _LEVELS["rear right"]},
        ],
        "plate": {"x": ["-0.7 m", "0.7 m"], "y": ["-0.4 m", "0.4 m"]},
    },
}
