"""Checks of form of an absorber: which tables go together, and what is asked of them."""

from collections.abc import Iterator

from vibecalc.case.absorber_hardware_form import check_hardware
from vibecalc.case.absorber_ratio_form import check_primary, check_secondaries, motion_of
from vibecalc.case.absorber_tuning_form import RESPONSE, TUNING, check_curves, check_tuning
from vibecalc.case.raw import Data, either, read_number, table_at
from vibecalc.errors import KeyPath, Problem

MACHINE: KeyPath = ("machine",)
ABSORBER = "absorber"


def check_kind(data: Data) -> Iterator[Problem]:
    """Yield what is wrong between the tables of an absorber."""
    machine = table_at(data, "machine")
    yield from _scene(data, machine)
    for part in ("primary", "secondary", "pendulum"):
        if part in machine and not isinstance(machine[part], dict):
            return  # told by the schema; the rest would be guessed
    motion = motion_of(machine)
    tuned = isinstance(data.get("tuning"), dict)
    if machine.get("secondary") == {}:
        yield Problem(
            path=(*MACHINE, "secondary"),
            message="[machine.secondary] is empty",
            allowed="a mass_ratio, for example; with [machine.ring] no [machine.secondary] is "
            "needed",
        )
    if isinstance(machine.get("primary"), dict):
        yield from check_primary(machine, motion)
        yield from check_secondaries(machine, motion, tuned)
    yield from check_hardware(data, machine, motion)
    if isinstance(machine.get("pendulum"), dict):
        yield from _pendulum(machine["pendulum"])
    if tuned:
        yield from check_tuning(data, machine)
    if table_at(data, *RESPONSE):
        yield from check_curves(data, machine, motion)


def _scene(data: Data, machine: Data) -> Iterator[Problem]:
    """A primary with what hangs on it, or pendulums on a rotor."""
    yield from either(machine, MACHINE, "primary", ("pendulum",))
    if "primary" in machine:
        ring = "ring" in machine  # which is one absorber, whose spring and damper are elsewhere
        yield from either(machine, MACHINE, "secondary", ("secondaries",), needed=not ring)
    asked: list[KeyPath] = [TUNING] if "tuning" in data else []
    if ABSORBER in table_at(data, "response"):
        asked.append(RESPONSE)
    for path in asked:
        if "primary" not in machine and "pendulum" in machine:
            yield Problem(
                path=path,
                message=f"[{'.'.join(map(str, path))}] needs [machine.primary] and its absorber",
                allowed="[machine.primary] with [machine.secondary]",
                hint="the tuning of a pendulum is its order, which [machine.pendulum] has",
            )
    if "secondary" in machine and "primary" not in machine and "pendulum" in machine:
        yield Problem(
            path=(*MACHINE, "secondary"),
            message="[machine.secondary] needs [machine.primary]",
            hint="pendulums stand alone, on the rotor whose inertia they give",
        )


def _pendulum(pendulum: Data) -> Iterator[Problem]:
    path: KeyPath = (*MACHINE, "pendulum")
    yield from either(pendulum, path, "vertex_distance", ("arm_radius",))
    turns = bool(read_number(pendulum.get("swing_inertia"), "kg*m^2"))
    heavy = ["rollers"] * ("rollers" in pendulum) + ["swing_inertia"] * turns
    if "arm_radius" in pendulum and "path_radius" not in pendulum and heavy:
        yield Problem(
            path=(*path, "arm_radius"),
            message=f"with {' and '.join(heavy)} the path cannot be tuned from the arm's radius",
            allowed="vertex_distance instead, or path_radius beside it",
            also=(*path, heavy[0]),
        )
    if turns:
        for other, wrong in (
            ("path", pendulum.get("path", "circular") != "circular"),
            ("rollers", "rollers" in pendulum),
        ):
            if wrong:
                yield Problem(
                    path=(*path, "swing_inertia"),
                    message="a mass that turns with an arm runs on a circle, without rollers",
                    allowed="no swing_inertia, or path = 'circular' without rollers",
                    also=(*path, other),
                )
                return
