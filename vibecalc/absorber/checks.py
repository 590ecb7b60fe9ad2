"""Physical checks of absorbers and pendulums: ratios, hardware that can be built, swing."""

from collections.abc import Iterator
from itertools import chain

import numpy as np

from vibecalc.absorber.asked_tables import Tuning
from vibecalc.absorber.hardware.oil_gap import (
    COLDEST,
    HOTTEST,
    THICKEST,
    THINNEST,
    Walther,
    kinematic_viscosity,
)
from vibecalc.absorber.model import (
    PRIMARY,
    Scale,
    arranged,
    clearance,
    primary_damping,
    primary_scale,
    ratios,
    side_by_side,
    single_absorber,
)
from vibecalc.absorber.tables import ICE, Gap, Oil, Secondary
from vibecalc.core.case.raw import listed, nearest
from vibecalc.errors import KeyPath, NumericalFailure, Problem
from vibecalc.numerics.rounding import BoolArray
from vibecalc.schema import Case, Machine

# ----------------------------------------------------------------------------
# Are the ratios of an absorber those of a machine, and is there something to be tuned?
# ----------------------------------------------------------------------------

SECONDARIES: KeyPath = ("machine", "secondaries")
CURVES: KeyPath = ("response", "absorber")
#: Ratios beyond these are limits (locked, free, a second ground) and no parts that are built.
BOUNDS = {"mass": (1e-9, 1e6), "stiffness": (1e-15, 1e9), "damping": (1e-12, 1e6)}
#: mass ratios up to which tunings are found: of one absorber, of one for the force that a moving
#: ground transmits, of each of several
TUNED, TUNED_TRANSMITTED, TUNED_SEVERAL = 1e4, 30.0, 10.0
#: keys of a secondary that say each of them
_KEYS = {
    "mass": ("mass_ratio", "inertia", "mass"),
    "stiffness": ("stiffness_ratio", "stiffness", "linear_stiffness"),
    "damping": ("damping_ratio", "own_damping_ratio", "damping", "linear_damping"),
}
_LOCKED = "limits = true in [response.absorber] draws a secondary that is locked to the primary"
_HINTS = {
    "mass": "with an infinite mass the secondary is a second ground, and nothing is absorbed",
    "stiffness": _LOCKED,
    "damping": _LOCKED,
}
_VARIED = {
    "primary_damping": "damping",
    "mass_ratio": "mass",
    "stiffness_ratio": "stiffness",
    "secondary_damping": "damping",
    "own_damping": "damping",
}


