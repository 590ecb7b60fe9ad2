"""The kinds of machine: which parts each needs and has, and what finds its speed.

The parts of a machine are shared, so a kind is a name in `KindName` and a row of `KINDS`. `Machine`
gives its crank train and its speed a default of None for the kinds that have none; every other kind
is refused without them here, before anything reads them.
"""

import difflib
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, NamedTuple

from vibecalc.core.case.raw import Data, entries_at, table_at
from vibecalc.core.case.rules import Row, both
from vibecalc.core.results.named import named
from vibecalc.errors import KeyPath, Problem, dotted

if TYPE_CHECKING:
    from vibecalc.schema import Case, Machine

# ----------------------------------------------------------------------------
# Places of a case that only some kinds of machine have, and those that a kind does without.
# ----------------------------------------------------------------------------

MACHINE: KeyPath = ("machine",)
TRAIN: KeyPath = (*MACHINE, "crank_train")
#: tables of [response] whose speed the motor finds
ROLL = ("roll", "start_up", "control")
#: tables of [response] that need no body on mounts
WITHOUT_A_BODY = ("impact", *ROLL, "absorber", "torsion")
#: keys of [response] that ask for the motion of the body
OF_THE_BODY = ("energies", "loads", "operations", "balances", "run_up", "switching")

Places = tuple[KeyPath, ...]


def _in(table: str, *keys: str) -> Places:
    """Keys below a table as key paths; "" is the case itself."""
    return tuple(tuple(f"{table}.{key}".removeprefix(".").split(".")) for key in keys)


#: of engines and of lines without any cylinder
_OF_LINES = _in("", "machine.shaft_line", "response.torsion")
#: of lines with cylinders
_OF_CYLINDERS = (
    *_in("machine.shaft_line.stations.*", "throw", "cylinder", "cylinders"),
    *_in("machine.shaft_line", "shafts.*.throw", "engine_damping"),
    *_in("response.torsion", "orders", "misfire", "conditions", "as_published"),
    *_in("response.torsion", "variable_inertia", "transient.cylinder"),
)
_ABSORBER = (
    *("primary", "secondary", "secondaries", "rod", "flywheel", "springs", "ring", "gap", "oil"),
    *("stock_springs", "stock_oils", "stock_dampers"),
    *("spring_catalogue", "oil_catalogue", "friction_damper", "pendulum"),
)
_OF_ROLL = _in("response", *ROLL)
#: of machines whose gas works once a turn, or whose motor finds the speed
_OF_COMPRESSORS = (
    *_in("machine", "motor", "joints", "shell", "friction"),
    *_in("response", "impact"),
    *_OF_ROLL,
)
#: of machines with cylinders, or a body on mounts; a resolved case holds defaults, so that a switch
#: like `energies` is none of these places
_OF_A_BODY = (
    *_in("", "kinematics", "excitation", "balance", "isolation", "foundation"),
    *_in("", "point", "vibration_severity", "base_motion", "bearing_loads"),
    *_in("response", *(key for key in OF_THE_BODY if key != "energies")),
)

# ----------------------------------------------------------------------------
# The kinds.
# ----------------------------------------------------------------------------


class Kind(NamedTuple):
    """What a kind of machine needs and has, and what may be asked of it.

    `about` says what it is. `driven`: a motor may find its speed. `rules`: where the rules stand
    that [machine] of this kind alone has. `gas`: the torque of what is in its cylinders counts, so
    that it may reach the mounts; its cycle is said by `machine.cycle`, or is one turn. What is
    `exclusive` has no other kind but those that say the same, what is `foreign` has not this one:
    `instead` says what it has, `hints` are words for some of these places.
    """

    about: str
    needs: tuple[str, ...] = ()
    driven: bool = False
    rules: str = ""
    gas: Literal["", "said", "turn"] = ""
    exclusive: Places = ()
    foreign: Places = ()
    instead: str = "a machine of kind 'compressor', whose motor determines the speed"
    hints: Mapping[KeyPath, str] = MappingProxyType({})


