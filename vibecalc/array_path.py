"""Results of one case at many points by arrays: which cases, keys and results, and the calls."""

import operator
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.absorber.arrays import DAMPING, MASS
from vibecalc.absorber.arrays import TUNING_PATHS as TUNING
from vibecalc.core.case.number_range import ANGLES, LARGEST, LARGEST_ANGLE, SMALLEST
from vibecalc.core.case.raw import key_text
from vibecalc.core.case.walk import shape_at
from vibecalc.core.run.columns import Column, Columns, Sheet
from vibecalc.errors import KeyPath, NumericalFailure
from vibecalc.excitation.arrays import (
    BALANCE,
    COUNTERWEIGHT,
    RESIDUAL,
    TRAIN,
    Train,
    build_forces,
    build_train,
    emit_excitation,
)
from vibecalc.excitation.arrays import EXCITATION_PATHS as EXCITATION
from vibecalc.isolation.arrays import (
    BODY,
    MountedPoints,
    bare_moments,
    build_mounted,
    emit_pitch,
    on_resonance,
    pitch_of,
)
from vibecalc.isolation.arrays import PITCH_PATHS as PITCH
from vibecalc.kinds import has_crank_train
from vibecalc.numerics.rounding import BoolArray, IntArray
from vibecalc.roll.results import FORCES, ROLL, VARIABLES

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Which results of a roll machine array calls give; apart, since what solves it loads slowly.
# ----------------------------------------------------------------------------

ROLL_PATHS = (
    *(f"{ROLL}/{name}" for name in ("speed", "mean_slip", "shell_drift", "largest_multiplier")),
    *(
        path
        for name in (*VARIABLES, *FORCES)
        for path in (f"{ROLL}/{name}", f"{ROLL}/level/{name}", f"{ROLL}/phase_lag/{name}")
    ),
)

# ----------------------------------------------------------------------------
# What the array path can do: which results, over which keys, of which cases.
# ----------------------------------------------------------------------------

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
    (frozenset(ROLL_PATHS), ROLL_KEYS),
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
        return "what [tuning] asks for besides the optimum is computed point by point"
    return None


def _whole_roll(case: "Case") -> str | None:
    roll = None if case.response is None else case.response.roll
    motor = case.machine.motor
    if roll is None or roll.method != "collocation":
        return "this method is run point by point"
    if motor is None or motor.kind == "dynamic":
        return "a dynamic motor is run point by point"
    return None


# ----------------------------------------------------------------------------
# Points that the array path leaves to single runs, which refuse them, or not, in their own words.
#
# Every case that a check of `case` or `machine` refuses is among them, and some that it does not:
# the bounds here are a little narrower.
# ----------------------------------------------------------------------------

_COMPARE = {"gt": operator.gt, "ge": operator.ge, "lt": operator.lt, "le": operator.le}
#: crank over rod beyond which series grow long
_LONGEST_REACH = 0.98
#: relative slack around bounds of the checks
_SLACK = 1e-9
_MARGIN = 1.0 + _SLACK


def suspects(columns: Columns) -> BoolArray:
    """Points (points,) that a check may refuse, or whose series are long."""
    with np.errstate(all="ignore"):
        found = _numbers(columns)
        train = build_train(columns)
        found |= _train(columns, train)
        if columns.case.machine.body is not None:
            found |= _body(columns)
        if columns.case.isolation is not None:
            found |= _held(columns, build_mounted(columns, train))
    return found


def _numbers(columns: Columns) -> BoolArray:
    """Outside the bounds of the schema, or of what can be computed with."""
    found = np.zeros(columns.count, dtype=bool)
    for path, values in columns.varied.items():
        shape, size = shape_at(path), np.abs(values)
        inside = np.isfinite(values)
        for name, bound in () if shape is None else shape.bounds:
            inside &= _COMPARE[name](values, bound)
        name = next(str(part) for part in reversed(path) if isinstance(part, str))
        inside &= size <= (LARGEST_ANGLE if name in ANGLES else LARGEST)
        inside &= (size == 0.0) | (size >= SMALLEST)
        found |= ~inside
    return found


def _train(columns: Columns, train: Train) -> BoolArray:
    """A rod that does not get round, no mass that moves, more of it than the machine weighs."""
    case = columns.case
    reach = train.crank_radius + np.abs(train.wrist_pin_offset)
    fine = reach < _LONGEST_REACH * train.rod_length
    if case.kinematics is not None and case.kinematics.series == "truncated":
        fine = fine & (train.wrist_pin_offset == 0.0)
    fine = fine & (train.rod_share <= 1.0)
    moving = (train.whole_reciprocating_mass + train.whole_rotating_mass).sum(1)
    written = case.machine.crank_train
    unbalance = [
        columns.number(*TRAIN, table, place, "unbalance")
        for table in ("counterweights", "balance_shafts")
        for place in range(len(getattr(written, table)))
    ]
    fine = fine & (sum(unbalance, moving) > 0.0)
    body = case.machine.body
    if body is not None:
        if body.mass_matrix is None:
            whole = columns.number(*BODY, "mass")
        else:
            from vibecalc.parts.matrices import block_matrix

            whole = np.min(np.diagonal(block_matrix(body.mass_matrix))[:3], keepdims=True)
        fine = fine & (moving * _MARGIN < whole)
    return _everywhere(columns, ~fine)


