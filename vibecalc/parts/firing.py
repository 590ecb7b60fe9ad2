"""When the cylinders of an engine fire, and whether their torque reaches the mounts."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING, Any

from vibecalc.core.case.raw import Data, read_number, table_at, tables_at
from vibecalc.kinds import KINDS, gas_turns

if TYPE_CHECKING:
    from vibecalc.schema import Case, Machine

# ----------------------------------------------------------------------------
# When the cylinders of an engine fire, and how their throws have to stand for it.
#
# A cylinder fires at its top dead centre, where crank angle + crank_phase - bank_angle is a whole
# number of turns; so its crank_phase is bank_angle - firing_angle, whole turns apart.
# ----------------------------------------------------------------------------

TURN = 2.0 * math.pi
#: rad that one cycle takes
CYCLES: Mapping[str, float] = {"four_stroke": 2.0 * TURN, "two_stroke": TURN}


def cycle_angle(machine: "Machine") -> float:
    """Angle in rad after which what is in the cylinders of a machine repeats itself.

    One turn, but of an engine what it says; four strokes stand for an engine that does not.
    """
    if KINDS[machine.kind].gas == "said":
        return CYCLES[machine.cycle or "four_stroke"]
    return TURN


def angles_in_order(
    order: Sequence[str], intervals: Sequence[float], cycle: float, first: float
) -> dict[str, float]:
    """Firing angle in rad of each named cylinder, the first of the order at `first`.

    `intervals` lead from each to the next, the last of them back to the first; none are even ones.
    """
    steps = list(intervals) or [cycle / len(order)] * len(order)
    angles = accumulate([first, *steps[: len(order) - 1]])
    return dict(zip(order, angles, strict=True))


def phase_of(bank_angle: float, firing_angle: float) -> float:
    """Phase in rad, from 0 to a turn, of the throw of a cylinder that fires at `firing_angle`."""
    phase = math.fmod(bank_angle - firing_angle, TURN)
    phase += TURN if phase < 0.0 else 0.0
    return phase if TURN - phase > 1e-12 else 0.0


def with_phases(machine: Data) -> Data:
    """The machine, as tomllib reads it, with a crank_phase for every cylinder if none has one.

    What cannot be read stays as it is, for the schema to tell.
    """
    cylinders = table_at(machine, "crank_train").get("cylinders")
    entries = tables_at(machine, "crank_train", "cylinders")
    if not isinstance(cylinders, list | tuple) or len(entries) != len(cylinders):
        return machine
    if any("crank_phase" in entry for _, entry in entries):
        return machine
    angles = given_angles(machine)
    banks = [read_number(entry.get("bank_angle", 0.0), "rad") for _, entry in entries]
    if angles is None or None in banks:
        return machine
    turned = [
        {**entry, "crank_phase": phase_of(bank or 0.0, angle)}
        for (_, entry), bank, angle in zip(entries, banks, angles, strict=True)
    ]
    return {**machine, "crank_train": {**machine["crank_train"], "cylinders": turned}}


def orders_throws(keys: Iterable[str]) -> bool:
    """Whether setting these keys asks for other phases of throws that the case does not give."""
    names = {part.partition("[")[0] for key in keys for part in key.split(".")}
    asking = {"firing_order", "firing_intervals", "firing_angle", "bank_angle", "cycle"}
    return bool(names & asking) and "crank_phase" not in names


def without_phases(resolved: Data, written: Data) -> Data | None:
    """A resolved case without the phases that `with_phases` gave its throws, if it did.

    `written` is the case as tomllib reads it.
    """
    machine, train = table_at(resolved, "machine"), table_at(resolved, "machine", "crank_train")
    given = [one for _, one in tables_at(written, "machine", "crank_train", "cylinders")]
    if machine.get("kind") != "engine" or any("crank_phase" in one for one in given):
        return None
    throws = [
        {key: value for key, value in one.items() if key != "crank_phase"}
        for _, one in tables_at(resolved, "machine", "crank_train", "cylinders")
    ]
    return {**resolved, "machine": {**machine, "crank_train": {**train, "cylinders": throws}}}


def given_angles(machine: Data) -> list[float] | None:
    """Firing angle of each cylinder in rad as a machine says it, the first of an order at zero.

    None where it does not say them, or not all of them, or not in a way that can be read.
    """
    train = table_at(machine, "crank_train")
    entries = [entry for _, entry in tables_at(machine, "crank_train", "cylinders")]
    written = [read_number(entry.get("firing_angle"), "rad") for entry in entries]
    order: Any = train.get("firing_order")
    if not order:
        known = [angle for angle in written if angle is not None]
        return known if known and len(known) == len(written) else None
    names = [entry.get("name") for entry in entries]
    texts = isinstance(order, list | tuple) and all(isinstance(name, str) for name in order)
    cycle = CYCLES.get(str(machine.get("cycle")))
    if not texts or cycle is None or sorted(map(str, names)) != sorted(order):
        return None
    given = train.get("firing_intervals", ())
    intervals = (
        [read_number(one, "rad") for one in given] if isinstance(given, list | tuple) else []
    )
    stated = [one for one in intervals if one is not None]
    if len(stated) != len(intervals) or len(stated) not in (0, len(order)):
        return None
    angles = angles_in_order(order, stated, cycle, 0.0)
    return [angles[str(name)] for name in names]


# ----------------------------------------------------------------------------
# Does the torque of the cylinders of an engine, a compressor or a pump reach its mounts?
# ----------------------------------------------------------------------------


def with_torque(case: "Case") -> tuple[str, ...]:
    """Which of the tables isolation and response moves a body by the torque of its cylinders.

    The pitch model takes none.
    """
    machine, isolation, response = case.machine, case.isolation, case.response
    asked = []
    if isolation is not None and isolation.model != "pitch" and "torque" in isolation.loads:
        asked.append("isolation")
    if moves_body(case) and response is not None and "torque" in (response.loads or ("torque",)):
        asked.append("response")
    if not asked or not gas_turns(machine) or machine.crank_train.has_slave_rods:
        return ()
    reaches = has_gas(case) and _fires(case) and driven_machine(case) != "cancels_torque"
    return tuple(asked) if reaches else ()


def moves_body(case: "Case") -> bool:
    """Whether [response] has the motion of a body on mounts."""
    machine = case.machine
    return case.response is not None and not (machine.body is None or machine.mounts is None)


def table_that_moves(case: "Case") -> str:
    """The table whose body has the points of a case: [isolation], where there is one."""
    return "response" if case.isolation is None else "isolation"


def driven_machine(case: "Case") -> str:
    """Where the driven machine stands, and what of the torque it gives back."""
    return "on_body" if case.excitation is None else case.excitation.driven_machine


def is_separate(case: "Case") -> bool:
    """Whether the driven machine stands elsewhere."""
    return driven_machine(case) == "separate"


def shakes_with_torque(case: "Case") -> bool:
    """Whether the couple of the crank train holds minus the torque of its masses.

    Not with a shaft line on the body: what of the torque arrives there the line says, and the
    torque reaction has it.
    """
    where = driven_machine(case)
    return where == "separate" or (where == "on_body" and case.machine.shaft_line is None)


def has_gas(case: "Case") -> bool:
    """Whether the case says anything of the pressure in its cylinders."""
    train = case.machine.crank_train
    gas = (train.gas_pressure, train.gas_cards, train.gas_cycle, train.tangential_effort)
    return any((*gas, train.pump_cycle)) or any(one.gas_force for one in train.cylinders)


def _fires(case: "Case") -> bool:
    """Whether the case says when its cylinders fire; where a cycle is a turn the throws do."""
    train = case.machine.crank_train
    if cycle_angle(case.machine) == TURN:
        return True
    reported = bool(train.firing_order) or any(c.firing_angle is not None for c in train.cylinders)
    return reported or len(train.cylinders) == 1
