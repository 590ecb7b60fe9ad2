"""A shaft line at its operating speed: vibration, dampings; without dampers, with all firing."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene, below
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, bounded, rounded, square, where
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray
from vibecalc.numerics.synthesis import synthesis
from vibecalc.parts.pendulums import SMALL_SWING
from vibecalc.torsion.adapters import couplings, limits
from vibecalc.torsion.adapters.bounds import limit_corners
from vibecalc.torsion.adapters.coupling_states import coupled
from vibecalc.torsion.adapters.critical import beyond, emit_critical, emit_separation
from vibecalc.torsion.adapters.excitation import emit_excitation
from vibecalc.torsion.adapters.largest_alone import what_drives
from vibecalc.torsion.adapters.modes import ModeCopies, emit_modes
from vibecalc.torsion.adapters.motion import (
    HALF,
    STRESS,
    TORQUE,
    TWIST,
    Motion,
    emit_readings,
    readings_of,
    solved,
    stress_of,
)
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import (
    Setup,
    build_drive,
    build_model,
    build_setup,
    natural_of,
    placed,
)
from vibecalc.torsion.forced import ground_heat
from vibecalc.torsion.line import mapped, without_freedom
from vibecalc.torsion.results import ROOT, PowerBalance, of_line

# ----------------------------------------------------------------------------
# Adapter: a line over a range of speeds: curves and largest values.
# ----------------------------------------------------------------------------


def line_search(
    setup: Setup, speed: FloatArray, names: Sequence[str], others: dict[str, Any]
) -> Search:
    """Over speeds (s,): some of `readings_of` the line, and `others`, which are searched with it.

    Twists and stresses are those where the torque is largest, mean torques are not searched.
    """
    known = readings_of(setup)
    own = {name: known[name] for name in names if name in known}
    searched = [name for name in own if name not in (TWIST, STRESS, "gear_mean_torque")]
    corners = limit_corners(setup) if others else np.zeros(0)
    return Search([setup], speed, [own | others], [*searched, *others], corners)


def emit_curves(scene: Scene, stem: str, search: Search, names: Sequence[str]) -> None:
    """Some readings over the speeds."""
    found = {one: search.bounded_curves(one) for one in names if one in search.columns}
    emit_readings(scene, f"{stem}/speeds", search.lines[0], found, {"speed": search.speed})


def emit_largest(scene: Scene, stem: str, search: Search) -> Bounded:
    """Largest torques of sections with twists and stresses there; gives the torques (..., e)."""
    setup, place, top = search.lines[0], f"{stem}/largest", search.top(TORQUE)
    only: Any = slice(None) if setup.model.machines else 0
    found = {TORQUE: top.value[only]}
    if scene.wants(f"{place}/{TWIST}"):
        found[TWIST] = search.beside(TWIST, top)[only]
    if STRESS in readings_of(setup):
        found[STRESS] = stress_of(setup, found[TORQUE])
    emit_readings(scene, place, setup, found, {})
    scene.emit(f"{place}/speed", top.speed[only], axes={"section": setup.shaft.section_names})
    return found[TORQUE]


# ----------------------------------------------------------------------------
# Adapter: the same shaft line without its dampers, at the same speeds.
# ----------------------------------------------------------------------------

BARE = f"{ROOT}/without_dampers"
IN_BARE = below(f"{ROOT}/without_dampers/")


def bare_setup(setup: Setup) -> Setup:
    """The line without rings and what holds them; hubs belong to their stations and stay."""
    shaft = setup.shaft
    stays = np.flatnonzero([kind != "damper" for kind in shaft.section_kinds])
    # many machines differ in their rings alone
    bare = mapped(shaft.line, lambda one: one[0] if one.ndim > 1 else one)
    for damper in reversed(shaft.dampers):
        bare = without_freedom(bare, damper.ring, damper.element)[0]
    less = replace(
        shaft,
        line=bare,
        speed_stiffness=shaft.speed_stiffness[stays],
        section_ends=shaft.section_ends[stays],
        section_names=tuple(shaft.section_names[e] for e in stays),
        section_kinds=tuple(shaft.section_kinds[e] for e in stays),
        section_ratio=shaft.section_ratio[stays],
        section_modulus=shaft.section_modulus[stays],
        dampers=(),
    )
    torsion, speed = setup.torsion, setup.speed
    model, undamped = build_model(
        torsion, bare, less.speed_stiffness, speed, len(bare.inertia), shaft.over_speed
    )
    natural = natural_of(torsion, model, undamped, speed)
    line_of = setup._replace(shaft=less, model=model, undamped=undamped, natural=natural)
    return coupled(line_of)


def emit_bare(scene: Scene, setup: Setup, speed: FloatArray, damped: Bounded) -> None:
    """Curves and largest values without dampers; how much less they are with them.

    `damped` (..., e) are the largest torques of the whole line.
    """
    bare = bare_setup(setup)

    def torques() -> Bounded:
        search = line_search(bare, speed, HALF, {})
        emit_curves(scene, BARE, search, HALF)
        return emit_largest(scene, BARE, search)

    if not scene.wants(*IN_BARE):
        if scene.wants(f"{ROOT}/reduction"):
            # of runs before this one where they had the same line
            inputs = what_drives(bare.model, bare.drive, speed)
            known = None
            if inputs is not None:
                known = scene.again("largest torques of a line", (*inputs, bare.speed), torques)
            _emit_reduction(scene, bare, torques() if known is None else known, damped)
        return
    frequency = bare.modes.frequency
    modes = {"mode_without_dampers": np.arange(1, len(frequency) + 1)}
    scene.emit(f"{BARE}/natural_frequency", frequency, bare.modes.frequency_error, modes)
    emit_operating(scene, BARE, Motion(bare, np.array([bare.speed]), bounded=True))
    _emit_reduction(scene, bare, torques(), damped)


def emit_operating(scene: Scene, place: str, motion: Motion) -> None:
    """Half ranges at the operating speed; infinite where an order meets an undamped mode."""
    known = readings_of(motion.setup)
    found = {name: known[name].of(motion)[0] for name in HALF if name in known}
    emit_readings(scene, place, motion.setup, found, {})


def _emit_reduction(scene: Scene, bare: Setup, torque: Bounded, damped: Bounded) -> None:
    less = damped[..., : len(bare.shaft.section_names)]
    finite = np.isfinite(less.value) & np.isfinite(torque.value)
    finite &= less.value > 4.0 * less.errors  # a ratio to rounding tells nothing
    gain = where(finite, torque, 1.0) / where(finite, less, 1.0)
    axes = {"section": bare.shaft.section_names}
    scene.emit(f"{ROOT}/reduction", where(finite, gain, np.inf), axes=axes)


# ----------------------------------------------------------------------------
# Adapter: a shaft line whose cylinders all fire, next to its misfire.
# ----------------------------------------------------------------------------

HEALTHY = f"{ROOT}/healthy"


def emit_healthy(scene: Scene, setup: Setup, speed: FloatArray | None = None) -> None:
    """Half ranges, mean torque, dampers, use of limits at the operating speed.

    With speeds (s,) curves, largest values and uses over them instead.
    """
    firing = build_drive(scene.case, setup.shaft, all_fire=True)
    healthy = coupled(setup._replace(drive=firing))
    motion, limit = Motion(healthy, np.array([setup.speed]), bounded=True), f"{HEALTHY}/limit"
    axes = {"limit": np.arange(1, len(setup.torsion.limits) + 1)}
    if speed is not None:
        others = limits.uses(healthy, unbarred=True) | couplings.coupling_readings(healthy)
        search = line_search(healthy, speed, HALF, others)
        emit_curves(scene, HEALTHY, search, HALF)
        emit_largest(scene, HEALTHY, search)
        if setup.torsion.limits:
            limits.emit_uses(scene, limit, [motion], search, axes, here=False)
        if "coupling use" in search.columns:
            couplings.emit_largest_uses(scene, f"{HEALTHY}/coupling", search, {})
        return
    emit_operating(scene, HEALTHY, motion)
    scene.emit(f"{HEALTHY}/mean_torque", healthy.drive.mean_torque(motion.speed).sum()[0])
    if setup.torsion.limits:
        limits.emit_uses(scene, limit, [motion], None, axes)
    if setup.shaft.couplings:
        couplings.emit_uses(scene, f"{HEALTHY}/coupling", [motion], {})
    known = readings_of(healthy)
    rings: list[str] = [name for name in ("heat", "travel") if name in known]
    found = {name: known[name].of(motion)[0] for name in rings}
    emit_readings(scene, f"{HEALTHY}/damper", healthy, found, {})


# ----------------------------------------------------------------------------
# Adapter: a shaft line and its engine to modes, excitation, vibration at operating speed.
# ----------------------------------------------------------------------------


#: what the vibration at the operating speed gives
_STEADY = tuple(
    path
    for path in of_line(ranged=False)
    if path.split("/")[2] not in ("modes", "excitation", "critical", "damping", "healthy")
)


def run_torsion(scene: Scene) -> None:
    """Emit what holds at the operating speed, and hand the line on to its other stages.

    Raises NumericalFailure where an order meets a natural frequency that nothing damps.
    """
    setup = build_setup(scene.case, scene.once)
    if setup.shaft.couplings:
        from vibecalc.torsion.adapters.coupling_states import coupled

        setup = coupled(setup)
    scene.handed_on["torsion"] = setup[1:]
    moved = ModeCopies(setup)
    if _wants(scene, "modes/"):
        emit_modes(scene, setup, moved)
    if _wants(scene, "excitation/"):
        emit_excitation(scene, setup, moved)
    if setup.shaft.station_laws:
        emit_dampings(scene, setup)
    if scene.wants(*_STEADY):
        emit_steady(scene, setup)
    emit_critical(scene, setup)
    if setup.torsion.misfire and _wants(scene, "healthy/"):
        emit_healthy(scene, setup)


def _wants(scene: Scene, folder: str) -> bool:
    """Whether any result of a folder is asked for."""
    place = f"{ROOT}/{folder}"
    return scene.wanted is None or any(path.startswith(place) for path in scene.wanted)


def setup_of(scene: Scene) -> Setup:
    """What this stage has left for those after it."""
    response = scene.case.response
    assert response is not None and response.torsion is not None
    # with the table as this case has it: the line may be one that another case has left
    return Setup(response.torsion, *scene.handed_on["torsion"])


# ----------------------------------------------------------------------------
# Adapter: vibration of a shaft line at the operating speed, all orders and their sums.
# ----------------------------------------------------------------------------

#: an order below this share of the lowest elastic mode is lost next to the rigid motion
SLOW = 0.1


#: readings of dampers and gears -> where they stand at the operating speed
AT_SPEED = {
    "heat": "damper/heat",
    "travel": "damper/travel",
    "gear_mean_torque": "gear/mean_torque",
    "gear_torque": "gear/alternating_torque",
    "gear_minimum_torque": "gear/minimum_torque",
}


def emit_steady(scene: Scene, setup: Setup) -> None:
    """Angles, twists, torques and stresses by order, their half ranges, heat, gears, margins."""
    motion, shaft = Motion(setup, np.array([setup.speed]), bounded=True), setup.shaft
    refuse_unbounded(setup, motion)
    names = {
        "station": shaft.station_names,
        "section": shaft.section_names,
        "order": setup.drive.order,
    }
    for name in ("angle", "twist", "torque"):
        scene.emit(f"{ROOT}/{name}", motion.orders(name)[0].T, axes=names)
    stations, sections = np.arange(len(shaft.station_names)), np.arange(len(shaft.section_names))
    scene.emit(f"{ROOT}/angle_peak", motion.sums("angle", stations).peak[0], axes=names)
    scene.emit(f"{ROOT}/torque_bound", motion.sums("torque", sections).bound[0], axes=names)
    known = readings_of(setup)
    if "stress_half_range" in known:
        of = known["stress_half_range"]
        of_section = {**names, "section": of.names}
        scene.emit(f"{ROOT}/stress", motion.orders("stress", of.place)[0].T, axes=of_section)
    scene.emit(f"{ROOT}/torque_mean", motion.mean.section[0] / shaft.section_ratio, axes=names)
    _power_balance(scene, setup)
    found = {name: reading.of(motion)[0] for name, reading in known.items()}
    emit_readings(scene, ROOT, setup, found, {}, AT_SPEED)
    for place in np.flatnonzero([one.kind == "pendulum" for one in shaft.dampers]):
        if (swing := float(found["travel"].value[place])) > SMALL_SWING:
            scene.warn(
                f"damper {shaft.dampers[place].name!r}: its pendulums swing by "
                f"{np.degrees(swing):.4g} degrees, by equations for small swings (up to "
                f"{np.degrees(SMALL_SWING):.3g} degrees)"
            )
    if shaft.gears:
        least, alternating = found["gear_minimum_torque"], found["gear_torque"]
        hammers = (least.value < -least.error).astype(np.int64)
        scene.emit(f"{ROOT}/gear/hammers", hammers, 0.0, {"gear": known["gear_torque"].names})
        unsure = (np.abs(least.value) <= least.error) & (alternating.value > 0.0)
        for gear in np.flatnonzero(unsure):
            name = shaft.gears[gear].name
            scene.warn(f"gear {name!r}: its minimum torque is zero within its error")
    if setup.torsion.limits:
        from vibecalc.torsion.adapters.limits import emit_operating_use

        emit_operating_use(scene, setup, motion)
    if shaft.couplings:
        from vibecalc.torsion.adapters.couplings import emit_couplings

        emit_couplings(scene, setup, motion)
    _heat(scene, setup, motion)
    _margins(scene, setup)
    if scene.wanted is None:  # a study of many points needs no sentences
        warn_of_orders(scene, setup)
    scene.cite(
        "elimination along the line at every order, sums over the cycle with phase",
        "forced vibration, half ranges",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958; Pestel and Leckie, "
        "Matrix Methods in Elastomechanics, 1963",
    )


def refuse_unbounded(setup: Setup, motion: Motion) -> None:
    """Raise NumericalFailure naming mode and order where nothing damps what an order excites."""
    state = motion.state
    met = np.flatnonzero(state.masked[0])
    if not len(met):
        return
    order, w = setup.drive.order[met[0]], float(state.frequency[0, met[0]])
    every = setup.natural().frequency
    mode = nearest_mode(every, np.array([w]))[0]
    natural = float(every[mode - 1]) if mode else 0.0
    rpm = setup.speed * 30.0 / np.pi
    if every[0] == 0.0 and not w >= SLOW * natural > 0.0:
        lowest = f", {natural:.9g} rad/s" if mode else ""
        raise NumericalFailure(
            f"order {order:g} at {setup.speed:.9g} rad/s ({rpm:.6g} rpm) is so slow that the "
            "shaft line turns as one rigid body (mode 1, 0 rad/s): the twists of its shafts "
            "are lost in the rounding of its angles. Take a speed that is not so far below "
            f"the lowest elastic mode{lowest}"
        )
    raise NumericalFailure(
        f"order {order:g} at {setup.speed:.9g} rad/s ({rpm:.6g} rpm) is on the undamped "
        f"natural frequency of mode {mode} of the shaft line, {natural:.9g} rad/s: its "
        "response has no bound there. Give shafts, stations or a damper some damping, or "
        "move the speed"
    )


#: of the power of the cylinders, what loads may take more before a sentence says so
UNBALANCED = 0.01


def _power_balance(scene: Scene, setup: Setup) -> None:
    """Mean torque and power of every source and load, and what the load station has to take."""
    shaft, drive, speed = setup.shaft, setup.drive, setup.speed
    at, count = np.array([speed]), len(shaft.station_names)
    source = drive.mean_torque(at)[0] @ placed(drive.station, count)
    load = rounded(shaft.taken(speed), 4.0) @ placed(shaft.taken_station, count)
    given, taken = source.sum(), load.sum()
    rest, place = given - taken, shaft.load_station
    own, cylinders = rounded(1.0 / np.abs(shaft.station_ratio), 2.0), len(drive.firing.names)
    found: dict[str, Bounded] = {}
    if cylinders:
        found |= {"source_torque": source * own, "source_power": speed * source}
    if len(shaft.taken_station):
        found |= {"load_torque": load * own, "load_power": speed * load}
    if cylinders or len(shaft.taken_station):
        found |= {"rest_torque": rest * own[place], "rest_power": speed * rest}
    drives = bool(given.value > given.error)
    if cylinders and len(shaft.taken_station) and scene.case.machine.kind == "engine":
        share = taken * (1.0 / given) if drives else bounded(np.inf)
        found |= {"total_load_power": speed * taken, "load_share": share}
    scene.emit_all(PowerBalance(**found), {"station": shaft.station_names})
    if drives and -rest.value > rest.error + UNBALANCED * given.value:
        torques = [f"{1e-3 * one.value:.4g}" for one in (taken, given, -rest)]
        powers = [f"{1e-3 * speed * one.value:.4g}" for one in (taken, given, -rest)]
        scene.warn(
            f"power balance: loads absorb {torques[0]} kN m at the crank speed ({powers[0]} kW), "
            f"cylinders deliver {torques[1]} kN m ({powers[1]} kW); station "
            f"'{shaft.station_names[place]}', which balances the line, has to supply {torques[2]} "
            f"kN m ({powers[2]} kW)"
        )


def nearest_mode(natural: FloatArray, frequency: FloatArray) -> np.ndarray:
    """Number, from 1, of the elastic mode nearest in ratio to frequencies (k,); 0 for none."""
    elastic = np.flatnonzero(natural > 0.0)
    if not len(elastic):
        return np.zeros(len(frequency), dtype=np.int64)
    away = np.abs(np.log(frequency[:, None] / natural[elastic]))
    return np.asarray(elastic[np.argmin(away, axis=1)] + 1)


def _heat(scene: Scene, setup: Setup, motion: Motion) -> None:
    """Mean powers of sections and stations, all orders together."""
    shaft, line, state = setup.shaft, setup.model.line, motion.state
    names = {"section": shaft.section_names, "station": shaft.station_names}
    element = motion.heat(np.arange(len(shaft.section_names)))[0]
    ground = ground_heat(line, state.frequency, state.angle).sum(axis=-2)[0]
    total = line.absolute_damping[shaft.freedom]
    # two damping ratios may ask for less than none
    share = np.divide(shaft.station_values[1], total, out=np.zeros_like(total), where=total != 0.0)
    at_station = ground[shaft.freedom] * share
    # a damping model may brake rings, too
    rings, carriers = (
        np.array([getattr(one, name) for one in shaft.dampers], dtype=int)
        for name in ("ring", "station")
    )
    of_rings = ground[rings] @ placed(carriers, len(shaft.station_names))
    scene.emit(f"{ROOT}/section_heat", element, axes=names)
    scene.emit(f"{ROOT}/station_heat", at_station + of_rings, axes=names)
    if setup.torsion.damping_model is not None and setup.torsion.damping_model.kind == "modal":
        _heat_of_modes(scene, setup, state.frequency[0][:, None], state.angle[0])


def _heat_of_modes(scene: Scene, setup: Setup, w: FloatArray, angle: Bounded) -> None:
    """Mean power (m,) of ratios by mode, w^2 c |coordinate|^2 / 2: it has no place in the line."""
    modal, modes, inertia = setup.model.modal, setup.modes, setup.model.line.inertia
    assert modal is not None
    shape = Bounded(modes.shape, modes.shape_error[:, None] + 8.0 * EPSILON)
    coordinate = angle @ (shape * (inertia / modes.modal_inertia[:, None])).T
    power = 0.5 * w * (w * modal.dashpot + modal.loss) * square(abs(coordinate))
    value = power.sum(axis=0)
    scene.emit(f"{ROOT}/modal_heat", value, axes={"mode": np.arange(1, len(modes.shape) + 1)})
    if np.any(value.value > 0.0):
        scene.warn(
            "modal damping ratios replace the damping of shafts, stations and dampers: their heat, "
            f"{value.value.sum():.4g} W in all modes together, cannot be assigned to sections, "
            "stations and dampers"
        )


def _margins(scene: Scene, setup: Setup) -> None:
    """Nearest order to each mode, and how far it is as a share of the order's frequency.

    Order 0, infinitely far, for the modes that are `beyond` all orders.
    """
    natural, order = setup.natural().frequency, setup.drive.order
    excited = setup.speed * order
    distance = natural[:, None] / excited - 1.0
    nearest = np.argmin(np.abs(distance), axis=1)
    axes = {"mode": np.arange(1, len(natural) + 1)}
    blank = beyond(setup, setup.speed)
    value = np.where(blank, np.inf, np.abs(distance[np.arange(len(natural)), nearest]))
    error = setup.natural().frequency_error / excited[nearest] + 4.0 * EPSILON
    scene.emit(f"{ROOT}/margin/nearest_order", np.where(blank, 0.0, order[nearest]), 0.0, axes)
    scene.emit(f"{ROOT}/margin/distance", value, np.where(blank, 0.0, error), axes)
    emit_separation(scene, setup, "operating", setup.speed, setup.speed)


# ----------------------------------------------------------------------------
# Adapter: what the orders that a case leaves out would add to the torques of its shafts.
# ----------------------------------------------------------------------------

#: a share of the half range that is worth a sentence
NOTICEABLE = 0.01


def warn_of_orders(scene: Scene, setup: Setup) -> None:
    """Look at the operating speed at twice as many orders, by the smallest step of the cycle."""
    if not np.any(setup.drive.fires):
        return
    used = setup.drive.order[setup.drive.fires]
    base = 2.0 * np.pi / setup.drive.firing.cycle
    drive = build_drive(scene.case, setup.shaft, orders=(2.0 * float(used[-1]), float(base)))
    _warn_of_gaps(scene, used[-1], base)
    state = solved(setup.model, drive, np.array([setup.speed]))
    order, torque = drive.order, state.torque[0].T / setup.shaft.section_ratio[:, None]
    known = ~drive.fires | (np.min(np.abs(order[:, None] - used), axis=1) < 0.25 * base)
    half = synthesis(drive.cycles.some(known), torque[:, known]).half_range
    noticeable = half > NOTICEABLE * half.max(initial=0.0)
    if not np.any(noticeable):
        return
    safe = np.where(noticeable, half, np.inf)

    def tell(chosen: BoolArray, what: str) -> None:
        met = order[chosen & state.masked[0]]
        if len(met):
            scene.warn(
                f"{what} are neglected; order {met[0]:g} coincides with an undamped natural "
                "frequency at the operating speed, where its response is unbounded"
            )
            return
        added = synthesis(drive.cycles.some(chosen), torque[:, chosen]).half_range
        most = int(np.argmax(added / safe))
        if added[most] > NOTICEABLE * safe[most]:
            scene.warn(
                f"{what} are neglected, also in error estimates: at the operating speed their half "
                f"range in '{setup.shaft.section_names[most]}' is "
                f"{100.0 * added[most] / half[most]:.3g} % of that of the orders of the case"
            )

    between = ~known & (order < used[-1])
    if np.any(between):
        step = float(used[0])
        half_orders = "half orders" if step == 1.0 and base < 1.0 else "orders between"
        tell(between, f"the {half_orders}, since the step of the orders is {step:g},")
    above = f"the orders above {used[-1]:g}, up to {order[-1]:g}{_gas_ends(scene, order[-1])},"
    tell(order > used[-1] + 0.25 * base, above)


def _warn_of_gaps(scene: Scene, highest: float, base: float) -> None:
    """Tell of orders below the highest that the gas of such an engine has and its table has not."""
    given = scene.case.machine.crank_train.tangential_effort
    every = base * np.arange(1, round(highest / base))
    lacking = [] if given is None else every[~np.isin(every, given.harmonics.order)].tolist()
    if lacking:
        words = ", ".join(f"{one:g}" for one in lacking[:3]) + ", ..." * (len(lacking) > 3)
        scene.warn(
            f"the table of tangential effort has no order {words}: this gas excitation is "
            "neglected, also in error estimates"
        )


def _gas_ends(scene: Scene, highest: float) -> str:
    """Where a table of tangential effort ends below the highest order of the masses."""
    given = scene.case.machine.crank_train.tangential_effort
    last = highest if given is None else max(given.harmonics.order)
    return f" (of the gas up to {last:g}, where its table ends)" if last < highest else ""


# ----------------------------------------------------------------------------
# Adapter: dampings of stations and sections on their own shafts, at one speed and over speeds.
# ----------------------------------------------------------------------------

#: of a law with a power, a table between entries, and what is referred and brought back
ROUNDINGS = 16.0


def _own(setup: Setup, speed: FloatArray | float) -> tuple[Bounded, Bounded, Bounded]:
    """Absolute dampings (..., s), dashpots and loss factors (..., e) at speeds (...)."""
    shaft = setup.shaft
    line = shaft.at(speed)
    found = (
        shaft.station_damping(speed) / shaft.station_ratio**2,
        line.damping / shaft.section_ratio**2,
        line.loss_factor,
    )
    station, dashpot, loss = (rounded(one, ROUNDINGS) for one in found)
    return station, dashpot, loss


def emit_dampings(scene: Scene, setup: Setup) -> None:
    """Those at the operating speed, where they are more than numbers of the case."""
    shaft = setup.shaft
    if not shaft.station_laws or setup.torsion.damping_model is not None:
        return
    axes = {"station": shaft.station_names, "section": shaft.section_names}
    for name, value in zip(
        ("station", "section", "loss_factor"), _own(setup, setup.speed), strict=True
    ):
        scene.emit(f"{ROOT}/damping/{name}", value, axes=axes)


def emit_damping_curves(scene: Scene, setup: Setup, speed: FloatArray) -> None:
    """Those over speeds (s,) that follow them."""
    shaft, follow = setup.shaft, setup.model.over_speed
    if follow is None:
        return
    station, dashpot, loss = _own(setup, speed)
    moving = [n for n, laws in enumerate(shaft.station_laws) if any(one.follows for one in laws)]
    for name, axis, names, places, value in (
        ("station_damping", "station", shaft.station_names, moving, station),
        ("section_damping", "section", shaft.section_names, list(follow.element), dashpot),
        ("section_loss_factor", "section", shaft.section_names, list(follow.lossy), loss),
    ):
        if places:
            axes = {axis: tuple(names[n] for n in places), "speed": speed}
            value = Bounded(*(np.broadcast_to(one, (len(speed), one.shape[-1])) for one in value))
            scene.emit(f"{ROOT}/speeds/{name}", value[:, places].T, axes=axes)
