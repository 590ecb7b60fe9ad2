"""What the starter cases say: plain dicts; comments, units and bounds come from the schema."""

from typing import Any, NamedTuple

from vibecalc.absorber import starters as absorber_scenes
from vibecalc.parts import starters as compressor_scenes
from vibecalc.parts import starters as engine_scenes
from vibecalc.parts import starters as pump_scenes
from vibecalc.roll import starters as roll_scenes


class Scene(NamedTuple):
    """A starter case: one line about it, and its keys as a case writes them."""

    about: str
    data: dict[str, Any]


def _machine(train: dict[str, Any], speed: str = "1500 rpm") -> dict[str, Any]:
    return {"kind": "generator", "speed": speed, "crank_train": train}


def _cylinders(pitch: float, phases: list[int]) -> list[dict[str, Any]]:
    first = -pitch * (len(phases) - 1) / 2.0
    return [
        {
            "name": str(number + 1),
            "position": f"{first + number * pitch:g} mm",
            "crank_phase": f"{phase} deg",
        }
        for number, phase in enumerate(phases)
    ]


def _train(pitch: float, phases: list[int]) -> dict[str, Any]:
    return {
        "crank_radius": "55 mm",
        "rod_length": "190 mm",
        "reciprocating_mass": "900 g",
        "cylinders": _cylinders(pitch, phases),
    }


_CORNERS = [[f"{x} m", f"{y} m", f"{z} m"] for x, y, z in
            ((-0.45, -0.25, 0), (-0.45, 0.25, 0), (0.45, -0.25, 0), (0.45, 0.25, 0))]  # fmt: skip
_BOX = {"length": "0.9 m", "width": "0.5 m", "height": "0.6 m"}
_MOUNTS = {"each": {"stiffness": "60 N/mm", "damping": "150 N*s/m"}, "positions": _CORNERS}

_GENERATOR = Scene(
    "a three-cylinder generator set that pitches on four mounts, with a run-up and a limit",
    {
        "schema": 1,
        "title": "Three-cylinder generator set on four mounts",
        "machine": {
            **_machine(_train(110.0, [0, 120, 240])),
            "body": {"mass": "180 kg", "box": _BOX},
            "mounts": _MOUNTS,
        },
        "isolation": {"model": "pitch", "run_up": {"from": "0 rpm", "to": "1800 rpm"}},
        "limit": [
            {
                "quantity": "isolation/support_force/steady_peak",
                "max": "200 N",
                "source": "specification of the foundation",
            }
        ],
    },
)

_RIGID_BODY = Scene(
    "a single-cylinder set with counterweight and balance shaft, all six freedoms",
    {
        "schema": 1,
        "title": "Single-cylinder generator set, balanced, on four tilted mounts",
        "machine": {
            **_machine(
                {
                    "crank_radius": "40 mm",
                    "rod_length": "140 mm",
                    "piston_mass": "350 g",
                    "pin_mass": "90 g",
                    "rod": {"mass": "450 g", "crank_pin_to_mass_centre": "42 mm"},
                    "rotating_mass": "300 g",
                    "origin": ["0 m", "0 m", "-50 mm"],
                    "cylinders": [{"name": "1"}],
                    "counterweights": [
                        {"name": "web", "unbalance": "0.03 kg*m", "phase": "180 deg"}
                    ],
                    "balance_shafts": [
                        {
                            "name": "opposite",
                            "unbalance": "0.011 kg*m",
                            "speed_ratio": -1,
                            "phase": "180 deg",
                            "position": ["0 m", "60 mm", "-50 mm"],
                        }
                    ],
                },
                speed="3000 rpm",
            ),
            "rotor": {"inertia": "0.08 kg*m^2"},
            "body": {"mass": "60 kg", "inertia": ["1.6 kg*m^2", "2.1 kg*m^2", "1.9 kg*m^2"]},
            "mounts": {
                "each": {
                    "stiffness": ["20 N/mm", "20 N/mm", "35 N/mm"],
                    "loss_factor": 0.1,
                },
                "individual": [
                    {
                        "name": f"{end} {side}",
                        "position": [f"{x} m", f"{y} m", "-0.15 m"],
                        "orientation": [f"{tilt} deg", "0 deg", "0 deg"],
                    }
                    for end, x in (("rear", -0.25), ("front", 0.25))
                    for side, y, tilt in (("right", -0.2, -30), ("left", 0.2, 30))
                ],
            },
        },
        "excitation": {"driven_machine": "on_body"},
        "isolation": {"model": "rigid_body", "run_up": {"from": "0 rpm", "to": "3600 rpm"}},
        "limit": [
            {
                "quantity": "isolation/support_force/steady_peak",
                "max": "500 N",
                "source": "specification of the foundation",
            }
        ],
    },
)

