"""Physical checks of absorbers and pendulums: ratios, hardware that can be built, swing."""

from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from typing import Any

import numpy as np

from vibecalc.absorber.asked_tables import Tuning, Vary
from vibecalc.absorber.hardware.oil_gap import Walther, known_range
from vibecalc.absorber.model import (
    PRIMARY,
    Scale,
    arranged,
    clearance,
    primary_damping,
    primary_scale,
    ratios,
    rubbed_mass,
    side_by_side,
    single_absorber,
)
from vibecalc.absorber.tables import ICE, WAYS, Secondary
from vibecalc.core.case.raw import listed, nearest
from vibecalc.errors import KeyPath, NumericalFailure, Problem, listing
from vibecalc.numerics.rounding import BoolArray
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Are the ratios of an absorber those of a machine, and is there something to be tuned?
# ----------------------------------------------------------------------------

MACHINE: KeyPath = ("machine",)
SECONDARIES: KeyPath = ("machine", "secondaries")
#: Ratios beyond these are limits (locked, free, a second ground) and no parts that are built.
BOUNDS = {"mass": (1e-9, 1e6), "stiffness": (1e-15, 1e9), "damping": (1e-12, 1e6)}
#: mass ratios up to which tunings are found: of one absorber, of one for the force that a moving
#: ground transmits, of each of several
TUNED, TUNED_TRANSMITTED, TUNED_SEVERAL = 1e4, 30.0, 10.0
_LOCKED = "limits = true in [response.absorber] draws a secondary that is locked to the primary"
_HINTS = {
    "mass": "with an infinite mass the absorber acts as a second ground",
    "stiffness": _LOCKED,
    "damping": _LOCKED,
}
#: a ratio where it stands, and of what it is
Stated = tuple[KeyPath, str, float]


@listing
def absorber_problems(case: Case) -> Iterator[Problem]:
    """Problems of the ratios, of what carries what, and of the tuning and the curves asked for."""
    if case.machine.primary is None:
        return
    for path, what, value in _stated(case):
        yield from within(path, what, value)
    yield from _too_heavy(case)
    yield from _carried(case)
    yield from _tuning(case)
    yield from _curves(case)


def _stated(case: Case) -> Iterator[Stated]:
    """Every ratio to the primary that a case says or gives by numbers in units."""
    machine, tuning = case.machine, case.tuning
    assert machine.primary is not None
    scale = primary_scale(machine)
    keys = ("damping", "linear_damping")
    key = next((k for k in keys if getattr(machine.primary, k) is not None), "damping_ratio")
    yield ("machine", "primary", key), "damping", primary_damping(machine.primary, scale)
    if machine.secondary is not None:
        yield from _of_one(("machine", "secondary"), machine.secondary, scale)
    rubbed = machine.friction_damper
    if rubbed is not None:
        key = next(key for key in WAYS["mass"] if getattr(rubbed, key) is not None)
        yield ("machine", "friction_damper", key), "mass", rubbed_mass(rubbed, scale).mass_ratio
    for place, one in enumerate(machine.secondaries):
        yield from _of_one((*SECONDARIES, place), one, scale)
    if tuning is not None and tuning.bounds is not None:
        for key, what in (
            ("stiffness_ratio", "stiffness"),
            ("damping_over_primary_critical", "damping"),
        ):
            for end in getattr(tuning.bounds, key) or ():
                yield ("tuning", "bounds", key), what, end
    if tuning is not None and tuning.chart is not None:
        chart, path = tuning.chart, ("tuning", "chart")
        for place, ratio in enumerate(chart.primary_damping):
            yield (*path, "primary_damping", place), "damping", ratio
        yield (*path, "mass_ratio", "from"), "mass", chart.mass_ratio.start
        yield (*path, "mass_ratio", "to"), "mass", chart.mass_ratio.stop
    curves = None if case.response is None else case.response.absorber
    if curves is not None and curves.vary is not None:
        for key in Vary.model_fields:
            for place, value in enumerate(getattr(curves.vary, key)):
                what = next(one for one in WAYS if one in key)
                yield ("response", "absorber", "vary", key, place), what, value


