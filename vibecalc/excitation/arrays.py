"""Crank train, piston motion and forces at many points: as for one case, with a leading axis."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.run.columns import Columns, Sheet, counted_only, together
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.balance import BANKS, TABLE, balance_columns, residual
from vibecalc.excitation.crank_forces import TurningWeights, crank_forces
from vibecalc.excitation.inertia_forces import Excitation, at_speed
from vibecalc.kinematics.adapter import BEYOND_GUARD, MOST_GUARD_ORDERS, last_order
from vibecalc.kinematics.harmonics import dropped_with_error, harmonics_with_error, pole
from vibecalc.kinematics.truncated_series import (
    RELATIVE_ERROR,
    truncated_dropped_acceleration,
    truncated_harmonics,
)
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray
from vibecalc.parts.body import Frame, build_frame
from vibecalc.parts.firing import shakes_with_torque
from vibecalc.parts.geometry import CrankGeometry

# ----------------------------------------------------------------------------
# A crank train at many points: as `machine.crank_train`, each number with a leading axis.
# ----------------------------------------------------------------------------

TRAIN = ("machine", "crank_train")


class Train(NamedTuple):
    """Arrays (points or 1,) and (points or 1, cylinders) of what `CrankTrain` holds.

    `whole_rotating_mass` counts the throws that do not turn, too; `runs` (cylinders,) is 1 for
    cylinders that move. `rod_share` is the share of the rod's mass that moves with the piston.
    """

    geometry: CrankGeometry
    position: FloatArray
    crank_phase: FloatArray
    bank_angle: FloatArray
    reciprocating_mass: FloatArray
    rotating_mass: FloatArray
    whole_reciprocating_mass: FloatArray
    whole_rotating_mass: FloatArray
    runs: FloatArray
    rod_share: FloatArray
    origin: FloatArray
    frame: Frame

    @property
    def crank_radius(self) -> FloatArray:
        return np.asarray(self.geometry.crank_radius)

    @property
    def rod_length(self) -> FloatArray:
        return np.asarray(self.geometry.rod_length)

    @property
    def wrist_pin_offset(self) -> FloatArray:
        return np.asarray(self.geometry.wrist_pin_offset)

    @property
    def axis(self) -> FloatArray:
        return self.frame.axis

    @property
    def stroke(self) -> FloatArray:
        return self.frame.stroke

    @property
    def across(self) -> FloatArray:
        return self.frame.across


def build_train(columns: Columns) -> Train:
    """The crank train at all points."""
    train = columns.case.machine.crank_train
    options = columns.case.excitation
    stopped = options is not None and options.working is not None and options.idle != "unloaded"
    working = (options.working or ()) if options else ()
    runs = np.array([not stopped or c.name in working for c in train.cylinders], dtype=float)
    share = _rod_share(columns)
    rod = columns.number(*TRAIN, "rod", "mass") if train.rod is not None else np.zeros(1)
    common = columns.optional(*TRAIN, "reciprocating_mass")
    if common is None:
        parts = columns.number(*TRAIN, "piston_mass") + columns.number(*TRAIN, "pin_mass")
        common = parts + rod * share
    pins = columns.number(*TRAIN, "rotating_mass")
    reciprocating, rotating = [], []
    for place in range(len(train.cylinders)):
        path = (*TRAIN, "cylinders", place)
        given, pin = (
            columns.optional(*path, f"{kind}_mass") for kind in ("reciprocating", "rotating")
        )
        reciprocating.append(common if given is None else given)
        rotating.append((pins if pin is None else pin) + rod * (1.0 - share))
    moving, turning = together(reciprocating), together(rotating)
    position, phase, bank = (
        together([columns.number(*TRAIN, "cylinders", i, name) for i in range(len(runs))])
        for name in ("position", "crank_phase", "bank_angle")
    )
    return Train(
        geometry=CrankGeometry(
            crank_radius=columns.number(*TRAIN, "crank_radius"),
            rod_length=columns.number(*TRAIN, "rod_length"),
            wrist_pin_offset=columns.number(*TRAIN, "wrist_pin_offset"),
        ),
        position=position,
        crank_phase=phase,
        bank_angle=bank,
        reciprocating_mass=runs * moving,
        rotating_mass=runs * turning,
        whole_reciprocating_mass=moving,
        whole_rotating_mass=turning,
        runs=runs,
        rod_share=share,
        origin=columns.vector(*TRAIN, "origin"),
        frame=build_frame(train.axis, train.stroke),
    )


def turning_masses(columns: Columns, train: Train) -> TurningWeights:
    """Throws, weights that cancel throws, counterweights and balance shafts at all points.

    `unbalance` (points or 1, m), `position` (points or 1, m, 3).
    """
    written, options = columns.case.machine.crank_train, columns.case.excitation
    radius = train.crank_radius[:, None]
    unbalance = [train.rotating_mass * radius]
    phase, along = [train.crank_phase], [train.position]
    balanced = (options.balanced_for or ()) if options else ()
    named = [i for i, c in enumerate(written.cylinders) if c.name in balanced]
    unbalance.append(train.whole_rotating_mass[:, named] * radius)
    phase.append(train.crank_phase[:, named] + np.pi)
    along.append(train.position[:, named])
    for rows, name in ((unbalance, "unbalance"), (phase, "phase"), (along, "position")):
        paths = [(*TRAIN, "counterweights", i, name) for i in range(len(written.counterweights))]
        rows.append(together([columns.number(*path) for path in paths]))
    on_shaft = [part[..., None] * train.frame.axis for part in along]
    shafts = range(len(written.balance_shafts))
    for rows, name in ((unbalance, "unbalance"), (phase, "phase")):
        paths = [(*TRAIN, "balance_shafts", i, name) for i in shafts]
        rows.append(together([columns.number(*path) for path in paths]))
    for i in shafts:
        on_shaft.append(columns.vector(*TRAIN, "balance_shafts", i, "position")[:, None, :])
    crank = sum(part.shape[1] for part in along)
    ratios = [1] * crank + [shaft.speed_ratio for shaft in written.balance_shafts]
    return TurningWeights(
        _side_by_side(unbalance), np.array(ratios, dtype=np.int64), _side_by_side(phase),
        _side_by_side(on_shaft),
    )  # fmt: skip


def _rod_share(columns: Columns) -> FloatArray:
    rod = (*TRAIN, "rod")
    if columns.written(*rod) is None:
        return np.zeros(1)
    given = columns.optional(*rod, "reciprocating_fraction")
    if given is not None:
        return given
    return columns.number(*rod, "crank_pin_to_mass_centre") / columns.number(*TRAIN, "rod_length")


def _side_by_side(parts: list[FloatArray]) -> FloatArray:
    """Arrays (points or 1, any, ...) along their second axis."""
    points = max(part.shape[0] for part in parts)
    wide = [np.broadcast_to(part, (points, *part.shape[1:])) for part in parts]
    return np.concatenate(wide, axis=1)


# ----------------------------------------------------------------------------
# Piston motion at many points: as the stage `kinematics`, each number with a leading axis.
# ----------------------------------------------------------------------------

#: of the highest order that a search for enough orders tries
_HIGHEST = 1024


class PistonMotions(NamedTuple):
    """Harmonics of s / R (points or 1, h + 1) for orders 0 .. h, as `PistonMotion`.

    `highest_order` (points or 1,) is the highest order that counts at each point; those above it
    are guards, and all that is dropped weighs `tail` times as much as they do. `lacking` is the
    acceleration that the retained orders leave out, in units of R w^2.
    """

    harmonics: np.ndarray
    error: FloatArray
    highest_order: IntArray
    tail: FloatArray
    dropped_after_guard: FloatArray
    lacking: Bounded


def piston_motion(columns: Columns, train: Train) -> PistonMotions:
    """Motion at all points; points with the same crank and rod share it."""
    ratio, offset = np.broadcast_arrays(
        train.crank_radius / train.rod_length, train.wrist_pin_offset / train.crank_radius
    )
    pairs, back = np.unique(np.stack([ratio, offset]), axis=1, return_inverse=True)
    options = columns.case.kinematics
    if options is not None and options.series == "truncated":
        motion = _cut_series(columns, pairs[0], options.terms or 1)
    else:
        motion = _exact_series(columns, pairs[0], pairs[1], train.position.shape[1])
    back = back.reshape(-1)
    if len(pairs[0]) == 1:
        return motion
    return PistonMotions(
        harmonics=motion.harmonics[back],
        error=motion.error[back],
        highest_order=motion.highest_order[back],
        tail=motion.tail[back],
        dropped_after_guard=motion.dropped_after_guard[back],
        lacking=Bounded(motion.lacking.value[back], motion.lacking.error[back]),
    )


def _exact_series(
    columns: Columns, ratio: FloatArray, offset: FloatArray, cylinders: int
) -> PistonMotions:
    last = _highest_order(columns, enough_orders(ratio, columns.case.accuracy.rtol, offset))
    decay = -np.log(pole(ratio, np.abs(offset)).radius)
    guard = np.maximum(np.ceil(-math.log(BEYOND_GUARD) / decay) + 2, 2 * cylinders)
    highest = int(np.max(last + np.minimum(guard, MOST_GUARD_ORDERS)))
    exact = harmonics_with_error(ratio, highest, offset)
    beyond = dropped_with_error(ratio, highest, offset)
    orders = np.arange(highest + 1)
    above = orders > last[:, None]
    size = np.where(above, orders**2 * np.abs(exact.values), 0.0)
    dropped = size[:, ::-1].sum(-1) + beyond.value
    uncertainty = np.where(above, orders**2 * exact.error, 0.0).sum(-1) + beyond.error
    beyond_last = dropped - beyond.value
    tail = np.where(beyond_last > 0.0, dropped / np.where(beyond_last > 0.0, beyond_last, 1.0), 1.0)
    reach = ratio * (1.0 + np.abs(offset))
    slip = EPSILON * (last + 2.0 + 1.0 / decay) / np.sqrt(1.0 - reach * reach)
    lacking = Bounded(dropped, uncertainty + (3.0 * EPSILON + slip) * dropped)
    error = _with_ratio_error(exact.values, exact.error, ratio)
    return PistonMotions(exact.values, error, last, tail, beyond.value, lacking)


def _cut_series(columns: Columns, ratio: FloatArray, terms: int) -> PistonMotions:
    last = last_order(columns.case, terms)
    used = _highest_order(columns, np.full(ratio.shape, last))
    highest = int(used[0])
    values = truncated_harmonics(ratio, terms, max(highest, last))
    error = _with_ratio_error(values, RELATIVE_ERROR * np.abs(values), ratio)
    dropped = truncated_dropped_acceleration(ratio, terms, highest)
    relative = EPSILON * (8.0 + 4.0 * terms / (1.0 - ratio * ratio))
    tail = np.full(ratio.shape, 1.0 if values.shape[-1] > highest + 1 else 0.0)
    nothing = np.zeros(ratio.shape)
    return PistonMotions(values, error, used, tail, nothing, Bounded(dropped, relative * dropped))


def enough_orders(ratio: FloatArray, rtol: float, offset: FloatArray) -> IntArray:
    """`kinematics.dropped_orders.order_for_tolerance` of many cranks (n,) at once.

    Raises NumericalFailure where one of them would need more than 1024 orders.
    """
    enough = np.zeros(ratio.shape, dtype=np.int64)
    left = np.arange(ratio.size)
    highest = 16
    while left.size and highest <= _HIGHEST:
        some, moved = ratio[left], offset[left]
        size = np.abs(harmonics_with_error(some, highest, moved, derivative=2).values)
        allowed = rtol * size.max(-1)
        dropped = dropped_with_error(some, highest, moved)
        settled = dropped.value + dropped.error <= allowed
        remainder = np.cumsum(size[:, :0:-1], axis=-1)[:, ::-1] + dropped.value[:, None]
        remainder = np.concatenate([remainder, dropped.value[:, None]], axis=-1)
        first = np.argmax(remainder <= allowed[:, None], axis=-1)
        enough[left[settled]] = first[settled]
        left, highest = left[~settled], highest * 4
    if left.size:
        raise NumericalFailure(f"more than {_HIGHEST} orders are needed")
    return enough


def _highest_order(columns: Columns, enough: IntArray) -> IntArray:
    options = columns.case.excitation
    if options is not None and options.orders is not None:
        return np.full(enough.shape, options.orders)
    shafts = columns.case.machine.crank_train.balance_shafts
    fastest = max([1, *(abs(shaft.speed_ratio) for shaft in shafts)])
    return np.maximum(enough, fastest)


def _with_ratio_error(values: np.ndarray, error: FloatArray, ratio: FloatArray) -> FloatArray:
    steepness = np.arange(values.shape[-1]) / np.sqrt(1.0 - ratio * ratio)[:, None]
    total: FloatArray = error + 0.5 * EPSILON * steepness * np.abs(values)
    return total


# ----------------------------------------------------------------------------
# Forces and couples at many points: as the stage `excitation`, each number with a leading axis.
# ----------------------------------------------------------------------------


class Forces(NamedTuple):
    """Crank train, its motion, and forces and couples (points or 1, h, 3) per speed squared.

    `counts` (points or 1, h) is true for the orders 1 .. h that a point keeps.
    """

    train: Train
    motion: PistonMotions
    per_square: Excitation
    orders: IntArray
    counts: np.ndarray

    @property
    def retained(self) -> int:
        """Highest order that any point keeps."""
        return int(self.motion.highest_order.max())


def build_forces(columns: Columns) -> Forces:
    """All that the crank train does to the body, per crank speed squared."""
    train = build_train(columns)
    motion = piston_motion(columns, train)
    highest = motion.harmonics.shape[-1] - 1
    turning = turning_masses(columns, train)
    rod = columns.case.machine.crank_train.rod
    has_inertia = rod is not None and rod.inertia is not None
    per_square = crank_forces(
        train,
        motion,
        train.origin[:, None, :],
        turning=turning if turning.unbalance.any() else None,
        rod_difference=_rod_difference(columns, train) if has_inertia else None,
        with_torque=shakes_with_torque(columns.case),
        rotor_inertia=columns.optional("machine", "rotor", "inertia"),
    )
    orders = np.arange(1, highest + 1)
    return Forces(train, motion, per_square, orders, orders <= motion.highest_order[:, None])


def peak_with_tail(harmonics: Bounded, forces: Forces) -> Bounded:
    """Peak over the cycle (points, ...) of the retained orders, the dropped ones in its error.

    `harmonics` (points or 1, ..., h) with as many axes in between as the caller likes.
    """
    value, error = harmonics
    between = (1,) * (value.ndim - 2)
    counts = forces.counts.reshape(len(forces.counts), *between, -1)
    tail = forces.motion.tail.reshape(-1, *between)
    within = np.where(counts, value, 0.0)[..., : forces.retained]
    peak = cycle_peak(within, forces.orders[: forces.retained])
    left_out = np.where(counts, error, 0.0).sum(-1)
    left_out = left_out + tail * np.where(counts, 0.0, np.abs(value)).sum(-1)
    return Bounded(peak.value, peak.error + left_out)


def _rod_difference(columns: Columns, train: Train) -> Bounded:
    """Moments (points or 1, 1) of a rod beyond those of its two point masses."""
    from vibecalc.excitation.rod_inertia import split_inertia

    rod = (*TRAIN, "rod")
    place = columns.optional(*rod, "crank_pin_to_mass_centre")
    if place is None:
        place = columns.number(*rod, "reciprocating_fraction") * train.rod_length
    points = split_inertia(columns.number(*rod, "mass"), place, train.rod_length)
    difference = columns.number(*rod, "inertia") - points.value
    uncertainty = points.error + EPSILON * np.abs(difference)
    return Bounded(difference[:, None], uncertainty[:, None])


# ----------------------------------------------------------------------------
# Results of kinematics and excitation at many points, from their forces.
# ----------------------------------------------------------------------------

DIRECTIONS = ("x", "y", "z")
BALANCE = tuple(f"excitation/balance/{column}" for column in (*TABLE, *BANKS))
COUNTERWEIGHT = ("excitation/counterweight/force", "excitation/counterweight/couple")
RESIDUAL = "excitation/residual"
EXCITATION_PATHS = (
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
    _emit_motion(forces, speed, sheet)
    driven, used = at_speed(forces.per_square, speed), forces.retained
    names = [cylinder.name for cylinder in columns.case.machine.crank_train.cylinders]
    counts, axes = forces.counts[:, :used], {"order": forces.orders[:used], "direction": DIRECTIONS}
    for name, value, error in (
        ("force", driven.force, driven.force_error),
        ("couple", driven.couple, driven.couple_error),
    ):
        emitted = Bounded(value[:, :used], error[:, :used])
        sheet.emit(f"excitation/{name}", counted_only(emitted, counts, axis=1), axes)
    _peaks(forces, speed, sheet)
    for name, mass in (
        ("reciprocating", forces.train.reciprocating_mass),
        ("rotating", forces.train.rotating_mass),
    ):
        emitted = Bounded(mass, 4.0 * EPSILON * mass)
        sheet.emit(f"excitation/mass/{name}", emitted, {"cylinder": names})
    if sheet.wants(*COUNTERWEIGHT):
        _counterweights(columns, forces, speed, sheet)
    if sheet.wants(*BALANCE):
        _balance(columns, forces, names, sheet)
    if sheet.wants(RESIDUAL):
        _residual(columns, forces, driven, sheet)


def _emit_motion(forces: Forces, speed: FloatArray, sheet: Sheet) -> None:
    motion, radius = forces.motion, forces.train.crank_radius
    orders = np.arange(forces.retained + 1)
    counts = np.pad(forces.counts, ((0, 0), (1, 0)), constant_values=True)[:, : len(orders)]
    value = motion.harmonics[:, : len(orders)]
    error = motion.error[:, : len(orders)] + 4.0 * EPSILON * np.abs(value)
    unit, axes = radius * speed**2, {"order": orders}
    scale = unit[:, None] * orders**2
    position = Bounded(radius[:, None] * value, radius[:, None] * error)
    sheet.emit("kinematics/position_harmonics", counted_only(position, counts), axes)
    bent = Bounded(-scale * value, scale * error)
    sheet.emit("kinematics/acceleration_harmonics", counted_only(bent, counts), axes)
    lacking = motion.lacking
    rounding = lacking.error + 4.0 * EPSILON * lacking.value
    dropped = Bounded(unit * lacking.value, unit * rounding)
    sheet.emit("kinematics/dropped_acceleration", dropped)


def _peaks(forces: Forces, speed: FloatArray, sheet: Sheet) -> None:
    """Peaks grow with the square of the speed, so that it costs nothing to vary it."""
    square, whole = np.square(speed)[:, None], forces.per_square
    for name, value, error in (
        ("force", whole.force, whole.force_error),
        ("couple", whole.couple, whole.couple_error),
    ):
        if sheet.wants(f"excitation/{name}_peak"):
            rows = Bounded(np.swapaxes(value, 1, 2), np.swapaxes(error, 1, 2))
            peak = peak_with_tail(rows, forces)
            top = square * peak.value
            found = Bounded(top, square * peak.error + 3.0 * EPSILON * top)
            sheet.emit(f"excitation/{name}_peak", found, {"direction": DIRECTIONS})


def _counterweights(columns: Columns, forces: Forces, speed: FloatArray, sheet: Sheet) -> None:
    weights = columns.case.machine.crank_train.counterweights
    rows = [(*TRAIN, "counterweights", place) for place in range(len(weights))]
    unbalance = together([columns.number(*row, "unbalance") for row in rows])
    position = together([columns.number(*row, "position") for row in rows])
    force = unbalance * np.square(speed)[:, None]
    along = np.abs((forces.train.origin @ forces.train.frame.axis)[:, None] + position)
    axes = {"counterweight": [weight.name for weight in weights]}
    sheet.emit(COUNTERWEIGHT[0], Bounded(force, 2.0 * EPSILON * force), axes)
    couple = force * along
    sheet.emit(COUNTERWEIGHT[1], Bounded(couple, 6.0 * EPSILON * couple), axes)


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
    first, guards = (
        residual(Excitation._make(np.where(chosen, part, 0.0) for part in driven), **weights)
        for chosen in (counts, ~counts)
    )
    dropped = forces.motion.tail * guards.value
    total = first.value + np.hypot(first.value, dropped)
    added = dropped * (dropped / np.where(total > 0.0, total, 1.0))
    sheet.emit(RESIDUAL, Bounded(first.value, first.error + added))
