"""What each stage reads of a case, and from which stages before it: the truth of `stage_cache.py`.

A name of a case is an attribute path; it stands for all that is below it. A stage that reads what
is not declared here would be taken from the cache although its input has changed.
"""

from typing import NamedTuple


class Reads(NamedTuple):
    """Places of the case that a stage reads, and the stages whose results it is handed on."""

    case: tuple[str, ...]
    after: tuple[str, ...] = ()


#: what `scene.parts` is built from
PARTS = (
    "machine.crank_train",
    "machine.body",
    "machine.mounts",
    "excitation.working",
    "excitation.idle",
    "excitation.balanced_for",
)
#: what the system of body and suspension is built from; whichever stage needs it first builds it
SYSTEM = ("machine.body", "machine.mounts")
#: an entry of `handed_on` that any stage may build or find, since all build it from the same
SHARED = {"linear_system": SYSTEM}

#: what rotor, pistons and shell are built from
ROLL = (
    "machine.crank_train",
    "machine.rotor",
    "machine.shell",
    "machine.friction",
    "machine.motor",
    "excitation",
)

#: what a primary system with its absorber and parts is built from
ABSORBER = (
    *(f"machine.{part}" for part in ("primary", "secondary", "secondaries", "rod", "flywheel")),
    *(f"machine.{part}" for part in ("springs", "ring", "gap", "oil")),
    *(f"machine.{part}" for part in ("stock_springs", "stock_oils")),
    *(f"machine.{part}" for part in ("spring_catalogue", "oil_catalogue")),
)

#: what a shaft line and its drive are built from
LINE = (
    *(f"machine.{part}" for part in ("kind", "crank_train", "cycle", "speed", "shaft_line")),
    *(f"response.torsion.{part}" for part in ("misfire", "misfire_kind", "orders", "method")),
    "response.torsion.damping_model",
)

_MOTION = ("machine.crank_train", "machine.speed", "excitation", "kinematics", "accuracy.rtol")
_DRIVEN = ("kinematics", "excitation")
_OPERATIONS = ("machine.crank_train", "machine.speed", "excitation", *SYSTEM, "response.operations")

#: what a shaft line with its engine is built from, and how it is solved
TORSION = (
    *(f"machine.{part}" for part in ("kind", "cycle", "speed", "crank_train", "shaft_line")),
    *(f"response.torsion.{key}" for key in ("orders", "method", "damping_model")),
    *(f"response.torsion.{key}" for key in ("misfire", "misfire_kind")),
)

#: module of a stage -> what it reads
READS: dict[str, Reads] = {
    "kinematics": Reads(_MOTION),
    "excitation": Reads(
        ("machine.crank_train", "machine.speed", "excitation"), after=("kinematics",)
    ),
    "motor": Reads(("machine.motor",)),
    "response": Reads(
        ("machine.speed", *SYSTEM, "response.method", "response.energies"), after=("excitation",)
    ),
    "operations": Reads((*_OPERATIONS, "response.balances", "accuracy.rtol"), after=_DRIVEN),
    "speeds": Reads(("machine.speed", *SYSTEM, "response.run_up"), after=("excitation",)),
    "switching": Reads((*_OPERATIONS, "response.switching"), after=_DRIVEN),
    "impact": Reads(
        (
            "machine.crank_train",
            "machine.joints",
            "machine.motor",
            "machine.speed",
            "excitation",
            "response.impact",
        )
    ),
    "roll": Reads((*ROLL, "response.roll", "accuracy.rtol")),
    "start_up": Reads((*ROLL, "response.start_up", "accuracy.rtol")),
    "control": Reads((*ROLL, "response.control", "accuracy.rtol")),
    "isolation_pitch": Reads(
        (
            "machine.crank_train",
            "machine.speed",
            *SYSTEM,
            "excitation.working",
            "excitation.idle",
            "excitation.balanced_for",
            "isolation.model",
            "isolation.up",
            "isolation.gravity",
            "isolation.lever",
        ),
        after=("excitation",),
    ),
    "isolation_rigid_body": Reads(
        (
            "machine.crank_train.axis",
            "machine.speed",
            *SYSTEM,
            "isolation.model",
            "isolation.up",
            "isolation.gravity",
        ),
        after=("excitation",),
    ),
    "pump": Reads(("machine.kind", "machine.crank_train", "machine.speed", "excitation")),
    "run_up": Reads(("machine.mounts", "isolation.run_up"), after=("excitation", "isolation")),
    "torque_reaction": Reads(
        (
            *(f"machine.{part}" for part in ("crank_train", "cycle", "speed", "shaft_line")),
            "machine.kind",
            *SYSTEM,
            "excitation",
            "isolation.model",
            "isolation.up",
            "isolation.gravity",
            *(f"response.torsion.{part}" for part in ("misfire", "misfire_kind", "orders")),
        ),
        after=("excitation",),
    ),
    "torsion.published": Reads((*LINE, "response.torsion.speeds", "response.torsion.as_published")),
    "torsion.variable": Reads(
        (*LINE, "response.torsion.speeds", "response.torsion.variable_inertia", "accuracy.rtol")
    ),
    "torsion.transient": Reads((*LINE, "response.torsion.transient", "accuracy.rtol")),
    "damper_design": Reads((*LINE, "response.torsion.speeds", "damper_design")),
    "measurement": Reads(("measurement", "machine.speed")),
    "absorber_tuning": Reads((*ABSORBER, "tuning")),
    "absorber": Reads((*ABSORBER, "tuning", "response.absorber"), after=("tuning",)),
    "absorber_parts": Reads((*ABSORBER, "tuning"), after=("tuning",)),
    "torsion.stage": Reads((*TORSION, "response.torsion.limits")),
    "torsion.speeds": Reads(
        (*TORSION, *(f"response.torsion.{key}" for key in ("speeds", "limits", "campbell"))),
        after=("torsion",),
    ),
    "absorber_pendulum": Reads(("machine.pendulum",)),
}
