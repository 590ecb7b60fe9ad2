"""Checks of form of [tuning] and [response.absorber]."""

from collections.abc import Iterator

from vibecalc.case.raw import Data, either, misspelt, read_number, table_at
from vibecalc.errors import KeyPath, Problem

TUNING: KeyPath = ("tuning",)
RESPONSE: KeyPath = ("response", "absorber")
#: restricted kind of tuning -> what it holds, the bound that it then makes idle
_HELD = {
    "viscous": ("the spring is none", "stiffness_ratio"),
    "undamped_spring": ("the damper is none", "damping_ratio"),
}
#: keys of [tuning] that several absorbers do not have
_OF_ONE = ("compare", "temperatures", "chart")
#: closed forms that make no mean square small
_OF_AMPLITUDES = ("den_hartog", "nishihara_asami")
_OILS = ("oil", "stock_oils", "oil_catalogue")
_VARIED = ("primary_damping", "mass_ratio", "stiffness_ratio", "secondary_damping", "own_damping")


def check_tuning(data: Data, machine: Data) -> Iterator[Problem]:
    """Yield what contradicts itself in [tuning], and what it lacks."""
    tuning = data["tuning"]
    kind = tuning.get("kind", "free")
    held, idle = _HELD.get(kind, ("", "")) if isinstance(kind, str) else ("", "")
    bounds = table_at(tuning, "bounds")
    if idle in bounds:
        yield Problem(
            path=(*TUNING, "bounds", idle),
            message=f"of kind {kind!r} {held}, and a bound holds nothing",
            allowed=f"no {idle} in the bounds, or kind = 'free'",
            also=(*TUNING, "kind"),
        )
    if kind == "lanchester" and bounds:
        yield Problem(
            path=(*TUNING, "bounds"),
            message="Lanchester's damper is that of a formula, which knows no bounds",
            allowed="kind = 'viscous', whose damper is found within them",
            also=(*TUNING, "kind"),
        )
    for key in ("stiffness_ratio", "damping_ratio"):
        ends = bounds.get(key)
        if isinstance(ends, list) and len(ends) == 2:
            yield from _ordered((*TUNING, "bounds", key), ends[0], ends[1], "", "<=")
    yield from _methods(tuning)
    yield from _kinds(tuning, kind)
    yield from _ranges(tuning)
    if "temperatures" in tuning and not any(part in machine for part in _OILS):
        yield Problem(
            path=(*TUNING, "temperatures"),
            message="what warms is an oil, and there is none",
            allowed="[machine.gap] with [machine.oil] or oils in stock",
        )
    if "secondaries" in machine:
        yield from _several(tuning, kind)


def check_curves(data: Data, machine: Data, motion: str) -> Iterator[Problem]:
    """Yield what contradicts itself in [response.absorber]."""
    asked = table_at(data, *RESPONSE)
    yield from either(asked, RESPONSE, "frequency_ratios", ("frequencies",), needed=False)
    if "frequencies" in asked and not motion and isinstance(machine.get("primary"), dict):
        yield Problem(
            path=(*RESPONSE, "frequencies"),
            message="the primary is of ratios alone and has no frequency in Hz",
            allowed="frequency_ratios, or a primary with inertia and stiffness",
            also=("machine", "primary"),
        )
    for key, unit in (("frequency_ratios", ""), ("frequencies", "rad/s")):
        table = table_at(asked, key)
        yield from _ordered((*RESPONSE, key, "from"), table.get("from", 0), table.get("to"), unit)
    vary = asked.get("vary")
    if not isinstance(vary, dict):
        return
    given = [key for key in _VARIED if vary.get(key)]
    if len(given) != 1 and not misspelt(vary, (*RESPONSE, "vary"), *_VARIED):
        yield Problem(
            path=(*RESPONSE, "vary", *given[1:2]),
            message=f"{' and '.join(given)} cannot vary together"
            if given
            else "nothing varies in [response.absorber.vary]",
            allowed=f"one of {', '.join(_VARIED)}, with its values",
        )
    elif given and "secondaries" in machine and given != ["primary_damping"]:
        yield Problem(
            path=(*RESPONSE, "vary", given[0]),
            message=f"{given[0]} of which absorber? There are several",
            allowed="primary_damping, or a sweep over keys of the secondaries",
            also=("machine", "secondaries"),
        )


def _kinds(tuning: Data, kind: object) -> Iterator[Problem]:
    """A mean square is tuned freely; Lanchester's damper is for one response."""
    if tuning.get("norm") == "h2":
        for key, wrong in (("kind", kind != "free"), ("bounds", bool(tuning.get("bounds")))):
            if wrong:
                yield Problem(
                    path=(*TUNING, key),
                    message=f"a mean square is tuned with spring and damper both free, without "
                    f"{key}",
                    allowed=f"no {key}, or norm = 'h_infinity'",
                    also=(*TUNING, "norm"),
                )
    elif kind == "lanchester":
        for key, own in (("excitation", "force"), ("response", "displacement")):
            if tuning.get(key, own) != own:
                yield Problem(
                    path=(*TUNING, key),
                    message="Lanchester's damper is tuned for a force and the displacement",
                    found=f"{key} = {str(tuning[key])[:40]!r}",
                    allowed="kind = 'viscous', which is tuned for any of them",
                    also=(*TUNING, "kind"),
                )


def _methods(tuning: Data) -> Iterator[Problem]:
    compared = tuning.get("compare")
    others = [one for one in compared if isinstance(one, str)] if isinstance(compared, list) else []
    for place, name in enumerate(others):
        path: KeyPath = (*TUNING, "compare", place)
        if name in others[:place]:
            yield Problem(
                path=path,
                message=f"method {name!r} stands twice",
                allowed="each method once",
                also=(*TUNING, "compare", others.index(name)),
            )
        elif name in _OF_AMPLITUDES and tuning.get("norm") == "h2":
            yield Problem(
                path=path,
                message=f"the closed form {name!r} is for the largest amplitude",
                found="norm = 'h2'",
                allowed="norm = 'h_infinity', or 'warburton' beside 'h2'",
                also=(*TUNING, "norm"),
            )


def _ranges(tuning: Data) -> Iterator[Problem]:
    chart = table_at(tuning, "chart", "mass_ratio")
    yield from _ordered(
        (*TUNING, "chart", "mass_ratio", "from"), chart.get("from"), chart.get("to"), ""
    )


def _several(tuning: Data, kind: object) -> Iterator[Problem]:
    wrong = [key for key in _OF_ONE if key in tuning]
    if tuning.get("norm", "h_infinity") != "h_infinity":
        wrong.append("norm")
    if kind != "free":
        wrong.append("kind")
    if tuning.get("sensitivity") is True:
        wrong.append("sensitivity")
    for key in wrong:
        yield Problem(
            path=(*TUNING, key),
            message=f"several absorbers are tuned for the largest amplitude, without {key}",
            allowed="excitation, response, bounds, mistuning",
            hint="one absorber in [machine.secondary] has it",
            also=("machine", "secondaries"),
        )


def _ordered(
    path: KeyPath, first: object, last: object, unit: str, sign: str = "<"
) -> Iterator[Problem]:
    low, high = read_number(first, unit), read_number(last, unit)
    if low is None or high is None or low < high or (sign == "<=" and low == high):
        return
    yield Problem(
        path=path,
        message=f"{path[-2] if path[-1] == 'from' else path[-1]} goes from a lower number to a "
        "higher one",
        found=f"from {first} to {last}",
        allowed=f"from {sign} to",
    )
