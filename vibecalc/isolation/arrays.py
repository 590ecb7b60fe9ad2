"""The pitching body on its mounts at many points: as for one case, with a leading axis."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.columns import Columns, Sheet, counted_only, together
from vibecalc.excitation.arrays import Forces, Train, peak_with_tail
from vibecalc.excitation.inertia_forces import about_point
from vibecalc.isolation import pitch as model
from vibecalc.isolation.pitch import pitch_static
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, SINGULAR, UNIT_ROUNDOFF, BoolArray, FloatArray
from vibecalc.parts import tables as parts
from vibecalc.parts.mounts import rotation

# ----------------------------------------------------------------------------
# The pitching body on its mounts at many points: as `machine.pitch`, with a leading axis.
# ----------------------------------------------------------------------------

BODY = ("machine", "body")
MOUNTS = ("machine", "mounts")
_PROPERTIES = ("stiffness", "damping")


class MountedPoints(NamedTuple):
    """Arrays (points or 1,) and (points or 1, mounts) of what `PitchParts` holds.

    `mass` in kg with the block; `spread` (points or 1,) is the relative difference between the
    distances of the mounts, which share the distance `lever` if it is zero to rounding.
    """

    names: tuple[str, ...]
    mass: FloatArray
    inertia: FloatArray
    centre: FloatArray
    across: FloatArray
    position: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    structural: FloatArray
    lever: FloatArray
    spread: FloatArray


def build_mounted(columns: Columns, train: Train) -> MountedPoints:
    """Body and mounts at all points."""
    frame = train.frame
    along, up, turned = (
        int(np.argmax(np.abs(v))) for v in (frame.axis, frame.stroke, frame.across)
    )
    mass, centre, inertia = _body(columns, turned)
    mounts = columns.case.machine.mounts
    if mounts is None:
        raise ValueError("the machine has no mounts")
    count = len(mounts.individual or mounts.positions or ())
    place = "individual" if mounts.individual else "positions"
    paths = [
        (*MOUNTS, place, i, "position") if mounts.individual else (*MOUNTS, place, i)
        for i in range(count)
    ]
    position = together([columns.number(*path, along) for path in paths]) - centre[:, along, None]
    single = list(mounts.individual or ())
    stiffness, damping = (
        together([_along(columns, single, i, name, up) for i in range(count)])
        for name in _PROPERTIES
    )
    loss = together([_property(columns, single, i, "loss_factor") for i in range(count)])
    reach = np.sort(np.abs(position), axis=1)
    longest = reach[:, -1]
    lever = columns.optional("isolation", "lever")
    if lever is None:
        lever = 0.5 * (reach[:, (count - 1) // 2] + reach[:, count // 2])
    return MountedPoints(
        names=tuple(mount.name for mount in single) or tuple(str(n + 1) for n in range(count)),
        mass=mass,
        inertia=inertia,
        centre=centre,
        across=frame.across,
        position=position,
        stiffness=stiffness,
        damping=damping,
        structural=loss * stiffness,
        lever=lever,
        spread=(longest - reach[:, 0]) / np.where(longest > 0.0, longest, 1.0),
    )


def bare_moments(columns: Columns) -> FloatArray:
    """Moments Ixx, Iyy, Izz (points or 1, 3) of the machine without its block."""
    body = columns.case.machine.body
    if body is not None and body.inertia is not None:
        return columns.vector(*BODY, "inertia")
    return _box_moments(columns, BODY)


def _body(columns: Columns, turned: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, its centre (., 3), and moment of inertia about the axis `turned` through it."""
    bare, moments = columns.number(*BODY, "mass"), bare_moments(columns)[:, turned]
    body = columns.case.machine.body
    if body is None or body.inertia_block is None:
        return bare, np.zeros((1, 3)), moments
    block = (*BODY, "inertia_block")
    added, place = columns.number(*block, "mass"), columns.vector(*block, "position")
    mass = bare + added
    away = np.delete(np.square(place), turned, axis=1).sum(1)
    inertia = moments + (_box_moments(columns, block)[:, turned] + added * (bare / mass) * away)
    return mass, (added / mass)[:, None] * place, inertia


