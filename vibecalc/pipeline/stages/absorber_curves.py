"""The absorbers whose curves a case asks for: the one given or tuned, its limits, a family."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.absorber_tables import AbsorberResponse, Vary
from vibecalc.case.schema import Case
from vibecalc.errors import NumericalFailure
from vibecalc.machine.absorber import AbsorberParts
from vibecalc.response.absorber.model import Absorber, damping_from_own_ratio

#: key of [response.absorber.vary] -> words in the name of a curve
WORDS = {
    "primary_damping": "primary damping",
    "mass_ratio": "mass ratio",
    "stiffness_ratio": "stiffness ratio",
    "secondary_damping": "damping",
    "own_damping": "own damping",
}


class Curves(NamedTuple):
    """Names (n,) and ratios (n,) of each; the first is the absorber given or tuned."""

    names: tuple[str, ...]
    absorber: Absorber


def family(
    case: Case, options: AbsorberResponse, parts: AbsorberParts, tuned: Absorber | None
) -> Curves:
    """The curves that a case asks for, in the order in which they are listed there."""
    own, first = parts.absorber, "as given"
    if tuned is not None:
        own, first = tuned, "tuned"
    elif own is None or not parts.is_complete:
        raise NumericalFailure("the absorber has no spring or no damper, and no tuning finds it")
    z1, m, k, z2 = (float(np.asarray(part)) for part in own)
    rows = [(first, (z1, m, k, z2))]
    if options.limits:
        rows += [("locked", (z1, m, np.inf, z2)), ("free", (z1, m, 0.0, 0.0))]
    secondary = case.machine.secondary
    ratio = None if secondary is None else secondary.own_damping_ratio
    if options.vary is not None:
        rows += _varied(options.vary, (z1, m, k, z2), ratio)
    columns = np.array([row for _, row in rows], dtype=float).T
    return Curves(tuple(name for name, _ in rows), Absorber(*columns))


def varied_key(vary: Vary) -> str:
    """The ratio that varies."""
    return next(key for key in WORDS if getattr(vary, key))


def _varied(
    vary: Vary, own: tuple[float, float, float, float], ratio: float | None
) -> list[tuple[str, tuple[float, float, float, float]]]:
    key = varied_key(vary)
    place = ("primary_damping", "mass_ratio", "stiffness_ratio", "secondary_damping")
    rows = []
    for value in getattr(vary, key):
        each = dict(zip(place, own, strict=True))
        if key == "own_damping":
            ratio = value
        else:
            each[key] = value
        # a damper given on the absorber's own frequency follows its spring and its mass
        if ratio is not None and key != "secondary_damping":
            m, k = each["mass_ratio"], each["stiffness_ratio"]
            each["secondary_damping"] = float(damping_from_own_ratio(ratio, m, k))
        rows.append((f"{WORDS[key]} {value:g}", tuple(each[name] for name in place)))
    return rows  # type: ignore[return-value]