KINDS: dict[str, Kind] = {
    "machine": Kind(
        "pistons on a crankshaft at a given speed",
        needs=("crank_train", "speed"),
        foreign=_OF_ROLL,
    ),
    "compressor": Kind(
        "pistons on a crankshaft whose speed is given, or found by its motor",
        needs=("crank_train", "speed"),
        driven=True,
        gas="turn",
    ),
    "plate": Kind("a rigid plate with readings of its vibration", foreign=_OF_ROLL),
    "absorber": Kind(
        "a dynamic absorber on a primary system, or centrifugal pendulums",
        rules="vibecalc.absorber.rules:OF_ABSORBER",
        exclusive=(*_in("machine", *_ABSORBER), *_in("", "tuning", "response.absorber")),
        foreign=(
            *_in("machine", "speed", "crank_train", "body", "mounts", "rotor"),
            *_OF_COMPRESSORS,
            *_OF_A_BODY,
        ),
        instead=", ".join(_ABSORBER),
        hints={(*MACHINE, "speed"): "its pendulums turn at machine.pendulum.speed"},
    ),
    "engine": Kind(
        "pistons that fire in two strokes or four, and the shaft line that they twist",
        needs=("crank_train", "speed", "cycle"),
        rules="vibecalc.parts.rules:OF_ENGINE",
        gas="said",
        exclusive=(
            *_in("", "machine.cycle", "damper_design"),
            *_OF_LINES,
            *_in("machine.crank_train", "firing_order", "firing_intervals", "gas_cards"),
            *_in("machine.crank_train", "gas_cycle", "tangential_effort"),
            *_in("machine.crank_train.cylinders.*", "firing_angle", "pressure_scale"),
        ),
        foreign=_OF_COMPRESSORS,
        instead="shaft_line, body and mounts together with the crank_train; [response.torsion]",
    ),
    "pump": Kind(
        "plungers on a crankshaft, between two pressures in every turn",
        needs=("crank_train", "speed"),
        rules="vibecalc.parts.rules:OF_PUMP",
        gas="turn",
        exclusive=_in("machine.crank_train", "pump_cycle"),
        foreign=(
            *_OF_COMPRESSORS,
            *_in("machine.crank_train", "gas_pressure", "gas_interpolation"),
            *_in("machine.crank_train.cylinders.*", "gas_force", "articulated"),
        ),
        instead="pump_cycle with the bore in the crank_train; body and mounts",
    ),
    "drive_train": Kind(
        "a shaft line without cylinders",
        needs=("speed", "shaft_line"),
        exclusive=(*_OF_LINES, *_in("machine.shaft_line", "speed_of")),
        foreign=(
            *_in("machine", "crank_train", "body", "mounts", "rotor"),
            *_OF_COMPRESSORS,
            *_OF_A_BODY,
            *_OF_CYLINDERS,
        ),
        instead="shaft_line with excitations, [response.torsion]",
        hints={
            TRAIN: "a machine with cylinders is an engine, a compressor or a pump",
            (*MACHINE, "motor"): "a motor is a station; its torques are excitations on it",
        },
    ),
}
#: motors whose speed is a result
FINDING_MOTORS = ("slip_table", "linear", "dynamic")
HARMONICS = "torque_harmonics"
MOTORS = (HARMONICS, *FINDING_MOTORS)
#: kind of motor -> keys that tell it, where no kind is said
_TELLING = {
    HARMONICS: {"torque", "rotor_diameter", "skew_angle"},
    "dynamic": {"poles", "voltage", "stator_resistance", "cages"},
    "slip_table": {"slip_table"},
    "linear": {"gain"},
}


def has_crank_train(machine: "Machine") -> bool:
    """Whether there is a crank train; only some kinds can do without."""
    return machine.crank_train is not None


def has_speed(machine: "Machine") -> bool:
    """Whether the case gives the speed; otherwise a motor finds it, or nothing turns."""
    return machine.speed is not None


def finds_speed(machine: "Machine") -> bool:
    """Whether the speed of the machine is a result of its motor."""
    return machine.motor is not None and machine.motor.kind in FINDING_MOTORS


def gas_turns(machine: "Machine") -> bool:
    """Whether the torque of what is in the cylinders of such a machine counts."""
    return bool(KINDS[machine.kind].gas)


def asks_roll(case: "Case") -> bool:
    """Whether anything is asked that the motor finds the speed of."""
    response = case.response
    return response is not None and any(getattr(response, key) is not None for key in ROLL)


def working(case: "Case") -> tuple[str, ...] | None:
    """Names of the cylinders that work; None where the case does not say."""
    return None if case.excitation is None else case.excitation.working


def motor_kind(machine: Data) -> str:
    """The kind of motor of a machine as tomllib reads it, said or to be guessed; "" for none."""
    motor = machine.get("motor")
    if not isinstance(motor, dict):
        return ""
    kind = motor.get("kind")
    if isinstance(kind, str):
        return next(iter(difflib.get_close_matches(kind[:60], MOTORS, n=1)), kind)
    return next((kind for kind, keys in _TELLING.items() if keys & motor.keys()), HARMONICS)


# ----------------------------------------------------------------------------
# What the kind of a machine or a stage needs and that is not there.
# ----------------------------------------------------------------------------

#: tables that ask for results at a given speed of a crank train
_ASKED = ("kinematics", "excitation", "balance", "response", "isolation", "bearing_loads")


