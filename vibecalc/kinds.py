"""The kinds of machine: which parts each needs and has, and what finds its speed."""

import difflib
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from vibecalc.core.case.raw import Data, misspelt, nearest, table_at, tables_at
from vibecalc.core.case.rules import Row
from vibecalc.core.results.named import named
from vibecalc.errors import KeyPath, Problem

if TYPE_CHECKING:
    from vibecalc.schema import Case, Machine

# ----------------------------------------------------------------------------
# The kinds of machine: which parts each needs and has, and what finds its speed.
#
# The parts of a machine are shared, so a kind is a name in `KindName` and a row of `KINDS`; what it
# alone has, or does not have, is a row of `kind_parts.py`. `Machine` gives its crank train and its
# speed a default of None for the kinds that have none; every other kind is refused without them
# here, before anything reads them.
# ----------------------------------------------------------------------------

MACHINE: KeyPath = ("machine",)
TRAIN: KeyPath = (*MACHINE, "crank_train")


class Kind(NamedTuple):
    """What a kind of machine needs, and what may be asked of it.

    `about` says what it is. `driven`: a motor may find its speed. `rules`: where the rules stand
    that [machine] of this kind alone has. `gas`: the torque of what is in its cylinders counts, so
    that it may reach the mounts; its cycle is said by `machine.cycle`, or is one turn.
    """

    about: str
    needs: tuple[str, ...] = ()
    driven: bool = False
    rules: str = ""
    gas: Literal["", "said", "turn"] = ""


