"""Results of kinematics and excitation at many points, from their forces."""

import numpy as np

from vibecalc.excitation.balance import BANKS, TABLE, balance_columns, residual
from vibecalc.excitation.inertia_forces import Excitation, at_speed
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.arrays.columns import Columns, together
from vibecalc.pipeline.arrays.forces import Forces, peak_with_tail
from vibecalc.pipeline.arrays.sheet import Sheet, kept_only
from vibecalc.pipeline.arrays.train import TRAIN
from vibecalc.pipeline.catalogue import CATALOGUE

DIRECTIONS = ("x", "y", "z")
BALANCE = tuple(f"excitation/balance/{column}" for column in (*TABLE, *BANKS))
COUNTERWEIGHT = ("excitation/counterweight/force", "excitation/counterweight/couple")
RESIDUAL = "excitation/residual"
PATHS = (
    "kinematics/position_harmonics",
    "kinematics/acceleration_harmonics",
    "kinematics/dropped_acceleration",
    "excitation/force",
    "excitation/couple",
    "excitation/force_peak",
    "excitation/couple_peak",
    "excitation/mass/reciprocating",
    "excitation/mass/rotating",
    RESIDUAL,
    *BALANCE,
    *COUNTERWEIGHT,
)


def emit_excitation(columns: Columns, forces: Forces, sheet: Sheet) -> None:
    """Motion, forces, masses, balance sums and residual, as far as they are wanted."""
    speed = columns.number("machine", "speed")
    _motion(forces, speed, sheet)
    driven, kept = at_speed(forces.per_square, speed), forces.kept
    names = [cylinder.name for cylinder in columns.case.machine.crank_train.cylinders]
    counts, axes = forces.counts[:, :kept], {"order": forces.orders[:kept], "direction": DIRECTIONS}
    for name, value, error in (
        ("force", driven.force, driven.force_error),
        ("couple", driven.couple, driven.couple_error),
    ):
        found = WithError(value[:, :kept], error[:, :kept])
        sheet.emit(f"excitation/{name}", kept_only(found, counts, axis=1), axes)
    _peaks(forces, speed, sheet)
    for name, mass in (
        ("reciprocating", forces.train.reciprocating_mass),
        ("rotating", forces.train.rotating_mass),
    ):
        found = WithError(mass, 4.0 * EPSILON * mass)
        sheet.emit(f"excitation/mass/{name}", found, {"cylinder": names})
    if sheet.wants(*COUNTERWEIGHT):
        _counterweights(columns, forces, speed, sheet)
    if sheet.wants(*BALANCE):
        _balance(columns, forces, names, sheet)
    if sheet.wants(RESIDUAL):
        _residual(columns, forces, driven, sheet)


def _motion(forces: Forces, speed: FloatArray, sheet: Sheet) -> None:
    motion, radius = forces.motion, forces.train.crank_radius
    orders = np.arange(forces.kept + 1)
    counts = np.pad(forces.counts, ((0, 0), (1, 0)), constant_values=True)[:, : len(orders)]
    value = motion.harmonics[:, : len(orders)]
    error = motion.error[:, : len(orders)] + 4.0 * EPSILON * np.abs(value)
    unit, axes = radius * speed**2, {"order": orders}
    scale = unit[:, None] * orders**2
    position = WithError(radius[:, None] * value, radius[:, None] * error)
    sheet.emit("kinematics/position_harmonics", kept_only(position, counts), axes)
    bent = WithError(-scale * value, scale * error)
    sheet.emit("kinematics/acceleration_harmonics", kept_only(bent, counts), axes)
    lacking = motion.lacking
    rounding = lacking.error + 4.0 * EPSILON * lacking.value
    dropped = WithError(unit * lacking.value, unit * rounding)
    sheet.emit("kinematics/dropped_acceleration", dropped)


def _peaks(forces: Forces, speed: FloatArray, sheet: Sheet) -> None:
    """Peaks grow with the square of the speed, so that it costs nothing to vary it."""
    square, whole = np.square(speed)[:, None], forces.per_square
    for name, value, error in (
        ("force", whole.force, whole.force_error),
        ("couple", whole.couple, whole.couple_error),
    ):
        if sheet.wants(f"excitation/{name}_peak"):
            rows = WithError(np.swapaxes(value, 1, 2), np.swapaxes(error, 1, 2))
            peak = peak_with_tail(rows, forces)
            top = square * peak.value
            found = WithError(top, square * peak.error + 3.0 * EPSILON * top)
            sheet.emit(f"excitation/{name}_peak", found, {"direction": DIRECTIONS})


def _counterweights(columns: Columns, forces: Forces, speed: FloatArray, sheet: Sheet) -> None:
    weights = columns.case.machine.crank_train.counterweights
    rows = [(*TRAIN, "counterweights", place) for place in range(len(weights))]
    unbalance = together([columns.number(*row, "unbalance") for row in rows])
    position = together([columns.number(*row, "position") for row in rows])
    force = unbalance * np.square(speed)[:, None]
    along = np.abs((forces.train.origin @ forces.train.frame.axis)[:, None] + position)
    axes = {"counterweight": [weight.name for weight in weights]}
    sheet.emit(COUNTERWEIGHT[0], WithError(force, 2.0 * EPSILON * force), axes)
    couple = force * along
    sheet.emit(COUNTERWEIGHT[1], WithError(couple, 6.0 * EPSILON * couple), axes)


def _balance(columns: Columns, forces: Forces, names: list[str], sheet: Sheet) -> None:
    options = columns.case.excitation
    if options is None or options.balance is None:
        return
    orders = np.array(options.balance.orders)
    known = {"order": orders, "cylinder": names, "direction": DIRECTIONS}
    for column, found in balance_columns(orders, forces.train).items():
        path = f"excitation/balance/{column}"
        sheet.emit(path, found, {name: known[name] for name in CATALOGUE[path].axes})


def _residual(columns: Columns, forces: Forces, driven: Excitation, sheet: Sheet) -> None:
    options = columns.case.excitation
    if options is None or options.residual is None:
        return
    place = ("excitation", "residual")
    weights = {
        name: columns.number(*place, name)
        for name in ("force_weight", "couple_weight", "reference_length")
    }
    # `residual` has the shape of the forces, which may vary less than weights and couples
    points = max(len(part) for part in (*weights.values(), *driven, forces.counts))
    counts = np.broadcast_to(forces.counts[:, :, None], (points, len(forces.orders), 1))
    kept, rest = (
        residual(Excitation._make(np.where(chosen, part, 0.0) for part in driven), **weights)
        for chosen in (counts, ~counts)
    )
    dropped = forces.motion.tail * rest.value
    total = kept.value + np.hypot(kept.value, dropped)
    added = dropped * (dropped / np.where(total > 0.0, total, 1.0))
    sheet.emit(RESIDUAL, WithError(kept.value, kept.error + added))