def _body(columns: Columns) -> BoolArray:
    """Moments of inertia that no body has."""
    body = columns.case.machine.body
    if body is None or body.inertia is None:
        return np.zeros(columns.count, dtype=bool)
    moments, products = bare_moments(columns), columns.vector(*BODY, "inertia_products")
    matrix = np.zeros((max(len(moments), len(products)), 3, 3))
    matrix[:, range(3), range(3)] = moments
    for place, (row, column) in enumerate(((0, 1), (0, 2), (1, 2))):
        matrix[:, row, column] = matrix[:, column, row] = -products[:, place]
    finite: BoolArray = np.all(np.isfinite(matrix), axis=(1, 2))
    principal = np.linalg.eigvalsh(np.where(finite.reshape(-1, 1, 1), matrix, np.eye(3)))
    low, middle, high = principal.T
    fine = finite & (moments > 0.0).all(1) & (low > 1e-11 * high)
    return _everywhere(columns, ~(fine & (high <= (low + middle) * (1.0 + 0.9e-6))))


def _held(columns: Columns, mounted: MountedPoints) -> BoolArray:
    """A body that is free to pitch, and mounts without a lever of their own."""
    isolation, train = columns.case.isolation, columns.case.machine.crank_train
    pitch = (mounted.stiffness * np.square(mounted.position)).sum(1)
    fine = (pitch > 0.0) & np.isfinite(pitch)
    if columns.optional("isolation", "lever") is None:
        fine = fine & (mounted.spread <= 0.9e-9) & (mounted.lever > 0.0)
    if isolation is not None and isolation.up != train.stroke:
        fine = fine & False
    return _everywhere(columns, ~fine)


def _everywhere(columns: Columns, flag: np.ndarray) -> BoolArray:
    return np.broadcast_to(flag, columns.count).copy()


# ----------------------------------------------------------------------------
# Results of one case at many points by arrays, in blocks that bound the memory.
# ----------------------------------------------------------------------------

#: points times cylinders, weights and mounts in one block: with some fifty orders about 100 MB
_POINTS = 16_384
#: machines whose running states are found together
_ROLL_POINTS = 128
#: a block this small that fails is left to single runs
_SMALLEST = 8


class Part(NamedTuple):
    """Some of the points (n,), by their places, with what was found: `left` is nothing of it."""

    places: IntArray
    columns: Mapping[str, Column]


def compute(
    case: "Case", varied: Mapping[KeyPath, np.ndarray], count: int, keep: frozenset[str]
) -> tuple[list[Part], IntArray]:
    """Results `keep` at `count` points, and the places of the points that need a single run.

    `varied` maps key paths to values (count,). `unsupported` has to have nothing against it. A
    point needs a single run if a check may refuse it, if an order may stand on an undamped
    resonance, or if something in its arithmetic goes wrong: the single run then says what.
    """
    if case.machine.primary is not None:
        from vibecalc.absorber.arrays import tunings

        done, columns, alone = tunings(case, varied, count, keep)
        return ([Part(done, columns)] if len(done) else []), alone
    whole = Columns(case, varied, count)
    uncertain = suspects(whole)
    clear = np.flatnonzero(~uncertain)
    left = [np.flatnonzero(uncertain)]
    train, mounts = case.machine.crank_train, case.machine.mounts
    mounted = 0 if mounts is None else len(mounts.individual or mounts.positions or ())
    turning = len(train.cylinders) + len(train.counterweights) + len(train.balance_shafts)
    size = max(1, _POINTS // (turning + mounted))
    if case.response is not None and case.response.roll is not None:
        size = min(size, _ROLL_POINTS)
    parts: list[Part] = []
    waiting = [clear[start : start + size] for start in range(0, len(clear), size)][::-1]
    while waiting:
        places = waiting.pop()
        try:
            part, met = _at_points(whole.rows(places), places, keep)
        except (NumericalFailure, FloatingPointError, OverflowError):
            if len(places) <= _SMALLEST:
                left.append(places)
            else:
                half = len(places) // 2
                waiting += [places[half:], places[:half]]
            continue
        left.append(places[met])
        if part is not None:
            parts.append(part)
    return parts, np.sort(np.concatenate(left))


def _at_points(
    columns: Columns, places: IntArray, keep: frozenset[str]
) -> tuple[Part | None, BoolArray]:
    """Results of one block, and which of its points (n,) are on a resonance instead."""
    met = np.zeros(len(places), dtype=bool)
    if columns.case.response is not None and columns.case.response.roll is not None:
        return _roll_at_points(columns, places, keep)
    with np.errstate(over="raise", divide="raise", invalid="raise", under="ignore"):
        forces = build_forces(columns)
        mounted = None
        if columns.case.isolation is not None:
            mounted = build_mounted(columns, forces.train)
            met = on_resonance(columns, forces, pitch_of(mounted))
            if met.any():
                clear = np.flatnonzero(~met)
                if not len(clear):
                    return None, met
                part, _ = _at_points(columns.rows(clear), places[clear], keep)
                return part, met
        sheet = Sheet(columns.count, keep)
        emit_excitation(columns, forces, sheet)
        if mounted is not None:
            emit_pitch(columns, forces, mounted, sheet)
    return Part(places, sheet.columns), met


def _roll_at_points(
    columns: Columns, places: IntArray, keep: frozenset[str]
) -> tuple[Part | None, BoolArray]:
    """Running states of one block, and which of its points (n,) have to be run alone."""
    from vibecalc.roll.arrays import emit_roll  # loads what solves the motion

    sheet = Sheet(columns.count, keep)
    uncertain = emit_roll(columns, sheet)
    clear = np.flatnonzero(~uncertain)
    if not len(clear):
        return None, uncertain
    found = {
        path: column._replace(values=column.values[clear], errors=column.errors[clear])
        for path, column in sheet.columns.items()
    }
    return Part(places[clear], found), uncertain
