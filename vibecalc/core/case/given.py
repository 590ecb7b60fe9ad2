"""What a script hands in for values of a case, as TOML has them.

Numbers with a unit, of pint, xarray and pandas (in `attrs`) and vibecalc itself, become texts with
that unit, which the schema then reads and refuses like any other; arrays become lists.
"""

import math
import os
from collections.abc import Mapping
from typing import Any

from vibecalc.errors import CaseError, KeyPath, Problem, UnitError, UsageError, dotted
from vibecalc.units import read_unit

#: pint's names of what its registries measure by -> factor and the name here
_ROOTS = {"gram": (1e-3, "kilogram")}
_TURN = 2.0 * math.pi
_CLOSE = 1e-12
#: what TOML has for a single value
_PLAIN = (bool, int, float, str)


def plain(value: Any, path: KeyPath = (), *, of_toml: bool = False) -> Any:
    """A value in the types of TOML; what is neither of them nor a number of another library is left
    for the schema to refuse, or refused here where all has to be `of_toml`.

    CaseError with every key whose value has no such form.
    """
    problems: list[Problem] = []
    made = _made(value, path, of_toml, problems)
    if problems:
        said = (
            f"error: {one.message}\n  found {one.found}"
            + (f"; allowed: {one.allowed}" if one.allowed else "")
            for one in problems
        )
        raise CaseError(problems, "\n".join(said))
    return made


def _made(value: Any, path: KeyPath, of_toml: bool, problems: list[Problem]) -> Any:
    """As `plain`; adds to `problems`."""
    if isinstance(value, Mapping):
        rows = {str(key): one for key, one in value.items()}
        return {key: _made(one, (*path, key), of_toml, problems) for key, one in rows.items()}
    if isinstance(value, list | tuple):
        return [_made(one, (*path, n), of_toml, problems) for n, one in enumerate(value)]
    made, why = value, ""
    try:
        if isinstance(value, os.PathLike):
            made = os.fspath(value)
        elif value is not None and type(value) not in _PLAIN:
            made = _measured(value)
    except UsageError as error:
        why = str(error)
    if why or (of_toml and not _is_toml(made)):
        problems.append(_problem(value, path, why))
    return made


def _is_toml(value: Any) -> bool:
    import datetime

    if isinstance(value, list):
        return all(map(_is_toml, value))
    return isinstance(value, (*_PLAIN, datetime.date, datetime.time))


def _problem(value: Any, path: KeyPath, why: str) -> Problem:
    from vibecalc.core.case.walk import shape_at, words

    shape = shape_at(path) if path else None
    kind = "none" if value is None else f"of the type {type(value).__name__}"
    message = f"{dotted(path) or 'the value'} cannot be {kind}{f' ({why})' if why else ''}"
    return Problem(path, message, repr(value)[:60], words(shape) if shape else "")


# ----------------------------------------------------------------------------
# Numbers with units.
# ----------------------------------------------------------------------------


def _measured(value: Any) -> Any:
    """A number or array with its unit, or as it is."""
    if hasattr(value, "to_root_units"):  # pint, of whichever registry
        return _of_pint(value)
    inside = getattr(value, "data", None)
    if hasattr(inside, "to_root_units"):  # xarray around pint
        return _of_pint(inside)
    if not hasattr(value, "__array__"):
        return value  # the schema says what it may be
    import numpy as np

    from vibecalc.core.results.record import Quantity

    attributes = getattr(value, "attrs", None)
    unit = getattr(value, "units", None) or getattr(value, "unit", None)
    if isinstance(attributes, Mapping):
        unit = attributes.get("units") or attributes.get("unit")
    elif unit is not None and not isinstance(value, Quantity):
        library = type(value).__module__.partition(".")[0]
        raise UsageError(f'a unit of {library}: write it as a text, as "3000 rpm"')
    numbers = np.asarray(value)
    if numbers.dtype.kind == "c":
        raise UsageError("complex numbers")
    listed = numbers.tolist()
    return listed if unit is None else _with_unit(listed, str(unit).strip())


def _with_unit(numbers: Any, unit: str, factor: float = 1.0) -> Any:
    if isinstance(numbers, list):
        return [_with_unit(one, unit, factor) for one in numbers]
    if not isinstance(numbers, int | float):
        return numbers
    scaled = numbers if factor == 1.0 else numbers * factor
    return scaled if unit in ("", "1", "dimensionless", "None") else f"{scaled!r} {unit}"


def _of_pint(quantity: Any) -> Any:
    """The texts of a quantity: in its unit if that means the same here, else in base units."""
    numbers, given = _listed(quantity.magnitude), dict(quantity.unit_items())
    names = "*".join(f"{name}^{power:g}" for name, power in given.items())
    if not given:
        return numbers
    if set(given) == {"decibel"}:
        return _with_unit(numbers, "dB")
    if any("degree_" in name for name in given):  # a scale with a zero of its own
        return _with_unit(_listed(quantity.to_root_units().magnitude), "K")
    factor, powers = _of_root(type(quantity)(1.0, quantity.units).to_root_units(), given)
    for unit in (f"{quantity.units:~C}", names):
        try:
            here, dimension = read_unit(unit)
        except UnitError:
            continue
        if dimension == powers and abs(here - factor) <= _CLOSE * abs(factor):
            return _with_unit(numbers, unit)
    return _with_unit(
        numbers, "*".join(f"{name}^{power:g}" for name, power in powers.items()), factor
    )


def _listed(magnitude: Any) -> Any:
    return magnitude.tolist() if hasattr(magnitude, "tolist") else magnitude


def _of_root(root: Any, given: Mapping[str, float]) -> tuple[float, dict[str, float]]:
    """Factor and powers of a unit in SI base units; a hertz is a turn per second."""
    factor, powers = float(root.magnitude), dict[str, float]()
    for name, power in root.unit_items():
        size, here = _ROOTS.get(str(name), (1.0, str(name)))
        factor *= size**power
        powers[here] = float(power)
    turns = sum(power for name, power in given.items() if str(name).endswith("hertz"))
    if turns:
        factor *= _TURN**turns
        powers["radian"] = powers.get("radian", 0.0) + float(turns)
    return factor, {name: power for name, power in powers.items() if power}