_BALANCE = Scene(
    "the balance of a four-cylinder crank train: sums, residual, motion of the pistons",
    {
        "schema": 1,
        "title": "Balance of a four-cylinder crank train",
        "machine": _machine(_train(100.0, [0, 180, 180, 0])),
        "kinematics": {"series": "exact"},
        "excitation": {
            "balance": {"orders": [1, 2, 4]},
            "residual": {"force_weight": 1.0, "couple_weight": 1.0, "reference_length": "300 mm"},
        },
    },
)

_MOUNT_DESIGN = Scene(
    "stiffness and damping of mounts that keep two force limits with the least excursion",
    {
        "schema": 1,
        "title": "Mounts for a generator set within its force limits",
        "machine": {
            **_machine(
                {
                    "crank_radius": "60 mm",
                    "rod_length": "200 mm",
                    "reciprocating_mass": "400 g",
                    "cylinders": _cylinders(300.0, [120, 0, 240]),
                },
                speed="4900 rpm",
            ),
            "body": {"mass": "100 kg", "box": _BOX},
            "mounts": {
                "each": {"stiffness": "10 N/mm", "damping": "50 N*s/m"},
                "positions": _CORNERS,
            },
        },
        "isolation": {"model": "pitch", "run_up": {"from": "0 rpm", "to": "4900 rpm"}},
        "optimisation": {
            "variables": [
                {
                    "key": "machine.mounts.each.stiffness",
                    "lower": "5 N/mm",
                    "upper": "500 N/mm",
                },
                {
                    "key": "machine.mounts.each.damping",
                    "lower": "5 N*s/m",
                    "upper": "1000 N*s/m",
                },
            ],
            "objective": {"quantity": "isolation/support_displacement/excursion", "sense": "min"},
        },
        "limit": [
            {
                "quantity": "isolation/support_force/steady_peak",
                "max": "100 N",
                "source": "specification, steady state",
            },
            {
                "quantity": "isolation/support_force/run_up_peak",
                "max": "400 N",
                "source": "specification, run-up",
            },
        ],
    },
)

_CRANK_ANGLES = Scene(
    "crank angles of a three-cylinder train with the least weighted residual",
    {
        "schema": 1,
        "title": "Crank angles of a three-cylinder train with the least residual",
        "machine": _machine(_train(110.0, [0, 100, 200])),
        "excitation": {
            "balance": {"orders": [1, 2]},
            "residual": {"force_weight": 1.0, "couple_weight": 0.1, "reference_length": "220 mm"},
        },
        "optimisation": {
            "variables": [
                {
                    "key": f"machine.crank_train.cylinders[{number}].crank_phase",
                    "lower": "0 deg",
                    "upper": "360 deg",
                }
                for number in (1, 2)
            ],
            "objective": {"quantity": "excitation/residual", "sense": "min"},
            "starts": 8,
        },
    },
)

SCENES: dict[str, Scene] = {
    "generator": _GENERATOR,
    "rigid_body": _RIGID_BODY,
    "balance": _BALANCE,
    "mount_design": _MOUNT_DESIGN,
    "crank_angles": _CRANK_ANGLES,
    "compressor": Scene(
        "a compressor on one or two cylinders: modes, motion, energies of every operation",
        compressor_scenes.COMPRESSOR,
    ),
    "switching": Scene(
        "the change of a compressor from two cylinders to one, through its resonances",
        compressor_scenes.SWITCHING,
    ),
    "impact": Scene(
        "impacts in a wrist pin with play, as statistics over many runs",
        compressor_scenes.IMPACT,
    ),
    "counterweight": Scene(
        "a counterweight with angle that brings the energies of two operations down",
        compressor_scenes.BALANCE,
    ),
    "roll": Scene(
        "rotor, pistons and shell of a compressor, with the speed that its motor finds",
        roll_scenes.ROLL,
    ),
    "roll_control": Scene(
        "control of a compressor's motor against the roll of its shell",
        roll_scenes.ROLL_CONTROL,
    ),
    "plate": Scene(
        "translation, roll and pitch of a rigid plate, from levels measured on it",
        roll_scenes.PLATE,
    ),
    "absorber": Scene(
        "an absorber in ratios: the spring and the damper that keep the primary stillest",
        absorber_scenes.ABSORBER,
    ),
    "absorber_rig": Scene(
        "a torsional rig with an absorber: rod, springs, gap and oils, and which of them to buy",
        absorber_scenes.ABSORBER_RIG,
    ),
    "pendulum": Scene(
        "pendulums on a rotor that follow an order of its speed",
        absorber_scenes.PENDULUM,
    ),
    "engine": Scene(
        "torsional vibration of the shaft line of an engine with damper, flywheel and generator",
        engine_scenes.ENGINE,
    ),
    "pump": Scene(
        "a plunger pump on two mounts: valves, torque of the liquid, motion in the crank plane",
        pump_scenes.PUMP,
    ),
}