def _box_moments(columns: Columns, place: tuple[str, ...]) -> FloatArray:
    x, y, z = (columns.number(*place, "box", edge) for edge in ("length", "width", "height"))
    twelfth = columns.number(*place, "mass") / 12.0
    squares = (y * y + z * z, x * x + z * z, x * x + y * y)
    return together([twelfth * square for square in squares])


def _property(
    columns: Columns, single: list[parts.Mount], place: int, name: str, *entry: int
) -> FloatArray:
    path = (*MOUNTS, "individual", place, name)
    if single and columns.written(*path) is not None:
        return columns.number(*path, *entry)
    return columns.number(*MOUNTS, "each", name, *entry)


def _along(
    columns: Columns, single: list[parts.Mount], place: int, name: str, up: int
) -> FloatArray:
    """Stiffness or damping of a mount along one axis of the body."""
    given = columns.written(*MOUNTS, "individual", place, name) if single else None
    if given is None:
        given = columns.written(*MOUNTS, "each", name)
    if not isinstance(given, tuple):
        return _property(columns, single, place, name)
    orientation = single[place].orientation if single else (0.0, 0.0, 0.0)
    if not any(orientation):
        return _property(columns, single, place, name, up)
    share = np.square(rotation(*orientation)[up])
    principal = [_property(columns, single, place, name, entry) for entry in range(3)]
    along: FloatArray = together(principal) @ share
    return along


# ----------------------------------------------------------------------------
# Results of the pitch model at many points: the stage `isolation_pitch` with a leading axis.
# ----------------------------------------------------------------------------

PITCH, LEVER = "isolation/pitch", "isolation/lever_force"
FORCE, MOVED = "isolation/support_force", "isolation/support_displacement"
HEIGHTS = (f"{MOVED}/vertical_peak", f"{MOVED}/excursion")
PITCH_PATHS = (
    *(f"{PITCH}/{name}" for name in ("inertia", "stiffness", "damping", "natural_frequency")),
    *(f"{PITCH}/{name}" for name in ("damping_ratio", "transmissibility")),
    *(f"{PITCH}/{name}" for name in ("angle_harmonics", "angle_peak")),
    *(
        f"{LEVER}/{support}_{kind}"
        for support in ("rigid", "steady")
        for kind in ("harmonics", "peak")
    ),
    *(f"{FORCE}/{name}" for name in ("static", "rigid_peak", "steady_harmonics", "steady_peak")),
    f"{MOVED}/sag",
    f"{MOVED}/steady_harmonics",
    *HEIGHTS,
)
#: how much wider than the forbidden zone of a resonance the zone is that is left to single runs
_WIDER = 1.01


def pitch_of(mounted: MountedPoints) -> model.Pitch:
    """The pitch model (points or 1,)."""
    return model.pitch_model(
        mounted.inertia, mounted.position, mounted.stiffness, mounted.damping, mounted.structural
    )


def couple_about_centre(forces: Forces, mounted: MountedPoints) -> Bounded:
    """Couple (points or 1, h) about the pitch axis per crank speed squared."""
    about = about_point(forces.per_square, mounted.centre[:, None, :])
    across = mounted.across
    return Bounded(about.couple @ across, about.couple_error @ np.abs(across))


def on_resonance(columns: Columns, forces: Forces, pitch: model.Pitch) -> BoolArray:
    """Points (points,) at which an order is on an undamped natural frequency, or next to it."""
    speed = columns.number("machine", "speed")[:, None]
    distance = forces.orders * speed / pitch.natural_frequency[:, None] - 1.0
    met = np.any(np.abs(distance) <= _WIDER * _exposed(pitch)[:, None], axis=1)
    return np.broadcast_to(met & (_exposed(pitch) > 0.0), columns.count)


