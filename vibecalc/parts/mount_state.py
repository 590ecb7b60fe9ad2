"""Mounts under the weight of their body: stiffness at rest, about it, over frequency."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray
from vibecalc.parts.body import DIRECTIONS, RigidBody, build_body, cross_matrix, dofs_of_model
from vibecalc.parts.body_tables import Mount
from vibecalc.parts.mount_needs import frequency_counts, loads_count
from vibecalc.parts.mounts import Mounts, build_mounts, free_motions, mount_entries, rotation
from vibecalc.schema import Case

if TYPE_CHECKING:
    from vibecalc.parts.equilibrium import Rest
    from vibecalc.parts.mount_curves import Law, Spectrum, TangentByLoad
    from vibecalc.parts.mount_tables import OverLoad, Static

# ----------------------------------------------------------------------------
# The dynamic stiffness of a mount follows the load that it carries where the body is at rest: by
# its rows over the load, or as the tangent of its load over deflection times the ratio of dynamic
# to static stiffness. A stop on which it stands adds its own. Where rows over the load come without
# a load over deflection, that has the stiffness of the rows, over the same ratio, as its tangent.
# ----------------------------------------------------------------------------


def mounts_of(case: Case) -> Mounts | None:
    """The mounts of a validated case, at rest under its weight where that counts.

    None without any, or where a stiffness matrix is given.

    Raises NumericalFailure if no rest is found, or a mount is loaded beyond its rows of load over
    deflection there.
    """
    given = case.machine.mounts
    if given is None or given.stiffness_matrix is not None:
        return None
    built = build_mounts(given)
    entries = mount_entries(given)
    if frequency_counts(given):
        built = replace(built, spectrum=_spectrum(entries))
        if case.isolation is not None:
            built = replace(built, axis=_axes(entries, case.isolation.up)[2])
    if not loads_count(given):
        return built
    from vibecalc.parts.equilibrium import equilibrium
    from vibecalc.parts.mount_curves import Level

    if case.machine.body is None or case.isolation is None:
        raise ValueError("mounts under load need a body and [isolation]")
    options = case.isolation
    axes, turns, axis = _axes(entries, options.up)
    dynamic = np.array([np.broadcast_to(np.asarray(one.stiffness or 0.0), 3) for one in entries])
    ratio = np.array([1.0 if e.static is None else e.static.dynamic_to_static for e in entries])
    along = dynamic[range(len(axes)), axes]
    square = dynamic.copy()
    square[range(len(axes)), axes] = 0.0
    across = _turned(turns, square)
    laws = [_law(*each) for each in zip(entries, along / ratio, strict=True)]
    body = build_body(case.machine.body)
    load, error = _weight(body, np.eye(3)[DIRECTIONS.index(options.up)] * options.gravity)
    freedoms = dofs_of_model(options.model, case.machine.crank_train.axis)
    static = across / ratio[:, None, None]
    # about the mass centre: errors about an origin far away would be those of its levers
    lever = built.position - body.centre
    rest = equilibrium(lever, axis, static, laws, load, error, freedoms)
    _require_rows(entries, laws, rest)

    uncertain = np.zeros(len(entries))
    for place, (one, law) in enumerate(zip(entries, laws, strict=True)):
        if one.over_load is not None:
            curve = Level(one.over_load.load, _over_load(one.over_load, 1.0))
            factor, bend = (float(curve(rest.load.value[place], n)) for n in (0, 1))
            uncertain[place] = abs(bend) * rest.load.error[place] / factor
            along[place] *= factor
            across[place] *= factor
        elif law.cubic or law.range[0] > -np.inf:
            along[place] = ratio[place] * rest.slope.value[place]
            uncertain[place] = rest.slope.error[place] / rest.slope.value[place]
    along += rest.stop
    stiffness = across + along[:, None, None] * (axis[:, :, None] * axis[:, None, :])
    loss = np.array([one.loss_factor or 0.0 for one in entries])
    return replace(
        built,
        stiffness=stiffness,
        structural=loss[:, None, None] * stiffness,
        static=rest.tangent,
        rest=rest,
        relative_error=uncertain + 8.0 * UNIT_ROUNDOFF,
        axis=axis,
        laws=tuple(laws),
    )


def never_held(case: Case, dofs: Sequence[int] | NDArray[np.intp] = range(6)) -> list[str]:
    """Motions, in words, that no mount resists by stiffness, or by curve or stop on its axis."""
    given = case.machine.mounts
    assert given is not None
    built, entries = build_mounts(given), mount_entries(given)
    if loads_count(given):
        if case.isolation is None:
            return []  # nothing says what is up, and the checks of mounts say that
        _, _, axis = _axes(entries, case.isolation.up)
        bent = np.array([one.static is not None and _bends(one.static) for one in entries])
        scale = built.stiffness.max() or 1.0
        held = axis[:, :, None] * axis[:, None, :] * bent[:, None, None]
        built = replace(built, stiffness=built.stiffness + scale * held)
    return free_motions(built, dofs)


def _bends(static: "Static") -> bool:
    return bool(static.load_deflection or static.cubic_stiffness or static.stops)


def _axes(entries: tuple[Mount, ...], up: str) -> tuple[list[int], list[FloatArray], Any]:
    """Which of its own axes each mount carries along, its turn, and that axis (n, 3)."""
    axes = [
        DIRECTIONS.index(up if one.static is None else one.static.axis or up) for one in entries
    ]
    turns = [rotation(*one.orientation) for one in entries]
    along = np.array([turn[:, place] for turn, place in zip(turns, axes, strict=True)])
    return axes, turns, along


def _turned(turns: list[FloatArray], values: FloatArray) -> FloatArray:
    """Matrices (n, 3, 3) in body axes of stiffness (n, 3) along the axes of the mounts."""
    turned = [(turn * one) @ turn.T for turn, one in zip(turns, values, strict=True)]
    return np.array([0.5 * (one + one.T) for one in turned])


def _law(entry: Mount, linear: float) -> "Law":
    """Static load over deflection: as given, or with the tangent of `over_load` at each load."""
    from vibecalc.parts.mount_curves import Law
    from vibecalc.parts.mount_tables import Static

    static, rows = entry.static or Static(), entry.over_load
    given, cubic, stops = static.load_deflection, static.cubic_stiffness or 0.0, static.stops
    curve = None if given is None else (given.deflection, given.load)
    own = None
    if rows is not None and given is None and not cubic:
        own = _tangent(rows.load, _over_load(rows, linear))
    if stops is None:
        return Law(linear, cubic, curve, by_load=own)
    down, up = (np.inf if end is None else end for end in (stops.down, stops.up))
    return Law(linear, cubic, curve, down, up, stops.stiffness, own)


def _over_load(rows: "OverLoad", nominal: float) -> tuple[float, ...]:
    """Stiffness in the rows, `nominal` where the factor is 1, or in the first row of stiffness."""
    if rows.stiffness_factor:
        return tuple(nominal * factor for factor in rows.stiffness_factor)
    values = rows.stiffness or ()
    return tuple(nominal * (value / values[0]) for value in values)


@lru_cache(maxsize=16)
def _tangent(load: tuple[float, ...], stiffness: tuple[float, ...]) -> "TangentByLoad":
    """Built once for equal mounts."""
    from vibecalc.parts.mount_curves import Level, TangentByLoad

    return TangentByLoad(Level(load, stiffness))


def _weight(body: RigidBody, up: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weight (6,) about the mass centre and its error; `up` is against gravity, m/s^2."""
    pull = -body.mass * up
    off = 2.0 * UNIT_ROUNDOFF * np.abs(body.centre)
    off = off if body.centre_error is None else body.centre_error + off
    couple = np.abs(cross_matrix(off)) @ np.abs(pull)
    error = np.concatenate([8.0 * UNIT_ROUNDOFF * np.abs(pull), couple])
    return np.concatenate([pull, np.zeros(3)]), error