def _of_one(path: KeyPath, one: Secondary, scale: Scale | None) -> Iterator[Stated]:
    given = {
        what: [key for key in keys if getattr(one, key) is not None] for what, keys in WAYS.items()
    }
    # a ring that gives the inertia is examined with the other parts
    found = ratios(one, scale, None if given["mass"] else 1.0)
    for (what, keys), value in zip(given.items(), found, strict=True):
        if keys and value is not None:
            yield (*path, keys[0]), what, value


def within(path: KeyPath, what: str, value: float) -> Iterator[Problem]:
    """A ratio of masses, stiffnesses or dampings that no machine has; the last two may be zero."""
    low, high = BOUNDS[what]
    if low <= value <= high or (value == 0.0 and what != "mass"):
        return
    zero = "" if what == "mass" else "0, or "
    yield Problem(
        path=path,
        message=f"the ratio of this {what} to that of the primary is too "
        + ("large" if value > high else "small"),
        found=f"{value:.6g}",
        allowed=f"{zero}{low:.0e} to {high:.0e}",
        hint=_HINTS[what] if value > high else "",
    )


def absorber_suspects(case: Case) -> BoolArray | None:
    """Points (...) of a case with arrays that `absorber_problems` may refuse.

    Of one absorber by its ratios, None else.
    """
    machine, tuning = case.machine, case.tuning
    curves = None if case.response is None else case.response.absorber
    if machine.primary is None or machine.secondary is None:
        return None
    if curves is not None and curves.vary is not None:
        return None
    if tuning is not None and (tuning.kind != "free" or tuning.bounds is not None):
        return None
    found: BoolArray = np.zeros((), dtype=bool)
    for _, what, ratio in _stated(case):
        low, high = BOUNDS[what]
        if what == "mass" and tuning is not None:
            high = min(high, _heaviest(tuning))
        value = np.asarray(ratio)
        none = (value == 0.0) & (what != "mass")
        found = found | ~((low <= value) & (value <= high) | none)
    return found


def _heaviest(tuning: Tuning) -> float:
    """The mass ratio up to which a tuning of one absorber is found."""
    pair = tuning.excitation, tuning.response
    return TUNED_TRANSMITTED if pair == ("base", "transmitted_force") else TUNED


def _too_heavy(case: Case) -> Iterator[Problem]:
    """Masses with which no tuning is found."""
    if case.tuning is None:
        return
    most = TUNED_SEVERAL if case.machine.secondaries else _heaviest(case.tuning)
    for path, what, ratio in _stated(case):
        drawn = path[0] == "response" or path[-1] == "from"
        if what == "mass" and not drawn and most < ratio <= BOUNDS["mass"][1]:
            yield Problem(
                path=path,
                message="no tuning is found for an absorber so much heavier than the primary",
                found=f"a mass ratio of {ratio:.6g}",
                allowed=f"<= {most:g} with [tuning]",
                hint="should primary and absorber be exchanged?",
            )


def _carried(case: Case) -> Iterator[Problem]:
    """Each of several absorbers hangs, at the end, on the primary."""
    given = case.machine.secondaries
    names = [one.name for one in given]
    for place, one in enumerate(given):
        path: KeyPath = (*SECONDARIES, place)
        if one.name == PRIMARY:
            yield Problem(
                path=(*path, "name"),
                message=f"{PRIMARY!r} is the name of the primary system",
                hint="give each its own name",
            )
        elif one.on not in (PRIMARY, *names):
            yield Problem(
                path=(*path, "on"),
                message=f"no absorber is named {one.on[:60]!r}",
                allowed=listed([PRIMARY, *(name for name in names if name != one.name)]),
                hint=nearest(one.on, [PRIMARY, *names]),
            )
    try:
        TopologicalSorter({one.name: [one.on] for one in given if one.name != PRIMARY}).prepare()
    except CycleError as circle:
        ring = circle.args[1][:0:-1]
        yield Problem(
            path=(*SECONDARIES, names.index(ring[0]), "on"),
            message="these absorbers are attached to each other, and none of them to the primary"
            if len(ring) > 1
            else "an absorber cannot be attached to itself",
            found=" on ".join(map(repr, [*ring, ring[0]])),
            allowed=f"one of them on = {PRIMARY!r}",
        )


