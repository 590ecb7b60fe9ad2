"""What the array path can do: which results, over which keys, of which cases."""

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

from vibecalc.case.kinds import has_crank_train
from vibecalc.case.overrides import key_text
from vibecalc.errors import KeyPath
from vibecalc.pipeline.arrays.absorber import DAMPING, MASS
from vibecalc.pipeline.arrays.absorber import PATHS as TUNING
from vibecalc.pipeline.arrays.excitation import BALANCE, COUNTERWEIGHT, RESIDUAL
from vibecalc.pipeline.arrays.excitation import PATHS as EXCITATION
from vibecalc.pipeline.arrays.pitch import PATHS as PITCH
from vibecalc.pipeline.arrays.roll_paths import PATHS as ROLL

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

_TRAIN, _BODY = "machine.crank_train", "machine.body"
_BLOCK, _MOUNTS = f"{_BODY}.inertia_block", "machine.mounts"
_MOUNT = ("stiffness", "stiffness[]", "damping", "damping[]", "loss_factor")

#: keys that change masses and motion of the crank train; `[]` is any entry of a list
TRAIN_KEYS = frozenset(
    [
        *(f"{_TRAIN}.{name}" for name in ("crank_radius", "rod_length", "wrist_pin_offset")),
        *(f"{_TRAIN}.{name}_mass" for name in ("reciprocating", "piston", "pin", "rotating")),
        *(f"{_TRAIN}.rod.{name}" for name in ("mass", "inertia", "reciprocating_fraction")),
        f"{_TRAIN}.rod.crank_pin_to_mass_centre",
        *(f"{_TRAIN}.cylinders[].{name}_mass" for name in ("reciprocating", "rotating")),
    ]
)
#: keys that place what moves, and the speed
FORCE_KEYS = frozenset(
    [
        "machine.speed",
        f"{_TRAIN}.origin[]",
        *(f"{_TRAIN}.cylinders[].{name}" for name in ("position", "crank_phase", "bank_angle")),
        *(f"{_TRAIN}.counterweights[].{name}" for name in ("unbalance", "phase", "position")),
        *(f"{_TRAIN}.balance_shafts[].{name}" for name in ("unbalance", "phase", "position[]")),
    ]
)
RESIDUAL_KEYS = frozenset(
    f"excitation.residual.{name}" for name in ("force_weight", "couple_weight", "reference_length")
)
#: keys of the body and its mounts
MOUNTED_KEYS = frozenset(
    [
        f"{_BODY}.mass",
        f"{_BODY}.inertia[]",
        f"{_BODY}.inertia_products[]",
        f"{_BLOCK}.mass",
        f"{_BLOCK}.position[]",
        *(
            f"{table}.box.{edge}"
            for table in (_BODY, _BLOCK)
            for edge in ("length", "width", "height")
        ),
        f"{_MOUNTS}.positions[][]",
        f"{_MOUNTS}.individual[].position[]",
        *(f"{_MOUNTS}.{table}.{name}" for table in ("each", "individual[]") for name in _MOUNT),
        "isolation.gravity",
        "isolation.lever",
    ]
)
#: keys of rotor, pistons and shell
ROLL_KEYS = TRAIN_KEYS | frozenset(
    [
        "machine.rotor.inertia",
        *(f"machine.shell.{name}" for name in ("inertia", "stiffness", "damping")),
        *(f"machine.friction.{name}" for name in ("torque", "viscous", "piston_force")),
        "response.roll.started_at",
    ]
)
#: results, and the keys over which arrays give them; the rest of a result's input stays as it is
SUPPORTED: tuple[tuple[frozenset[str], frozenset[str]], ...] = (
    (
        frozenset(EXCITATION) | frozenset(PITCH),
        TRAIN_KEYS | FORCE_KEYS | RESIDUAL_KEYS | MOUNTED_KEYS,
    ),
    (frozenset(ROLL), ROLL_KEYS),
    (frozenset(TUNING), frozenset([key_text(MASS), key_text(DAMPING)])),
)


def unsupported(case: "Case", keys: Collection[KeyPath], keep: Collection[str]) -> str | None:
    """Why arrays cannot compute the results `keep` of `case` over `keys`, or None if they can."""
    for path in keep:
        rows = [known for paths, known in SUPPORTED if path in paths]
        if not rows:
            return f"{path} is computed point by point"
        for key in keys:
            if not any(pattern(key) in known for known in rows):
                return f"{key_text(key)} is not among the numbers that arrays can vary"
            if not _is_number(case, key):
                return f"{key_text(key)} is not a number in the case as written"
    return _whole_case(case, keep)


def pattern(key: KeyPath) -> str:
    """A key as the table has it: positions in lists left out."""
    return key_text(key).translate({ord(digit): None for digit in "0123456789"})


def _is_number(case: "Case", key: KeyPath) -> bool:
    """Whether the case has a number there, so that setting it changes no other choice."""
    body = case.machine.body
    if key[:3] == ("machine", "body", "inertia_products") and body and body.inertia is None:
        return False  # zeros that go with a box and cannot be anything else
    found: Any = case
    for part in key:
        if isinstance(part, int):
            found = found[part] if isinstance(found, tuple) and part < len(found) else None
        else:
            found = getattr(found, part, None)
    return isinstance(found, float)


def _whole_case(case: "Case", keep: Collection[str]) -> str | None:
    """Stages and checks of the case that every point has to go through, kept or not."""
    if case.optimisation is not None:
        return "each point is optimised"
    isolation, machine = case.isolation, case.machine
    if machine.primary is not None:
        return _whole_tuning(case)
    if isolation is not None and isolation.model != "pitch":
        return "the rigid body on its mounts is computed point by point"
    if machine.joints is not None or (case.response and case.response.switching):
        return "joints with play and changes between operations are checked point by point"
    roll = None if case.response is None else case.response.roll
    if roll is not None:
        return _whole_roll(case)
    options, turns = case.excitation, has_crank_train(machine)
    for path, there in (
        *((path, isolation is not None) for path in PITCH),
        *((path, bool(options and options.balance)) for path in BALANCE),
        *((path, turns and bool(machine.crank_train.counterweights)) for path in COUNTERWEIGHT),
        (RESIDUAL, bool(options and options.residual)),
    ):
        if path in keep and not there:
            return f"no table of the case asks for {path}"
    driven = options or isolation or case.response
    if not driven and any(path.startswith("excitation/") for path in keep):
        return "no table of the case asks for forces"
    return None


def _whole_tuning(case: "Case") -> str | None:
    options, machine = case.tuning, case.machine
    if options is None or options.norm != "h_infinity" or options.kind != "free":
        return "only tunings of spring and damper for the largest amplitude are found together"
    if machine.secondary is None or machine.springs or machine.gap or machine.flywheel:
        return "several absorbers and their parts are computed point by point"
    if options.bounds is not None or options.compare or options.mistuning or options.sensitivity:
        return "what [tuning] asks for beside the optimum is computed point by point"
    return None


def _whole_roll(case: "Case") -> str | None:
    roll = None if case.response is None else case.response.roll
    motor = case.machine.motor
    if roll is None or roll.method != "collocation":
        return "this method is run point by point"
    if motor is None or motor.kind == "dynamic":
        return "a dynamic motor is run point by point"
    return None