def emit_pitch(columns: Columns, forces: Forces, mounted: MountedPoints, sheet: Sheet) -> None:
    """Model, motion, both readings of the support force and the sag, as far as they are wanted.

    No point may be on a resonance. Raises NumericalFailure where a machine would tip over.
    """
    pitch, speed = pitch_of(mounted), columns.number("machine", "speed")
    _emit_model(pitch, sheet)
    couple = couple_about_centre(forces, mounted)
    idle = (np.abs(couple.value) <= 4.0 * couple.error) & (_exposed(pitch) > 0.0)[:, None]
    couple = Bounded(
        np.where(idle, 0.0, couple.value) if idle.any() else couple.value, couple.error
    )
    square = np.square(speed)[:, None]
    value = couple.value * square
    torque = Bounded(value, couple.error * square + 2.0 * EPSILON * np.abs(value))
    frequency = forces.orders * speed[:, None]
    angle = model.angle_harmonics(pitch, torque.value, torque.error, frequency, idle)
    retained, counts = forces.retained, forces.counts
    axes = {"order": forces.orders[:retained]}

    def emit_orders(path: str, harmonics: Bounded) -> None:
        if sheet.wants(path):
            within = counted_only(
                Bounded(harmonics.value[:, :retained], harmonics.error[:, :retained]),
                counts[:, :retained],
            )
            sheet.emit(path, within, axes)

    if sheet.wants(f"{PITCH}/transmissibility"):
        passing = model.transmissibility(pitch, frequency)
        emit_orders(f"{PITCH}/transmissibility", passing)
    emit_orders(f"{PITCH}/angle_harmonics", angle)
    still = _scaled(peak_with_tail(couple, forces), square[:, 0]) if _wants_rigid(sheet) else None
    through = model.transmitted_couple(pitch, angle, frequency)
    for support, rows in (("rigid", torque), ("steady", through)):
        lever = Bounded(rows.value / mounted.lever[:, None], _over(rows, mounted.lever[:, None]))
        emit_orders(f"{LEVER}/{support}_harmonics", lever)
        if sheet.wants(f"{LEVER}/{support}_peak"):
            known = still if support == "rigid" else None
            peak = peak_with_tail(rows, forces) if known is None else known
            over = Bounded(peak.value / mounted.lever, _over(peak, mounted.lever))
            sheet.emit(f"{LEVER}/{support}_peak", over)
    if still is not None and sheet.wants(f"{FORCE}/rigid_peak"):
        share = np.abs(model.support_share(mounted.position, mounted.stiffness))
        top, uncertainty = still.value[:, None], still.error[:, None]
        force_peak = Bounded(share * top, share * (uncertainty + 8.0 * EPSILON * top))
        sheet.emit(f"{FORCE}/rigid_peak", force_peak, {"mount": mounted.names})
    _emit_supports(columns, forces, mounted, angle, frequency, sheet)


def _exposed(pitch: model.Pitch) -> FloatArray:
    """Relative half width (points or 1,) of the forbidden zone; zero where damping closes it."""
    width = (pitch.rounding + 2.0 * UNIT_ROUNDOFF) / SINGULAR
    return np.asarray(np.sqrt(np.maximum(width * width - np.square(pitch.damping_ratio), 0.0)))


def _wants_rigid(sheet: Sheet) -> bool:
    return sheet.wants(f"{LEVER}/rigid_peak", f"{FORCE}/rigid_peak")


def _scaled(peak: Bounded, factor: FloatArray) -> Bounded:
    top = peak.value * factor
    return Bounded(top, peak.error * factor + 3.0 * EPSILON * top)


def _over(rows: Bounded, lever: FloatArray) -> FloatArray:
    error: FloatArray = rows.error / lever + 2.0 * UNIT_ROUNDOFF * np.abs(rows.value / lever)
    return error