def _tuning(case: Case) -> Iterator[Problem]:
    tuning, machine = case.tuning, case.machine
    if tuning is None or machine.primary is None:
        return
    scale = primary_scale(machine)
    damping = primary_damping(machine.primary, scale)
    charted = () if tuning.chart is None else tuning.chart.primary_damping
    if tuning.kind == "undamped_spring" and 0.0 in (damping, *charted):
        in_chart = damping > 0.0
        yield Problem(
            path=("tuning", "chart", "primary_damping") if in_chart else ("tuning", "kind"),
            message="no optimum exists: without damping the peaks are infinite for every spring",
            found="kind = 'undamped_spring' and an undamped primary",
            allowed="a primary with damping, or another kind",
            hint="the spring that tunes the absorber to one frequency has K2 / J2 = w^2",
            also=("tuning", "kind") if in_chart else ("machine", "primary"),
        )
    bounds = None if tuning.bounds is None else tuning.bounds.stiffness_ratio
    built = single_absorber(machine)
    if tuning.frequency is None or bounds is None or scale is None or built is None:
        return
    mass = float(built.mass_ratio)  # type: ignore[arg-type]
    ratio = mass * (tuning.frequency / scale.frequency) ** 2
    if not bounds[0] <= ratio <= bounds[1]:
        yield Problem(
            path=("tuning", "frequency"),
            message="the spring tuned to this frequency is outside its bounds",
            found=f"a stiffness ratio of {ratio:.6g}",
            allowed=f"{bounds[0]:.6g} to {bounds[1]:.6g}",
            also=("tuning", "bounds", "stiffness_ratio"),
        )


def _curves(case: Case) -> Iterator[Problem]:
    curves = None if case.response is None else case.response.absorber
    one = case.machine.secondary
    if curves is None or curves.vary is None or one is None:
        return
    if curves.vary.absorber_damping_ratio and 0.0 in (
        getattr(one, key) for key in WAYS["stiffness"]
    ):
        yield Problem(
            path=("response", "absorber", "vary", "absorber_damping_ratio"),
            message="without a spring the absorber has no natural frequency for this ratio",
            allowed="damping_over_primary_critical, which is referred to the primary",
            also=("machine", "secondary"),
        )


# ----------------------------------------------------------------------------
# Can springs, ring, gap and oils of an absorber be built, and is their oil known?
# ----------------------------------------------------------------------------

GAP: KeyPath = ("machine", "gap")


def absorber_part_problems(case: Case) -> list[Problem]:
    """Problems of the parts one by one, then of the ratios that they give together."""
    machine = case.machine
    if machine.primary is None:
        return []
    problems = [*_gap(case), *_oil(case), *_stock_names(case)]
    made = [part for part in ("ring", "springs", "oil") if getattr(machine, part) is not None]
    built = single_absorber(machine) if made and not problems else None
    if built is None:
        return problems
    given: dict[str, tuple[str, Any]] = {
        "ring": ("mass", built.mass_ratio),
        "springs": ("stiffness", built.stiffness_ratio),
        "oil": ("damping", built.secondary_damping),
    }
    for part in made:
        what, value = given[part]
        if float(value) == float(value):
            problems += within((*MACHINE, part), what, float(value))
    return problems


