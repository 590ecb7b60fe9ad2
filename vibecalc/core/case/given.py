"""What a script hands in for values of a case, as TOML has them.

Numbers with a unit, of pint, xarray and pandas (in `attrs`) and vibecalc itself, become texts with
that unit, which the schema then reads and refuses like any other; arrays become lists.
"""

import math
import os
from collections.abc import Mapping
from typing import Any

from vibecalc.errors import CaseError, KeyPath, Problem, UnitError, UsageError
from vibecalc.units import read_unit

#: pint's names of what its registries measure by -> factor and the name here
_ROOTS = {"gram": (1e-3, "kilogram")}
_TURN = 2.0 * math.pi
_CLOSE = 1e-12
#: what TOML has for a single value
_PLAIN = (bool, int, float, str)


def plain(value: Any, path: KeyPath = ()) -> Any:
    """A value in the types of TOML; CaseError for one that has no such form, with its key."""
    if isinstance(value, Mapping):
        return {str(key): plain(one, (*path, str(key))) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one, (*path, place)) for place, one in enumerate(value)]
    if value is None or type(value) in _PLAIN:
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    try:
        return _measured(value)
    except (UnitError, UsageError) as error:
        raise _refused(value, path, str(error)) from None


def table(value: Mapping[str, Any]) -> dict[str, Any]:
    """A case given as its tables; CaseError with all keys whose values no case can hold."""
    problems: list[Problem] = []
    made = _tables(value, (), problems)
    if problems:
        raise CaseError(problems, "\n".join(_said(one) for one in problems))
    found: dict[str, Any] = made
    return found


def _tables(value: Any, path: KeyPath, problems: list[Problem]) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _tables(one, (*path, str(key)), problems) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_tables(one, (*path, place), problems) for place, one in enumerate(value)]
    try:
        made = plain(value, path)
        if made is None or not _is_toml(made):
            raise _refused(value, path, "")
    except CaseError as error:
        problems += error.problems
        return None
    return made


def _is_toml(value: Any) -> bool:
    import datetime

    if isinstance(value, list):
        return all(map(_is_toml, value))
    return isinstance(value, (*_PLAIN, datetime.date, datetime.time))


def _refused(value: Any, path: KeyPath, why: str) -> CaseError:
    from vibecalc.core.case.raw import key_text
    from vibecalc.core.case.walk import shape_at, words

    shape = shape_at(path) if path else None
    name = key_text(path) or "the value"
    kind = "none" if value is None else f"of the type {type(value).__name__}"
    message = f"{name} cannot be {kind}{f' ({why})' if why else ''}"
    found = repr(value)[:60]
    problem = Problem(
        path=path, message=message, found=found, allowed=words(shape) if shape else "", hint=""
    )
    return CaseError([problem], _said(problem))


def _said(problem: Problem) -> str:
    allowed = f"; allowed: {problem.allowed}" if problem.allowed else ""
    return f"error: {problem.message}\n  found {problem.found}{allowed}"


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


def _with_unit(numbers: Any, unit: str) -> Any:
    if isinstance(numbers, list):
        return [_with_unit(one, unit) for one in numbers]
    if unit in ("", "1", "dimensionless", "None") or not isinstance(numbers, int | float):
        return numbers
    return f"{numbers!r} {unit}"


def _of_pint(quantity: Any) -> Any:
    """The texts of a quantity: in its unit if that means the same here, else in base units."""
    numbers = getattr(quantity.magnitude, "tolist", lambda: quantity.magnitude)()
    given = dict(quantity.unit_items())
    names = "*".join(f"{name}^{power:g}" for name, power in given.items())
    if not given:
        return numbers
    if set(given) == {"decibel"}:
        return _with_unit(numbers, "dB")
    if any("degree_" in name for name in given):  # a scale with a zero of its own
        base = quantity.to_root_units()
        return _with_unit(getattr(base.magnitude, "tolist", lambda: base.magnitude)(), "K")
    factor, powers = _of_root(type(quantity)(1.0, quantity.units).to_root_units(), given)
    for unit in (f"{quantity.units:~C}", names):
        try:
            here, dimension = read_unit(unit)
        except UnitError:
            continue
        if dimension == powers and abs(here - factor) <= _CLOSE * abs(factor):
            return _with_unit(numbers, unit)
    base = "*".join(f"{name}^{power:g}" for name, power in powers.items())
    return _scaled(numbers, factor, base)


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


def _scaled(numbers: Any, factor: float, unit: str) -> Any:
    if isinstance(numbers, list):
        return [_scaled(one, factor, unit) for one in numbers]
    return _with_unit(numbers * factor, unit)