KINDS: dict[str, Kind] = {
    "generator": Kind("pistons on a crankshaft at a given speed", needs=("crank_train", "speed")),
    "compressor": Kind(
        "pistons on a crankshaft whose speed is given, or found by its motor",
        needs=("crank_train", "speed"),
        driven=True,
        gas="turn",
    ),
    "plate": Kind("a rigid plate with readings of its vibration"),
    "absorber": Kind(
        "a dynamic absorber on a primary system, or centrifugal pendulums",
        rules="vibecalc.absorber.rules:OF_ABSORBER",
    ),
    "engine": Kind(
        "pistons that fire in two strokes or four, and the shaft line that they twist",
        needs=("crank_train", "speed", "cycle"),
        rules="vibecalc.parts.rules:OF_ENGINE",
        gas="said",
    ),
    "pump": Kind(
        "plungers on a crankshaft, between two pressures in every turn",
        needs=("crank_train", "speed"),
        rules="vibecalc.parts.rules:OF_PUMP",
        gas="turn",
    ),
    "drive_train": Kind("a shaft line without cylinders", needs=("speed", "shaft_line")),
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
#: tables that ask for results at a given speed of a crank train
_ASKED = ("kinematics", "excitation", "balance", "response", "isolation", "bearing_loads")
#: tables of [response] whose speed the motor finds
ROLL = ("roll", "start_up", "control")
#: tables of [response] that need no body on mounts
WITHOUT_A_BODY = ("impact", *ROLL, "absorber", "torsion")
#: keys of [response] that ask for the motion of the body
OF_THE_BODY = ("energies", "loads", "operations", "balances", "run_up", "switching")


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


def motor_kind(machine: Data) -> str:
    """The kind of motor of a machine as tomllib reads it, said or to be guessed; "" for none."""
    motor = machine.get("motor")
    if not isinstance(motor, dict):
        return ""
    kind = motor.get("kind")
    if isinstance(kind, str):
        near = difflib.get_close_matches(kind[:60], MOTORS, n=1)
        return near[0] if near and kind not in MOTORS else kind
    return next((kind for kind, keys in _TELLING.items() if keys & motor.keys()), HARMONICS)


def check_kinds(row: Row) -> Iterator[Problem]:
    """Yield what the kind of this machine or a stage needs and that is not there."""
    data, machine = row.case, row.data
    name = str(machine.get("kind", ""))
    kind = KINDS.get(name) or _meant(name)
    motor = motor_kind(machine)
    finds = motor in FINDING_MOTORS
    if finds and not kind.driven and name in KINDS:
        yield Problem(
            path=(*MACHINE, "motor", "kind"),
            message=f"no motor finds the speed of a machine of kind {name!r}",
            found=f"motor kind {motor!r}",
            allowed="kind = 'compressor', or a motor of kind 'torque_harmonics'",
            also=(*MACHINE, "kind"),
        )
    elif finds and "speed" in machine:
        yield Problem(
            path=(*MACHINE, "speed"),
            message=f"the speed stands twice: a motor of kind {motor!r} finds it",
            allowed="no speed with such a motor, or a motor of kind 'torque_harmonics'",
            hint="the motor brings the machine to the speed at which its torque meets the demand",
            also=(*MACHINE, "motor", "kind"),
        )
    for part in kind.needs:
        set_elsewhere = part == "speed" and finds
        if part not in machine and not set_elsewhere and not misspelt(machine, MACHINE, part):
            yield _missing(part)
    yield from _stages(data, machine, kind, finds)
    if name in KINDS:
        yield from check_parts_of_kind(data, name)
        for rule in named(kind.rules) if kind.rules else ():
            yield from rule(row)


def _meant(name: str) -> Kind:
    """The kind that a misspelt name may mean; of a name like no other, the parts most need."""
    hint = nearest(name, list(KINDS))
    return next((kind for known, kind in KINDS.items() if repr(known) in hint), KINDS["generator"])


def _missing(part: str) -> Problem:
    from vibecalc.core.case.diagnose import missing_key

    return missing_key((*MACHINE, part))


def _stages(data: Data, machine: Data, kind: Kind, finds: bool) -> Iterator[Problem]:
    """What the first table that asks for something lacks, in one problem."""
    foreign = parts_of(str(machine.get("kind", ""))).foreign  # reported there
    asking = [path for path in _asking(data) if path not in foreign]
    absent = [
        part
        for part in ("crank_train", "speed")
        if part not in machine and not misspelt(machine, MACHINE, part)
    ]
    if finds and "speed" in absent:
        others = [path for path in asking if path[-1] not in ROLL]
        others = [path for path in others if path != ("excitation",) or not _runs(data)]
        if others:
            yield _set_elsewhere(others)
        absent.remove("speed")
    lacking = [part for part in absent if part not in kind.needs]
    if lacking and asking:
        names = " and ".join(f"machine.{part}" for part in lacking)
        yield Problem(
            path=asking[0],
            message=f"{_listed(asking)} {names}",
            allowed=f"{' and '.join(lacking)} in [machine]",
            hint="this kind of machine can do without, but not what is asked of it here",
            also=(*MACHINE, "kind"),
        )


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


def _set_elsewhere(asking: list[KeyPath]) -> Problem:
    running = (
        "with such a motor [excitation] may say which cylinders work, with working and idle alone"
    )
    return Problem(
        path=asking[0],
        message=f"{_listed(asking)} machine.speed, which the motor of this machine finds",
        allowed=", ".join(f"[response.{name}]" for name in ROLL) + " with such a motor",
        hint=running
        if asking[0] == ("excitation",)
        else "what is computed at a given speed is a case of its own, with machine.speed",
        also=(*MACHINE, "motor", "kind"),
    )


def _listed(asking: list[KeyPath]) -> str:
    names = [f"[{'.'.join(map(str, path))}]" for path in asking]
    listed = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
    return f"{listed} {'needs' if len(names) == 1 else 'need'}"


# ----------------------------------------------------------------------------
# Places of a case that only one kind of machine has, and those that a kind does without.
#
# One row for each kind that differs from the others; what a kind has in common with the rest stands
# nowhere here.
# ----------------------------------------------------------------------------

#: in a path: every entry of the list
EACH = "*"


class PartsOfKind(NamedTuple):
    """`exclusive` has no other kind, `foreign` has not this one; `instead` says what it has.

    `hints` are words for some of the foreign ones.
    """

    exclusive: tuple[KeyPath, ...] = ()
    foreign: tuple[KeyPath, ...] = ()
    instead: str = ""
    hints: Mapping[KeyPath, str] = MappingProxyType({})


#: of engines and of lines without any cylinder
_OF_LINES: tuple[KeyPath, ...] = ((*MACHINE, "shaft_line"), ("response", "torsion"))
_LINE = (*MACHINE, "shaft_line")
#: of lines with cylinders
_OF_CYLINDERS: tuple[KeyPath, ...] = (
    *((*_LINE, "stations", EACH, key) for key in ("throw", "cylinder", "cylinders")),
    (*_LINE, "shafts", EACH, "throw"),
    (*_LINE, "engine_damping"),
    *(("response", "torsion", key) for key in ("orders", "misfire", "conditions", "as_published")),
    ("response", "torsion", "variable_inertia"),
    ("response", "torsion", "transient", "cylinder"),
)
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
#: of machines with cylinders, or a body on mounts
_OF_A_BODY: tuple[KeyPath, ...] = (
    *((name,) for name in ("kinematics", "excitation", "balance", "isolation", "foundation")),
    *((name,) for name in ("point", "vibration_severity", "base_motion", "bearing_loads")),
)
#: what is asked of the motion of a body, or at the speed that a motor finds; a resolved case holds
#: defaults, so that a switch like `energies` is none of these places
_OF_THE_BODY: tuple[KeyPath, ...] = tuple(
    ("response", key) for key in OF_THE_BODY if key != "energies"
)
_OF_ROLL: tuple[KeyPath, ...] = tuple(("response", key) for key in ROLL)
_HAS_NO_MOTOR = "a machine of kind 'compressor', whose motor finds the speed"
PARTS_OF_KIND: dict[str, PartsOfKind] = {
    "generator": PartsOfKind(foreign=_OF_ROLL, instead=_HAS_NO_MOTOR),
    "plate": PartsOfKind(foreign=_OF_ROLL, instead=_HAS_NO_MOTOR),
    "absorber": PartsOfKind(
        exclusive=(
            *((*MACHINE, part) for part in _ABSORBER),
            ("tuning",),
            ("response", "absorber"),
        ),
        foreign=(
            *((*MACHINE, part) for part in ("speed", "crank_train", "body", "mounts", "rotor")),
            *_OF_COMPRESSORS,
            *_OF_A_BODY,
            *_OF_THE_BODY,
        ),
        instead=", ".join(_ABSORBER),
        hints={(*MACHINE, "speed"): "its pendulums turn at machine.pendulum.speed"},
    ),
    "engine": PartsOfKind(
        exclusive=(
            (*MACHINE, "cycle"),
            ("damper_design",),
            *_OF_LINES,
            *((*TRAIN, k) for k in ("firing_order", "firing_intervals", "gas_cards", "gas_cycle")),
            (*TRAIN, "tangential_effort"),
            *((*TRAIN, "cylinders", EACH, key) for key in ("firing_angle", "pressure_scale")),
        ),
        foreign=_OF_COMPRESSORS,
        instead="shaft_line, body and mounts together with the crank_train; [response.torsion]",
    ),
    "drive_train": PartsOfKind(
        exclusive=(*_OF_LINES, (*MACHINE, "shaft_line", "speed_of")),
        foreign=(
            *((*MACHINE, part) for part in ("crank_train", "body", "mounts", "rotor")),
            *_OF_COMPRESSORS,
            *_OF_A_BODY,
            *_OF_THE_BODY,
            *_OF_CYLINDERS,
        ),
        instead="shaft_line with excitations, [response.torsion]",
        hints={
            TRAIN: "what has cylinders is an engine, a compressor or a pump",
            (*MACHINE, "motor"): "a motor is a station; its torques are excitations on it",
        },
    ),
    "pump": PartsOfKind(
        exclusive=((*TRAIN, "pump_cycle"),),
        foreign=(
            *_OF_COMPRESSORS,
            *((*TRAIN, key) for key in ("gas_pressure", "gas_interpolation")),
            *((*TRAIN, "cylinders", EACH, key) for key in ("gas_force", "articulated")),
        ),
        instead="pump_cycle with the bore in the crank_train; body and mounts",
    ),
}


def check_parts_of_kind(data: Data, kind: str) -> Iterator[Problem]:
    """Yield what a machine of this kind does not have, and what is for another kind."""
    yield from _foreign(data, kind, parts_of(kind))
    for place, owners in of_others(kind).items():
        yield from _strangers(data, kind, place, " or ".join(map(repr, owners)))


def parts_of(kind: str) -> PartsOfKind:
    """The row of a kind in `PARTS_OF_KIND`."""
    return PARTS_OF_KIND.get(kind, PartsOfKind())


def of_others(kind: str) -> dict[KeyPath, list[str]]:
    """Places that only other kinds have, with these kinds."""
    owners: dict[KeyPath, list[str]] = {}
    for other, parts in PARTS_OF_KIND.items():
        for place in parts.exclusive:
            owners.setdefault(place, []).append(other)
    mine = parts_of(kind).exclusive
    return {place: kinds for place, kinds in owners.items() if place not in mine}


def _foreign(data: Data, kind: str, parts: PartsOfKind) -> Iterator[Problem]:
    finds = motor_kind(table_at(data, "machine")) in FINDING_MOTORS  # reported elsewhere
    for place in parts.foreign:
        for path, value in _entries_at(data, place):
            if not (finds and path == (*MACHINE, "motor")):
                yield Problem(
                    path=path,
                    message=f"a machine of kind {kind!r} has no {_shown(path, value)}",
                    allowed=parts.instead,
                    hint=parts.hints.get(place, ""),
                    also=(*MACHINE, "kind"),
                )


def _strangers(data: Data, kind: str, place: KeyPath, kinds: str) -> Iterator[Problem]:
    for path, value in _entries_at(data, place):
        yield Problem(
            path=path,
            message=f"{_shown(path, value)} is for a machine of kind {kinds}",
            found=f"kind = {kind!r}",
            allowed=f"kind = {kinds}",
            also=(*MACHINE, "kind"),
        )


def _entries_at(data: Data, place: KeyPath) -> Iterator[tuple[KeyPath, Any]]:
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


def asks_roll(case: "Case") -> bool:
    """Whether anything is asked that the motor finds the speed of."""
    response = case.response
    if response is None:
        return False
    asked = (response.roll, response.start_up, response.control)
    return any(table is not None for table in asked)


def working(case: "Case") -> tuple[str, ...] | None:
    """Names of the cylinders that work; None where the case does not say."""
    return None if case.excitation is None else case.excitation.working