def _gap(case: Case) -> Iterator[Problem]:
    """A clearance by the rule for the radius is below the width, as one that a case gives."""
    gap = case.machine.gap
    if gap is not None and gap.clearance is None and clearance(gap) >= gap.width:
        yield Problem(
            path=GAP,
            message="a gap as wide as the mass is not an oil film: its damping cannot be computed",
            found=f"{clearance(gap):.6g} m, by the rule for its radius",
            allowed=f"< {gap.width:.6g} m, the width of the mass",
            also=(*GAP, "width"),
        )


def _oil(case: Case) -> Iterator[Problem]:
    """The oil that is in is known wherever it is asked for."""
    oil, gap, warming = case.machine.oil, case.machine.gap, case.tuning and case.tuning.temperatures
    if oil is None:
        return
    low, high = known_range(Walther(oil.temperatures, oil.viscosities))
    asked: list[tuple[KeyPath, float]] = []
    if gap is not None and gap.temperature is not None:
        asked.append(((*GAP, "temperature"), gap.temperature))
    if warming:
        path: KeyPath = ("tuning", "temperatures")
        asked += [((*path, "from"), warming.start), ((*path, "to"), warming.stop)]
    for place, value in asked:
        if not low <= value <= high:
            yield Problem(
                path=place,
                message="this temperature is outside the oil's viscosity line (ASTM D341)",
                found=f"{value - ICE:.6g} degC",
                allowed=f"{low - ICE:.4g} to {high - ICE:.4g} degC",
                also=(*MACHINE, "oil", "viscosities"),
            )


def _stock_names(case: Case) -> Iterator[Problem]:
    """Parts in stock and their arrangements have names of their own, by which they are bought."""
    for key, arrangements, rows in (
        ("stock_springs", arranged, "spring_catalogue"),
        ("stock_dampers", side_by_side, ""),
        ("stock_oils", lambda oil: [(oil.name,)], "oil_catalogue"),
    ):
        named: list[tuple[KeyPath, str]] = [
            ((*MACHINE, key, place, "name"), name)
            for place, one in enumerate(getattr(case.machine, key))
            for name, *_ in arrangements(one)
        ]
        catalogue = getattr(case.machine, rows, None)
        for place, part in enumerate(catalogue.part if catalogue else ()):
            named.append(((*MACHINE, rows, "part", place), str(part)))
        first: dict[str, KeyPath] = {}
        for path, name in named:
            if name in first:
                arrangement = " x " in name or " in series of " in name
                yield Problem(
                    path=path,
                    message="two stock parts have the same name",
                    found=repr(name[:60]),
                    allowed="a name for each" + "; arrangements are named '2 x NAME'" * arrangement,
                    also=first[name],
                )
            first.setdefault(name, path)


# ----------------------------------------------------------------------------
# Does a pendulum swing about a stable place, on a path that reaches as far as it is asked?
# ----------------------------------------------------------------------------

PENDULUM: KeyPath = ("machine", "pendulum")


@listing
def pendulum_problems(case: Case) -> Iterator[Problem]:
    """Problems of the path, of the swing and of the angles asked for."""
    given = case.machine.pendulum
    if given is None:
        return
    # these load what solves the motion
    from vibecalc.absorber.pendulum_order import largest_swing, placed

    try:
        pendulum = placed(given)
    except NumericalFailure as failure:
        said = "order" if given.path_radius is None else "path_radius"
        also = "arm_radius" if given.vertex_distance is None else "vertex_distance"
        yield Problem((*PENDULUM, said), str(failure), also=(*PENDULUM, also))
        return
    end, goes_round = float(largest_swing(pendulum)), given.path == "circular"
    if given.swings is not None and given.swings.to >= end:
        yield Problem(
            path=(*PENDULUM, "swings", "to"),
            message="the pendulum goes over the top: its swing is half a turn to each side"
            if goes_round
            else "the swing leaves the path, which ends there in a cusp",
            found=f"{given.swings.to:.6g} rad",
            allowed=f"< {end:.6g} rad",
            hint="angles without a unit are in radians: '20 deg'",
            also=None if goes_round else (*PENDULUM, "path"),
        )
