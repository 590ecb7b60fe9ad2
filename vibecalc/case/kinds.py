"""The kinds of machine: which parts each needs and has, and what finds its speed.

The parts of a machine are shared, so a kind is a name in `KindName` and a row of `KINDS`; what it
alone has, or does not have, is a row of `kind_parts.py`. `Machine` gives its crank train and its
speed a default of None for the kinds that have none; every other kind is refused without them here,
before anything reads them.
"""

import difflib
from collections.abc import Iterator
from importlib import import_module
from typing import TYPE_CHECKING, Literal, NamedTuple

from vibecalc.case.raw import Data, misspelt, nearest, table_at
from vibecalc.errors import KeyPath, Problem

if TYPE_CHECKING:
    from vibecalc.case.schema import Machine

MACHINE: KeyPath = ("machine",)


class Kind(NamedTuple):
    """What a kind of machine needs, and what may be asked of it.

    `driven`: a motor may find its speed. `form`: the module of `case/` whose `check_kind(data)`
    yields the problems that this kind alone has. `gas`: the torque of what is in its cylinders
    counts, so that it may reach the mounts; its cycle is said by `machine.cycle`, or is one turn.
    """

    needs: tuple[str, ...] = ()
    driven: bool = False
    form: str = ""
    gas: Literal["", "said", "turn"] = ""


KindName = Literal["generator", "compressor", "plate", "absorber", "engine", "pump"]
KINDS: dict[str, Kind] = {
    "generator": Kind(needs=("crank_train", "speed")),
    "compressor": Kind(needs=("crank_train", "speed"), driven=True),
    "plate": Kind(),
    "absorber": Kind(form="absorber_form"),
    "engine": Kind(needs=("crank_train", "speed"), form="engine_form", gas="said"),
    "pump": Kind(needs=("crank_train", "speed"), form="pump_form", gas="turn"),
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
_ASKED = ("kinematics", "excitation", "response", "isolation")
#: tables of [response] whose speed the motor finds
ROLL = ("roll", "start_up", "control")
#: tables of [response] that need no body on mounts
WITHOUT_A_BODY = ("impact", *ROLL, "absorber", "torsion")
#: keys of [response] that ask for the motion of the body
OF_THE_BODY = ("energies", "operations", "balances", "run_up", "switching")


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


def check_kinds(data: Data) -> Iterator[Problem]:
    """Yield the parts that the kind of machine or a stage needs and that are not there."""
    machine = data.get("machine")
    if not isinstance(machine, dict):
        return
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
            allowed="no speed beside such a motor, or a motor of kind 'torque_harmonics'",
            hint="the motor brings the machine to the speed at which its torque meets the demand",
            also=(*MACHINE, "motor", "kind"),
        )
    for part in kind.needs:
        found_elsewhere = part == "speed" and finds
        if part not in machine and not found_elsewhere and not misspelt(machine, MACHINE, part):
            yield _missing(part)
    yield from _stages(data, machine, kind, finds)
    if name in KINDS:
        from vibecalc.case.kind_parts import check_parts_of_kind

        yield from check_parts_of_kind(data, name)
        if kind.form:
            yield from import_module(f"vibecalc.case.{kind.form}").check_kind(data)


def _meant(name: str) -> Kind:
    """The kind that a misspelt name may mean; of a name like no other, the parts most need."""
    hint = nearest(name, list(KINDS))
    return next((kind for known, kind in KINDS.items() if repr(known) in hint), KINDS["generator"])


def _missing(part: str) -> Problem:
    from vibecalc.case.diagnose import missing_key

    return missing_key((*MACHINE, part))


def _stages(data: Data, machine: Data, kind: Kind, finds: bool) -> Iterator[Problem]:
    """What the first table that asks for something lacks, in one problem."""
    asking = list(_asking(data))
    absent = [
        part
        for part in ("crank_train", "speed")
        if part not in machine and not misspelt(machine, MACHINE, part)
    ]
    if finds and "speed" in absent:
        others = [path for path in asking if path[-1] not in ROLL]
        others = [path for path in others if path != ("excitation",) or not _runs(data)]
        if others:
            yield _found_elsewhere(others)
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


def _found_elsewhere(asking: list[KeyPath]) -> Problem:
    running = (
        "beside such a motor [excitation] may say which cylinders work, with working and idle alone"
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