def absorber_problems(case: Case) -> list[Problem]:
    """Problems of the ratios, of what carries what, and of the tuning and the curves asked for."""
    machine = case.machine
    if machine.primary is None:
        return []
    scale = primary_scale(machine)
    damping = primary_damping(machine.primary, scale)
    keys = ("damping", "linear_damping")
    key = next((k for k in keys if getattr(machine.primary, k) is not None), "damping_ratio")
    problems = [*within(("machine", "primary", key), "damping", damping)]
    if machine.secondary is not None:
        problems += _ratios(("machine", "secondary"), machine.secondary, scale)
    for place, one in enumerate(machine.secondaries):
        problems += _ratios((*SECONDARIES, place), one, scale)
    problems += _too_heavy(case, scale)
    return [*problems, *_carried(case), *_tuning(case, damping), *_curves(case)]


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

    Of one absorber by its mass ratio, None else.
    """
    primary, secondary, tuning = case.machine.primary, case.machine.secondary, case.tuning
    if primary is None or secondary is None or tuning is None or tuning.kind != "free":
        return None
    if primary.damping_ratio is None or secondary.mass_ratio is None or tuning.bounds is not None:
        return None
    damping, mass = np.asarray(primary.damping_ratio), np.asarray(secondary.mass_ratio)
    low, high = BOUNDS["damping"]
    fine = (damping == 0.0) | (low <= damping) & (damping <= high)
    return np.asarray(~(fine & (BOUNDS["mass"][0] <= mass) & (mass <= _heaviest(tuning))))


def _heaviest(tuning: Tuning) -> float:
    """The mass ratio up to which a tuning of one absorber is found."""
    pair = tuning.excitation, tuning.response
    return TUNED_TRANSMITTED if pair == ("base", "transmitted_force") else TUNED


def _too_heavy(case: Case, scale: Scale | None) -> Iterator[Problem]:
    """Masses with which no tuning is found."""
    tuning, machine = case.tuning, case.machine
    if tuning is None:
        return
    most = _heaviest(tuning)
    given: list[tuple[KeyPath, float]] = []
    if machine.secondary is not None and any(_given(machine.secondary, "mass")):
        key = _given(machine.secondary, "mass")[0]
        given.append((("machine", "secondary", key), ratios(machine.secondary, scale).mass))
    if tuning.chart is not None:
        given.append((("tuning", "chart", "mass_ratio", "to"), tuning.chart.mass_ratio.stop))
    for place, one in enumerate(machine.secondaries):
        most = TUNED_SEVERAL
        if any(_given(one, "mass")):
            key = _given(one, "mass")[0]
            given.append(((*SECONDARIES, place, key), ratios(one, scale).mass))
    for path, ratio in given:
        if most < ratio <= BOUNDS["mass"][1]:
            yield Problem(
                path=path,
                message="with so heavy an absorber the primary hardly counts, and no tuning "
                "is found",
                found=f"a mass ratio of {ratio:.6g}",
                allowed=f"<= {most:g} with [tuning]",
                hint="the heavy one is the ground: exchange primary and secondary",
            )


def _ratios(path: KeyPath, one: Secondary, scale: Scale | None) -> Iterator[Problem]:
    # a ring that gives the inertia is examined with the other parts
    found = ratios(one, scale, None if any(_given(one, "mass")) else 1.0)
    for what, value in zip(_KEYS, found, strict=True):
        for key in _given(one, what)[:1]:
            if value is not None:
                yield from within((*path, key), what, value)


def _given(one: Secondary, what: str) -> list[str]:
    return [key for key in _KEYS[what] if getattr(one, key) is not None]


def _carried(case: Case) -> Iterator[Problem]:
    """Each of several absorbers hangs, at the end, on the primary."""
    given = case.machine.secondaries
    names = [one.name for one in given]
    carriers = {one.name: one.on for one in given if one.name != PRIMARY}
    for place, one in enumerate(given):
        path: KeyPath = (*SECONDARIES, place)
        if one.name == PRIMARY:
            yield Problem(
                path=(*path, "name"),
                message=f"{PRIMARY!r} is the name of the primary system",
                hint="give each its own name",
            )
        elif one.on != PRIMARY and one.on not in names:
            yield Problem(
                path=(*path, "on"),
                message=f"no absorber is named {one.on[:60]!r}",
                allowed=listed([PRIMARY, *(name for name in names if name != one.name)]),
                hint=nearest(one.on, [PRIMARY, *names]),
            )
    checked: set[str] = set()
    for first in carriers:
        chain_of, name = [first], carriers[first]
        while name in carriers and name not in chain_of and name not in checked:
            chain_of.append(name)
            name = carriers[name]
        if name in chain_of:
            ring = chain_of[chain_of.index(name) :]
            yield Problem(
                path=(*SECONDARIES, names.index(ring[0]), "on"),
                message="these absorbers carry each other, and nothing carries them"
                if len(ring) > 1
                else "an absorber cannot carry itself",
                found=" on ".join(map(repr, [*ring, ring[0]])),
                allowed=f"one of them on = {PRIMARY!r}",
            )
        checked |= set(chain_of)


def _tuning(case: Case, damping: float) -> Iterator[Problem]:
    tuning = case.tuning
    if tuning is None:
        return
    charted = () if tuning.chart is None else tuning.chart.primary_damping
    if tuning.kind == "undamped_spring" and 0.0 in (damping, *charted):
        in_chart = damping > 0.0
        yield Problem(
            path=("tuning", "chart", "primary_damping") if in_chart else ("tuning", "kind"),
            message="there is no optimum: without any damping the response has infinite peaks "
            "with every spring",
            found="kind = 'undamped_spring' and an undamped primary",
            allowed="a primary with damping, or another kind",
            hint="the spring that stills one frequency has K2 / J2 = w^2",
            also=("tuning", "kind") if in_chart else ("machine", "primary"),
        )
    if tuning.bounds is not None:
        for key, what in (("stiffness_ratio", "stiffness"), ("damping_ratio", "damping")):
            for end in getattr(tuning.bounds, key) or ():
                yield from within(("tuning", "bounds", key), what, end)
        yield from _given_frequency(case)
    if tuning.chart is not None:
        chart, path = tuning.chart, ("tuning", "chart")
        for place, ratio in enumerate(chart.primary_damping):
            yield from within((*path, "primary_damping", place), "damping", ratio)
        for key, end in (("from", chart.mass_ratio.start), ("to", chart.mass_ratio.stop)):
            yield from within((*path, "mass_ratio", key), "mass", end)


def _given_frequency(case: Case) -> Iterator[Problem]:
    """A spring that lets the absorber swing at the frequency given keeps its bounds."""
    tuning, scale = case.tuning, primary_scale(case.machine)
    if tuning is None or tuning.frequency is None or tuning.bounds is None or scale is None:
        return
    bounds, built = tuning.bounds.stiffness_ratio, single_absorber(case.machine)
    if bounds is None or built is None:
        return
    mass = float(built.mass_ratio)  # type: ignore[arg-type]
    ratio = mass * (tuning.frequency / scale.frequency) ** 2
    if not bounds[0] <= ratio <= bounds[1]:
        yield Problem(
            path=("tuning", "frequency"),
            message="the spring that swings at this frequency is not within its bounds",
            found=f"a stiffness ratio of {ratio:.6g}",
            allowed=f"{bounds[0]:.6g} to {bounds[1]:.6g}",
            also=("tuning", "bounds", "stiffness_ratio"),
        )


def _curves(case: Case) -> Iterator[Problem]:
    curves = None if case.response is None else case.response.absorber
    if curves is None:
        return
    if curves.vary is not None:
        for key, what in _VARIED.items():
            for place, value in enumerate(getattr(curves.vary, key)):
                yield from within((*CURVES, "vary", key, place), what, value)
        loose = case.machine.secondary is not None and 0.0 in chain.from_iterable(
            [[getattr(case.machine.secondary, key)] for key in _KEYS["stiffness"]]
        )
        if curves.vary.own_damping and loose:
            yield Problem(
                path=(*CURVES, "vary", "own_damping"),
                message="without a spring the absorber has no frequency of its own for this ratio",
                allowed="secondary_damping, which is referred to the primary",
                also=("machine", "secondary"),
            )


# ----------------------------------------------------------------------------
# Can rod, springs, ring, gap and oils of an absorber be built, and is their oil known?
# ----------------------------------------------------------------------------

MACHINE: KeyPath = ("machine",)
GAP: KeyPath = ("machine", "gap")
WARMING: KeyPath = ("tuning", "temperatures")
#: K: below this a number without a unit was meant in degrees Celsius
_MEANT_CELSIUS = 200.0
_IN_KELVIN = "temperatures without a unit are in K: '60 degC'"


def absorber_part_problems(case: Case) -> list[Problem]:
    """Problems of the parts one by one, then of the ratios that they give together."""
    machine = case.machine
    if machine.primary is None:
        return []
    problems = [*_wheel(case), *_oils(case), *_stock_names(machine)]
    if machine.gap is not None:
        problems += _gap(machine.gap)
    if problems:
        return problems
    if machine.ring is None and machine.springs is None and machine.oil is None:
        return []
    built = single_absorber(machine)
    if built is None:
        return []
    for what, value, part in (
        ("mass", built.mass_ratio, "ring"),
        ("stiffness", built.stiffness_ratio, "springs"),
        ("damping", built.secondary_damping, "oil"),
    ):
        number = float(value)  # type: ignore[arg-type]
        if getattr(machine, part) is not None and number == number:
            problems += within((*MACHINE, part), what, number)
    return problems


def _stock_names(machine: Machine) -> Iterator[Problem]:
    """Parts in stock and their arrangements have names of their own, by which they are bought."""
    springs = [
        ((*MACHINE, "stock_springs", place, "name"), name)
        for place, one in enumerate(machine.stock_springs)
        for name, *_ in arranged(one)
    ]
    dampers = [
        ((*MACHINE, "stock_dampers", place, "name"), name)
        for place, one in enumerate(machine.stock_dampers)
        for name, _ in side_by_side(one)
    ]
    oils = [
        ((*MACHINE, "stock_oils", place, "name"), one.name)
        for place, one in enumerate(machine.stock_oils)
    ]
    for rows, key in ((springs, "spring_catalogue"), (oils, "oil_catalogue"), (dampers, "")):
        table = getattr(machine, key) if key else None
        bought = () if table is None else enumerate(table.part)
        all_of_them = [*rows, *(((*MACHINE, key, "part", n), str(name)) for n, name in bought)]
        first: dict[str, KeyPath] = {}
        for path, name in all_of_them:
            if name in first:
                yield Problem(
                    path=path,
                    message="two parts in stock have one name, and none says which is meant",
                    found=repr(name[:60]),
                    allowed="a name for each; arrangements are named '2 x NAME'"
                    if " x " in name or " in series of " in name
                    else "a name for each",
                    also=first[name],
                )
            first.setdefault(name, path)


def _wheel(case: Case) -> Iterator[Problem]:
    wheel = case.machine.flywheel
    if wheel is not None and wheel.polar_inertia > 2.0 * wheel.diametral_inertia * (1.0 + 1e-6):
        yield Problem(
            path=(*MACHINE, "flywheel", "polar_inertia"),
            message="no body has this polar inertia: it is at most twice the diametral one",
            found=f"{wheel.polar_inertia:.6g} kg*m^2",
            allowed=f"<= {2.0 * wheel.diametral_inertia:.6g} kg*m^2",
            also=(*MACHINE, "flywheel", "diametral_inertia") if wheel.diametral_inertia else None,
        )


def _gap(gap: Gap) -> Iterator[Problem]:
    films = {"clearance": clearance(gap)}
    films |= {
        key: value
        for key in ("side_clearance", "bore_clearance")
        if (value := getattr(gap, key)) is not None
    }
    for key, wide in films.items():
        by_rule = key == "clearance" and gap.clearance is None
        if wide >= gap.width:
            yield Problem(
                path=GAP if by_rule else (*GAP, key),
                message="a gap as wide as the mass is no film: its damping cannot be determined",
                found=f"{wide:.6g} m" + (", by the rule for its radius" if by_rule else ""),
                allowed=f"< {gap.width:.6g} m, the width of the mass",
                also=(*GAP, "width"),
            )
        elif key == "bore_clearance" and wide >= gap.inner_radius:
            yield Problem(
                path=(*GAP, key),
                message="the gap in the bore is as wide as the bore itself",
                found=f"{wide:.6g} m",
                allowed=f"< {gap.inner_radius:.6g} m",
                also=(*GAP, "inner_radius"),
            )


def _oils(case: Case) -> Iterator[Problem]:
    machine = case.machine
    asked: list[tuple[KeyPath, float]] = []
    if machine.gap is not None and machine.gap.temperature is not None:
        asked.append(((*GAP, "temperature"), machine.gap.temperature))
    warming = None if case.tuning is None else case.tuning.temperatures
    if warming is not None:
        ends = (("from", warming.start), ("to", warming.stop))
        asked += [((*WARMING, key), value) for key, value in ends]
    reported = [problem for path, value in asked for problem in _on_the_chart(path, value)]
    yield from reported
    for place, one in enumerate(machine.stock_oils):
        yield from _line((*MACHINE, "stock_oils", place), one.temperatures, one.viscosities)
    rows = machine.oil_catalogue
    if rows is not None:
        both = zip(rows.viscosity_40, rows.viscosity_100, strict=True)
        for place, (thick, thin) in enumerate(both):
            points = (ICE + 40.0, ICE + 100.0), (thick, thin)
            yield from _line((*MACHINE, "oil_catalogue"), *points, keys=("viscosity_100", place))
    if machine.oil is not None:
        wrong = [*_line((*MACHINE, "oil"), machine.oil.temperatures, machine.oil.viscosities)]
        yield from wrong or (() if reported else _known(machine.oil, asked))


def _on_the_chart(path: KeyPath, value: float) -> Iterator[Problem]:
    if not COLDEST <= value <= HOTTEST:
        yield Problem(
            path=path,
            message="the temperature is outside the model of viscosity (ASTM D341)",
            found=f"{value:.6g} K, {_celsius(value)}",
            allowed=f"{_celsius(COLDEST)} to {_celsius(HOTTEST)}",
            hint=_IN_KELVIN if value < _MEANT_CELSIUS else "",
        )


def _line(
    path: KeyPath,
    temperatures: tuple[float, float],
    viscosities: tuple[float, float],
    keys: tuple[str | int, ...] = ("viscosities",),
) -> Iterator[Problem]:
    """Two points make the line of an oil that grows thinner with heat."""
    reported = False
    for place, value in enumerate(temperatures):
        for problem in _on_the_chart((*path, "temperatures", place), value):
            reported = True
            yield problem
    for place, value in enumerate(viscosities):
        if not THINNEST <= value <= THICKEST:
            reported = True
            yield Problem(
                path=(*path, keys[0], place) if len(keys) == 1 else (*path, *keys),
                message="the viscosity is outside the model (ASTM D341)",
                found=f"{1e6 * value:.6g} mm^2/s",
                allowed=f"{1e6 * THINNEST:.0f} to {1e6 * THICKEST:.0e} mm^2/s",
                hint="viscosities without a unit are in m^2/s: '86 cSt'" if value > 1.0 else "",
            )
    if reported:
        return
    cooling = (temperatures[1] - temperatures[0]) * (viscosities[0] - viscosities[1])
    if cooling <= 0.0:
        yield Problem(
            path=(*path, *keys),
            message="no oil has these two points: it is thinner at the higher temperature",
            found=" and ".join(
                f"{1e6 * thick:.6g} mm^2/s at {_celsius(warm)}"
                for warm, thick in zip(temperatures, viscosities, strict=True)
            ),
            allowed="two temperatures, and less viscosity at the higher one",
        )


def _known(oil: Oil, asked: list[tuple[KeyPath, float]]) -> Iterator[Problem]:
    line = Walther(oil.temperatures, oil.viscosities)
    for path, value in asked:
        try:
            kinematic_viscosity(line, value)
        except NumericalFailure as failure:
            yield Problem(
                path=path,
                message=f"the oil of the case is not known there: {failure}",
                found=_celsius(value),
                allowed="temperatures at which the line of the oil stays within the model",
                also=(*MACHINE, "oil", "viscosities"),
            )


def _celsius(value: float) -> str:
    return f"{value - ICE:.6g} degC"


# ----------------------------------------------------------------------------
# Does a pendulum swing about a stable place, on a path that reaches as far as it is asked?
# ----------------------------------------------------------------------------

PENDULUM: KeyPath = ("machine", "pendulum")


def pendulum_problems(case: Case) -> list[Problem]:
    """Problems of the path, of the swing and of the angles asked for."""
    given = case.machine.pendulum
    if given is None:
        return []
    # these load what solves the motion
    from vibecalc.absorber.pendulum_order import largest_swing, placed

    try:
        pendulum = placed(given)
    except NumericalFailure as failure:
        reported = "path_radius" if given.path_radius is not None else "order"
        also = "vertex_distance" if given.vertex_distance is not None else "arm_radius"
        return [Problem(path=(*PENDULUM, reported), message=str(failure),
                                   also=(*PENDULUM, also))]  # fmt: skip
    end = float(largest_swing(pendulum))
    if given.swings is not None and given.swings.to >= end:
        return [
            Problem(
                path=(*PENDULUM, "swings", "to"),
                message="the swing leaves the path, which ends there in a cusp"
                if given.path != "circular"
                else "the swing goes round: it is half a turn to each side",
                found=f"{given.swings.to:.6g} rad",
                allowed=f"< {end:.6g} rad",
                hint="angles without a unit are in radians: '20 deg'",
                also=(*PENDULUM, "path") if given.path != "circular" else None,
            )
        ]
    return []