def check_kinds(row: Row) -> Iterator[Problem]:
    """Yield what the kind of this machine or a stage needs and that is not there."""
    machine, name = row.data, str(row.data.get("kind", ""))
    near = difflib.get_close_matches(name[:80].lower(), KINDS, n=1)
    kind = KINDS[near[0] if near else "machine"]  # of a name like no other: what most need
    motor = motor_kind(machine)
    finds = motor in FINDING_MOTORS
    if finds and not kind.driven and name in KINDS:
        yield row.problem(
            "motor.kind",
            f"no motor determines the speed of a machine of kind {name!r}",
            found=f"motor kind {motor!r}",
            allowed="kind = 'compressor', or a motor of kind 'torque_harmonics'",
            also="kind",
        )
    elif finds and "speed" in machine:
        yield row.problem(
            "speed",
            f"the speed is given twice: a motor of kind {motor!r} determines it",
            allowed="no speed with such a motor, or a motor of kind 'torque_harmonics'",
            hint="the motor brings the machine to the speed at which its torque meets the demand",
            also="motor.kind",
        )
    absent = [part for part in ("crank_train", "speed") if row.lacks(part)]
    for part in kind.needs:
        if not (part == "speed" and finds) and row.lacks(part):
            yield named("vibecalc.core.case.diagnose:missing_key")((*MACHINE, part))
    yield from _stages(row, kind, [part for part in absent if part not in kind.needs], finds)
    if name in KINDS:
        yield from _not_of(row, name, finds)
        for rule in named(kind.rules) if kind.rules else ():
            yield from rule(row)


def _stages(row: Row, kind: Kind, lacking: list[str], finds: bool) -> Iterator[Problem]:
    """What the first table that asks for something lacks, in one problem."""
    asking = [path for path in _asking(row.case) if path not in kind.foreign]  # reported there
    if finds and row.lacks("speed"):
        excused = (("excitation",),) if _runs(row.case) else ()
        others = [path for path in asking if path[-1] not in ROLL and path not in excused]
        running = "[excitation] may contain working and idle alone"
        if others:
            yield row.problem(
                others[0],
                f"{_need(others)} machine.speed, but the motor of this machine determines it",
                allowed=", ".join(f"[response.{name}]" for name in ROLL) + " with such a motor",
                hint=f"with such a motor {running}"
                if others[0] == ("excitation",)
                else "results at a given speed need a case with machine.speed",
                also="motor.kind",
            )
        lacking = [part for part in lacking if part != "speed"]
    if lacking and asking:
        yield row.problem(
            asking[0],
            f"{_need(asking)} {both([f'machine.{part}' for part in lacking])}",
            allowed=f"{both(lacking)} in [machine]",
            hint="optional for this kind of machine, but needed by this table",
            also="kind",
        )


def _need(asking: list[KeyPath]) -> str:
    names = [f"[{dotted(path)}]" for path in asking]
    return f"{both(names)} {'needs' if len(names) == 1 else 'need'}"


def _asking(data: Data) -> Iterator[KeyPath]:
    """Tables of the case that need a crank train and a speed, those of [response] one by one."""
    for table in _ASKED:
        given = data.get(table)
        if not isinstance(given, dict):
            continue
        below = [name for name in WITHOUT_A_BODY if isinstance(given.get(name), dict)]
        if table != "response" or not below or any(given.get(key) for key in OF_THE_BODY):
            yield (table,)
        if table == "response":  # an absorber turns with nothing, an engine needs both anyway
            yield from ((table, name) for name in below if name not in ("absorber", "torsion"))
    if table_at(data, "machine", "joints"):
        yield (*MACHINE, "joints")


def _runs(data: Data) -> bool:
    """Whether [excitation] only says which cylinders work, which needs no speed."""
    given = table_at(data, "excitation")
    others = given.keys() - {"working", "idle"}
    by_default = others == {"driven_machine"} and given["driven_machine"] == "on_body"
    return "working" in given and (not others or by_default)


def absent_places(kind: str) -> dict[KeyPath, list[str]]:
    """Places that a machine of this kind does not have, with the kinds that alone have each.

    Not those in a table that it does not have either.
    """
    mine = KINDS[kind]
    owners: dict[KeyPath, list[str]] = {place: [] for place in mine.foreign}
    for other, row in KINDS.items():
        for place in row.exclusive:
            if place not in mine.exclusive:
                owners.setdefault(place, []).append(other)
    above = {place: [place[:end] for end in range(1, len(place))] for place in owners}
    return {
        place: kinds for place, kinds in owners.items() if owners.keys().isdisjoint(above[place])
    }


def _not_of(row: Row, name: str, finds: bool) -> Iterator[Problem]:
    """What a machine of this kind does not have, and what is for another kind."""
    for place, owners in absent_places(name).items():
        kinds = " or ".join(map(repr, owners))
        for path, value in entries_at(row.case, place):
            header = f"[{dotted(path)}]" if isinstance(value, dict) else str(path[-1])
            if owners:
                message = f"{header} is for a machine of kind {kinds}"
                words = {"found": f"kind = {name!r}", "allowed": f"kind = {kinds}"}
            else:
                message = f"a machine of kind {name!r} has no {header}"
                words = {"allowed": KINDS[name].instead, "hint": KINDS[name].hints.get(place, "")}
            if not (finds and path == (*MACHINE, "motor")):  # which is said above
                yield row.problem(path, message, **words, also="kind")