def _emit_model(pitch: model.Pitch, sheet: Sheet) -> None:
    for name in ("inertia", "stiffness", "damping"):
        value = getattr(pitch, name)
        sheet.emit(f"{PITCH}/{name}", Bounded(value, pitch.rounding * np.abs(value)))
    for name in ("natural_frequency", "damping_ratio"):
        found = Bounded(getattr(pitch, name), getattr(pitch, f"{name}_error"))
        sheet.emit(f"{PITCH}/{name}", found)


def _emit_supports(
    columns: Columns,
    forces: Forces,
    mounted: MountedPoints,
    angle: Bounded,
    frequency: FloatArray,
    sheet: Sheet,
) -> None:
    axes = {
        "mount": mounted.names,
        "direction": (columns.case.machine.crank_train.stroke,),
        "order": forces.orders[: forces.retained],
    }
    weight = mounted.mass * columns.number("isolation", "gravity")
    static = pitch_static(weight, 0.0, mounted.position, mounted.stiffness)
    sheet.emit(f"{MOVED}/sag", Bounded(static.sag, static.sag_error), axes)
    sheet.emit(f"{FORCE}/static", Bounded(static.share, static.share_error), axes)
    if sheet.wants(f"{MOVED}/steady_harmonics", f"{FORCE}/steady_harmonics"):
        _emit_harmonics(forces, mounted, angle, frequency, axes, sheet)
    if sheet.wants(*HEIGHTS, f"{PITCH}/angle_peak"):
        swing = peak_with_tail(angle, forces)
        sheet.emit(f"{PITCH}/angle_peak", swing)
        arm = np.abs(mounted.position)
        height = arm * swing.value[:, None]
        uncertainty = arm * swing.error[:, None] + 2.0 * EPSILON * height
        total = np.abs(static.sag) + height
        sheet.emit(HEIGHTS[0], Bounded(height, uncertainty), axes)
        whole = Bounded(total, static.sag_error + uncertainty + EPSILON * total)
        sheet.emit(HEIGHTS[1], whole, axes)
    if sheet.wants(f"{FORCE}/steady_peak"):
        alike = _alike(mounted)
        chosen = sorted(set(alike))
        some = mounted._replace(
            **{
                name: getattr(mounted, name)[:, chosen]
                for name in ("position", "stiffness", "damping", "structural")
            }
        )
        peak = peak_with_tail(_forces(some, angle, frequency), forces)
        which = [chosen.index(first) for first in alike]
        at_mounts = Bounded(peak.value[:, which], peak.error[:, which])
        sheet.emit(f"{FORCE}/steady_peak", at_mounts, axes)


def _emit_harmonics(
    forces: Forces,
    mounted: MountedPoints,
    angle: Bounded,
    frequency: FloatArray,
    axes: Mapping[str, object],
    sheet: Sheet,
) -> None:
    used = forces.retained
    moved = model.support_displacement(angle, mounted.position)
    for group, rows in ((MOVED, moved), (FORCE, _forces(mounted, angle, frequency))):
        cut = Bounded(rows.value[..., :used], rows.error[..., :used])
        within = counted_only(cut, forces.counts[:, :used])
        at_mounts = Bounded(within.value[:, :, None, :], within.error[:, :, None, :])
        sheet.emit(f"{group}/steady_harmonics", at_mounts, axes)


def _forces(mounted: MountedPoints, angle: Bounded, frequency: FloatArray) -> Bounded:
    return model.support_force(
        model.support_displacement(angle, mounted.position),
        frequency,
        mounted.stiffness,
        mounted.damping,
        mounted.structural,
    )


def _alike(mounted: MountedPoints) -> list[int]:
    """For each mount the first one whose force is the same at all points, up to its sign."""
    rows = (np.abs(mounted.position), mounted.stiffness, mounted.damping, mounted.structural)
    count = mounted.position.shape[1]
    wide = [np.broadcast_to(row, (len(row), count)) for row in rows]
    return [
        next(
            first
            for first in range(place + 1)
            if all(np.array_equal(row[:, first], row[:, place]) for row in wide)
        )
        for place in range(count)
    ]
