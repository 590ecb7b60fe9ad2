"""Are the ratios of an absorber those of a machine, and is there something to be tuned?"""

from collections.abc import Iterator
from itertools import chain

from vibecalc.case.absorber_parts import Secondary
from vibecalc.case.raw import listed, nearest
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.absorber import PRIMARY, Scale, primary_damping, primary_scale, ratios

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


def _too_heavy(case: Case, scale: Scale | None) -> Iterator[Problem]:
    """Masses beside which no tuning is found."""
    tuning, machine = case.tuning, case.machine
    if tuning is None:
        return
    pair = tuning.excitation, tuning.response
    most = TUNED_TRANSMITTED if pair == ("base", "transmitted_force") else TUNED
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
                message="beside so heavy an absorber the primary is next to nothing, and no tuning "
                "is found",
                found=f"a mass ratio of {ratio:.6g}",
                allowed=f"<= {most:g} with [tuning]",
                hint="the heavy one is the ground: exchange primary and secondary",
            )


def _ratios(path: KeyPath, one: Secondary, scale: Scale | None) -> Iterator[Problem]:
    # a ring that gives the inertia is looked at with the other parts
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
        if one.name == PRIMARY or one.name in names[:place]:
            known = one.name in names[:place]
            yield Problem(
                path=(*path, "name"),
                message=f"two absorbers are named {one.name[:60]!r}"
                if known
                else f"{PRIMARY!r} is the name of the primary system",
                hint="give each its own name",
                also=(*SECONDARIES, names.index(one.name), "name") if known else None,
            )
        elif one.on != PRIMARY and one.on not in names:
            yield Problem(
                path=(*path, "on"),
                message=f"no absorber is named {one.on[:60]!r}",
                allowed=listed([PRIMARY, *(name for name in names if name != one.name)]),
                hint=nearest(one.on, [PRIMARY, *names]),
            )
    seen: set[str] = set()
    for first in carriers:
        chain_of, name = [first], carriers[first]
        while name in carriers and name not in chain_of and name not in seen:
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
        seen |= set(chain_of)


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
    if tuning.chart is not None:
        chart, path = tuning.chart, ("tuning", "chart")
        for place, ratio in enumerate(chart.primary_damping):
            yield from within((*path, "primary_damping", place), "damping", ratio)
        for key, end in (("from", chart.mass_ratio.start), ("to", chart.mass_ratio.stop)):
            yield from within((*path, "mass_ratio", key), "mass", end)


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
