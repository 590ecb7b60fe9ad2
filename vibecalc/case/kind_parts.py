"""Places of a case that only one kind of machine has, and those that a kind does without.

One row for each kind that differs from the others; what a kind has in common with the rest stands
nowhere here.
"""

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from vibecalc.case.kinds import FINDING_MOTORS, MACHINE, motor_kind
from vibecalc.case.raw import Data, table_at, tables_at
from vibecalc.errors import KeyPath, Problem

TRAIN: KeyPath = ("machine", "crank_train")
#: in a path: every entry of the list
EACH = "*"


class PartsOfKind(NamedTuple):
    """`own` has no other kind, `foreign` has not this one; `instead` says what it has.

    `hints` are words for some of the foreign ones.
    """

    own: tuple[KeyPath, ...] = ()
    foreign: tuple[KeyPath, ...] = ()
    instead: str = ""
    hints: Mapping[KeyPath, str] = MappingProxyType({})


_ABSORBER = (
    *("primary", "secondary", "secondaries", "rod", "flywheel", "springs", "ring", "gap", "oil"),
    *("stock_springs", "stock_oils", "stock_dampers"),
    *("spring_catalogue", "oil_catalogue", "pendulum"),
)
#: of machines whose gas works once a turn, or whose motor finds the speed
_OF_COMPRESSORS: tuple[KeyPath, ...] = (
    *((*MACHINE, part) for part in ("motor", "joints", "shell", "friction")),
    *(("response", name) for name in ("impact", "roll", "start_up", "control")),
)
PARTS_OF_KIND: dict[str, PartsOfKind] = {
    "absorber": PartsOfKind(
        own=(
            *((*MACHINE, part) for part in _ABSORBER),
            ("tuning",),
            ("response", "absorber"),
        ),
        foreign=tuple(
            (*MACHINE, part)
            for part in (
                *("speed", "crank_train", "body", "mounts"),
                *("motor", "joints", "rotor", "shell", "friction"),
            )
        ),
        instead=", ".join(_ABSORBER),
        hints={(*MACHINE, "speed"): "its pendulums turn at machine.pendulum.speed"},
    ),
    "engine": PartsOfKind(
        own=(
            (*MACHINE, "cycle"),
            (*MACHINE, "shaft_line"),
            *((*TRAIN, k) for k in ("firing_order", "firing_intervals", "gas_cards", "gas_cycle")),
            ("response", "torsion"),
            ("damper_design",),
            *((*TRAIN, "cylinders", EACH, key) for key in ("firing_angle", "pressure_scale")),
        ),
        foreign=_OF_COMPRESSORS,
        instead="shaft_line, body and mounts beside the crank_train; [response.torsion]",
    ),
    "pump": PartsOfKind(
        own=((*TRAIN, "pump_cycle"),),
        foreign=(
            *_OF_COMPRESSORS,
            *((*TRAIN, key) for key in ("gas_pressure", "gas_interpolation")),
            (*TRAIN, "cylinders", EACH, "gas_force"),
        ),
        instead="pump_cycle with the bore in the crank_train; body and mounts",
    ),
}


def check_parts_of_kind(data: Data, kind: str) -> Iterator[Problem]:
    """Yield what a machine of this kind does not have, and what is for another kind."""
    for other, parts in PARTS_OF_KIND.items():
        if other == kind:
            yield from _foreign(data, kind, parts)
        else:
            yield from _strangers(data, kind, other, parts)


def _foreign(data: Data, kind: str, parts: PartsOfKind) -> Iterator[Problem]:
    finds = motor_kind(table_at(data, "machine")) in FINDING_MOTORS  # told elsewhere
    for place in parts.foreign:
        for path, value in _found(data, place):
            if not (finds and path == (*MACHINE, "motor")):
                yield Problem(
                    path=path,
                    message=f"a machine of kind {kind!r} has no {_shown(path, value)}",
                    allowed=parts.instead,
                    hint=parts.hints.get(place, ""),
                    also=(*MACHINE, "kind"),
                )


def _strangers(data: Data, kind: str, other: str, parts: PartsOfKind) -> Iterator[Problem]:
    for place in parts.own:
        for path, value in _found(data, place):
            yield Problem(
                path=path,
                message=f"{_shown(path, value)} is for a machine of kind {other!r}",
                found=f"kind = {kind!r}",
                allowed=f"kind = {other!r}",
                also=(*MACHINE, "kind"),
            )


def _found(data: Data, place: KeyPath) -> Iterator[tuple[KeyPath, Any]]:
    """The place with what stands there, or every entry of a list that has it."""
    if EACH in place:
        at = place.index(EACH)
        for number, entry in tables_at(data, *map(str, place[:at])):
            if place[-1] in entry:
                yield (*place[:at], number, place[-1]), entry[place[-1]]
    else:
        table = table_at(data, *map(str, place[:-1]))
        if place[-1] in table:
            yield place, table[place[-1]]


def _shown(path: KeyPath, value: Any) -> str:
    """A table by its header, a key by its name."""
    return f"[{'.'.join(map(str, path))}]" if isinstance(value, dict) else str(path[-1])
