"""The form of TORS, the JSON that openTorsion reads: its elements, their numbers, what is wrong."""

import json
import math
from collections.abc import Iterator
from typing import Any

from vibecalc.core.case.raw import nearest
from vibecalc.core.results.visible import fits_a_line

# ----------------------------------------------------------------------------
# The form of a file: elements with their numbers, all that is wrong with them at once.
# ----------------------------------------------------------------------------

LARGEST_FILE = 5_000_000
MOST_PROBLEMS, LARGEST_NUMBER = 8, 1e30
#: of the steel of a ShaftContinuous in openTorsion
SHEAR_MODULUS, DENSITY = 80e9, 8000.0

#: type of an element -> its numbers, smallest value, whether it may be that, what is assumed
NUMBERS: dict[str, dict[str, tuple[float, bool, float | None]]] = {
    "Disk": {"inertia": (0.0, True, None), "damping": (0.0, True, 0.0)},
    "ShaftDiscrete": {"stiffness": (0.0, True, None), "damping": (0.0, True, 0.0)},
    "ShaftContinuous": {
        "length": (0.0, False, None),
        "outerDiameter": (0.0, False, None),
        "innerDiameter": (0.0, True, 0.0),
        "density": (0.0, True, DENSITY),
        "damping": (0.0, True, 0.0),
    },
    "GearElement": {
        "inertia": (0.0, True, 0.0),
        "diameter": (-math.inf, False, None),
        "teeth": (-math.inf, False, None),
        "damping": (0.0, True, 0.0),
    },
}
OTHERS = ("name", "type", "parent", "excitation")
_WANTED = "'components', each with its 'elements', and 'structure', as openTorsion reads them"


class NoAssembly(Exception):
    """What is wrong with a file, a line for each problem."""


def parsed(text: str) -> dict[str, Any]:
    """The file as JSON reads it, with components. Raises NoAssembly."""

    def unrepeated(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        keys = [key for key, _ in pairs]
        twice = next((key for key in keys if keys.count(key) > 1), None)
        if twice is not None:
            raise NoAssembly(f"an object of the file has the key {twice[:40]!r} twice")
        return dict(pairs)

    try:
        data = json.loads(text, object_pairs_hook=unrepeated)
    except json.JSONDecodeError as error:
        line = text.splitlines()[error.lineno - 1].strip()[:60] if text.strip() else ""
        raise NoAssembly(
            f"line {error.lineno}, column {error.colno} is no JSON: {line!r}"
            if line
            else "the file is no JSON, it ends too early"
        ) from None
    except (RecursionError, ValueError):  # brackets without end, a number of 5000 digits
        raise NoAssembly("the file is no JSON that can be read") from None
    if not isinstance(data, dict) or not isinstance(data.get("components"), list):
        found = f"the keys {', '.join(map(repr, list(data)[:6]))}" if isinstance(data, dict) else ""
        raise NoAssembly(
            "the file is JSON and no assembly of openTorsion: it has "
            + (found or f"a {type(data).__name__}")
            + f"; wanted: {_WANTED}"
        )
    return data


def components_of(data: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Components by name. Raises NoAssembly with every problem of their elements."""
    problems: list[str] = []
    found: dict[str, dict[str, Any]] = {}
    for place, one in enumerate(data["components"]):
        where = f"components[{place}]"
        if not isinstance(one, dict) or not _is_name(one.get("name")):
            problems.append(f"{where} has no name of up to 80 letters")
            continue
        where = f"component {one['name'][:40]!r}"
        if one["name"] in found:
            problems.append(f"two components are named {one['name'][:40]!r}")
        elements = one.get("elements")
        if not isinstance(elements, list) or not elements:
            problems.append(f"{where} has no elements")
            continue
        found[one["name"]] = one
        seen: set[tuple[str, str]] = set()
        for number, element in enumerate(elements):
            problems += _problems(element, f"{where}, elements[{number}]", seen)
    if not problems and not found:
        problems.append("the file has no components")
    if not problems and not any(
        element["type"].startswith("Shaft") for one in found.values() for element in one["elements"]
    ):
        problems.append("the assembly has no shaft: nothing twists")
    if problems:
        more = len(problems) - MOST_PROBLEMS
        raise NoAssembly(
            "\n  ".join([*problems[:MOST_PROBLEMS], *([f"and {more} more"] if more > 0 else [])])
        )
    return found


def _problems(element: Any, where: str, seen: set[tuple[str, str]]) -> Iterator[str]:
    """What is wrong with one element."""
    if not isinstance(element, dict):
        yield f"{where} is no element"
        return
    name, kind = element.get("name"), element.get("type")
    group = str(kind)[:5]  # both types of shaft are one group: openTorsion keeps one of a name
    if not isinstance(name, str) or not _is_name(name):
        yield f"{where} has no name of up to 80 letters"
    elif (group, name) in seen:
        yield f"{where}: two elements of a kind are named {name[:40]!r}"
    else:
        seen.add((group, name))
        where = f"{where} {name[:40]!r}"
    if not isinstance(kind, str) or kind not in NUMBERS:
        known = list(NUMBERS)
        hint = nearest(kind, known) if isinstance(kind, str) else ""
        yield f"{where}: type {str(kind)[:40]!r}, wanted one of {', '.join(known)} {hint}".rstrip()
        return
    for key, (least, may_be, default) in NUMBERS[kind].items():
        value = element.get(key, default)
        if value is None and key in ("teeth", "diameter"):
            continue
        if value is None:
            others = [other for other in element if other not in OTHERS]
            yield f"{where} has no {key!r} {nearest(key, others)}".rstrip()
        elif not _is_number(value):
            yield f"{where}: {key} is {str(value)[:40]!r}, no finite number"
        elif abs(value) > LARGEST_NUMBER:
            yield f"{where}: {key} is {value:g}, wanted up to {LARGEST_NUMBER:g}"
        elif value < least or (value == least and not may_be):
            yield f"{where}: {key} is {value:g}, wanted {'>=' if may_be else '>'} {least:g}"
    if kind == "GearElement" and not element.get("teeth" if "teeth" in element else "diameter"):
        yield f"{where} has neither teeth nor a diameter"
    if kind == "ShaftContinuous" and _bore_too_wide(element):
        yield f"{where}: innerDiameter is no smaller than outerDiameter"


def once(name: str, taken: set[Any], group: Any = None) -> str:
    """The name, with a number if it is taken among those of a group; it is taken then."""
    tried, number = name, 2
    while (group, tried) in taken:
        tried, number = f"{name} ({number})", number + 1
    taken.add((group, tried))
    return tried


def _is_name(name: Any) -> bool:
    return isinstance(name, str) and bool(name.strip()) and len(name) <= 80 and fits_a_line(name)


def _is_number(value: Any) -> bool:
    try:
        return (
            isinstance(value, int | float)
            and not isinstance(value, bool)
            and math.isfinite(float(value))
        )
    except OverflowError:
        return False


def _bore_too_wide(element: dict[str, Any]) -> bool:
    both = [element.get(key, 0.0) for key in ("innerDiameter", "outerDiameter")]
    return all(map(_is_number, both)) and bool(both[0] >= both[1] > 0.0)
