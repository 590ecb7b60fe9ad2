"""Numbers so large or small that products of them leave the range of double precision."""

from collections.abc import Iterator, Sequence
from itertools import chain
from operator import attrgetter
from typing import Any

from vibecalc.core.case.fields import Table
from vibecalc.errors import KeyPath, Problem, dotted, leaves
from vibecalc.schema import Case

LARGEST = 1e20
SMALLEST = 1e-20
LARGEST_ANGLE = 1e6
ANGLES = frozenset(
    {"crank_phase", "bank_angle", "knuckle_angle", "phase", "orientation", "crank_angle"}
    | {"firing_angle", "firing_intervals", "overlap", "inlet_closes", "exhaust_opens"}
    | {"skew_angle", "combustion_starts", "combustion_ends", "injection_ends"}
)
#: Keys whose value may be as small as it likes: coordinates, shares and differences.
MAY_VANISH = frozenset(
    {"position", "positions", "origin", "wrist_pin_offset", "inertia_products", "gravity", "from"}
    | {"values", "pressure", "cosine", "sine", "dwell"}
    | {"slip", "torque", "force", "time", "factor", "acceleration_feedback", "feedbacks", "delay"}
    | {"min", "max", "between", "density", "real", "imaginary"}
)
#: what is said of a number that is out of range: message, unit, what is allowed, a hint
_TOO_LARGE_ANGLE = (
    "the angle is too large to mean anything in double precision",
    "rad",
    f"magnitude up to {LARGEST_ANGLE:.0e} rad",
    "angles are in radians unless they carry a unit, as in '120 deg'",
)
_TOO_LARGE = (
    "the number is too large to compute with",
    "in SI units",
    f"magnitude up to {LARGEST:.0e} in SI units",
    "",
)
_TOO_SMALL = (
    "the number is too small to compute with",
    "in SI units",
    f"zero where that is allowed, or a magnitude from {SMALLEST:.0e}",
    "",
)
TABLES = (
    *("excitation", "balance", "isolation", "response", "damper_design"),
    *("measurement", "base_motion", "bearing_loads", "foundation"),
)


def present(case: Case) -> list[KeyPath]:
    """The places of a case whose numbers have a range; a study examines each by itself."""
    machine = case.machine
    parts: list[KeyPath] = [
        ("machine", name) for name, part in machine if part is not None and part != ()
    ]
    return parts + [(name,) for name in TABLES if getattr(case, name) is not None]


def _numbers(value: Any, path: KeyPath) -> Iterator[tuple[KeyPath, float]]:
    for place, one in leaves(value, path):
        if isinstance(one, Table):
            yield from _numbers(one.model_dump(by_alias=True, exclude_none=True), place)
        elif isinstance(one, float):
            yield place, one


def range_problems(case: Case, places: Sequence[KeyPath] | None = None) -> list[Problem]:
    """One problem for each number at some places of a case (None: at all) that is out of range."""
    problems = []
    places = present(case) if places is None else places
    parts = (_numbers(attrgetter(dotted(place))(case), place) for place in places)
    for path, value in chain.from_iterable(parts):
        key = next(str(part) for part in reversed(path) if isinstance(part, str))
        words = _TOO_LARGE_ANGLE if key in ANGLES else _TOO_LARGE
        if abs(value) <= (LARGEST_ANGLE if key in ANGLES else LARGEST):
            if key in ANGLES or key in MAY_VANISH or not 0.0 < abs(value) < SMALLEST:
                continue
            words = _TOO_SMALL
        message, unit, allowed, hint = words
        problems.append(Problem(path, message, f"{value:.6g} {unit}", allowed, hint))
    return problems