def _require_rows(entries: tuple[Mount, ...], laws: "list[Law]", rest: "Rest") -> None:
    """Refuse a rest beyond the rows of load over deflection."""
    for one, law, u, load in zip(
        entries, laws, rest.deflection.value, rest.load.value, strict=True
    ):
        low, high = law.range
        if not low <= u <= high:
            raise NumericalFailure(
                f"at rest mount {one.name!r} carries {load:.6g} N at a deflection of {u:.6g} m, "
                f"beyond its rows of load_deflection, from {low:.6g} to {high:.6g} m: what it does "
                "there is not known; add rows, or choose other mounts"
            )


def _spectrum(entries: tuple[Mount, ...]) -> "Spectrum":
    """Stiffness over its nominal one and loss factor; equal rows are one curve."""
    from vibecalc.parts.mount_curves import Level, Spectrum

    curves: dict[tuple[float, ...], Level] = {}

    def curve(at: tuple[float, ...], values: tuple[float, ...] | None, over: float) -> Level | None:
        if values is None:
            return None
        return curves.setdefault((*at, over, *values), Level(at, np.array(values) / over))

    factors, losses = [], []
    for one in entries:
        rows = one.over_frequency
        stiffness = None if rows is None else rows.stiffness
        first = stiffness[0] if stiffness else 1.0
        given = None if rows is None else rows.stiffness_factor or stiffness
        factors.append(None if rows is None else curve(rows.frequency, given, first))
        losses.append(None if rows is None else curve(rows.frequency, rows.loss_factor, 1.0))
    loss = np.array([one.loss_factor or 0.0 for one in entries])
    return Spectrum(tuple(factors), tuple(losses), loss)
