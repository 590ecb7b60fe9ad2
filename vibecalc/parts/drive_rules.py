"""Rules between the keys of a motor, and of the cylinders of a pump."""

from collections.abc import Iterator
from typing import NamedTuple

from vibecalc.core.case.diagnose import missing_key
from vibecalc.core.case.raw import Data, misspelt, read_number, table_at
from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import HARMONICS, TRAIN, motor_kind

# ----------------------------------------------------------------------------
# Checks of form of the motor: each kind has its own keys.
# ----------------------------------------------------------------------------

MOTOR: KeyPath = ("machine", "motor")


class Keys(NamedTuple):
    """Keys that a kind of motor needs, and those that it may have besides."""

    needed: tuple[str, ...]
    other: tuple[str, ...] = ()


KEYS: dict[str, Keys] = {
    HARMONICS: Keys(("rotor_diameter", "skew_angle", "torque")),
    "slip_table": Keys(("synchronous_speed", "slip_table"), ("interpolation", "beyond")),
    "linear": Keys(("synchronous_speed", "gain")),
    "dynamic": Keys(
        ("synchronous_speed", "slip_table", "poles", "voltage", "stator_resistance"),
        ("cages", "interpolation", "beyond"),
    ),
}
_KNOWN = tuple(dict.fromkeys(key for keys in KEYS.values() for key in (*keys.needed, *keys.other)))


def check_motor(data: Data) -> Iterator[Problem]:
    """Yield the keys that the motor lacks for its kind, and those that belong to another one."""
    motor = table_at(data, "machine").get("motor")
    if not isinstance(motor, dict):
        return
    kind = motor_kind(data["machine"])
    if kind not in KEYS:
        return  # told by the schema; which keys it should have is anyone's guess
    keys = KEYS[kind]
    if "kind" not in motor and kind != HARMONICS:
        yield Problem(
            path=MOTOR,
            message="the motor does not say its kind",
            found=", ".join(key for key in _KNOWN if key in motor),
            allowed=f"kind = {kind!r}, with {', '.join(keys.needed)}",
            hint=f"without a kind it is {HARMONICS!r}: torque by order at a given speed",
        )
        return
    for key in keys.needed:
        if key not in motor and not misspelt(motor, MOTOR, key):
            yield missing_key((*MOTOR, key))
    for key in motor:
        if key in _KNOWN and key not in (*keys.needed, *keys.other):
            owners = [name for name, row in KEYS.items() if key in (*row.needed, *row.other)]
            yield Problem(
                path=(*MOTOR, key),
                message=f"a motor of kind {kind!r} has no {key}",
                allowed=", ".join((*keys.needed, *keys.other)),
                hint=f"{key} belongs to a motor of kind {' or '.join(map(repr, owners))}",
                also=(*MOTOR, "kind") if "kind" in motor else None,
            )


# ----------------------------------------------------------------------------
# Checks of form of a pump: what its pressure needs.
# ----------------------------------------------------------------------------

CYCLE: KeyPath = (*TRAIN, "pump_cycle")


def check_pump(data: Data) -> Iterator[Problem]:
    """Yield what a pump lacks, and pressures the wrong way round."""
    train = table_at(data, *map(str, TRAIN))
    if not train:
        return
    for needed, why in (
        ("pump_cycle", "the pressures between which a pump works"),
        ("bore", "the diameter of the plunger, on which the pressure acts"),
    ):
        if needed not in train and not misspelt(train, TRAIN, needed):
            yield Problem(
                path=TRAIN,
                message=f"a pump needs {needed} in [machine.crank_train]: {why}",
                allowed="a machine of kind 'generator' if only its masses count",
                also=("machine", "kind"),
            )
    cycle = train.get("pump_cycle")
    if not isinstance(cycle, dict):
        return
    low, high = (
        read_number(cycle.get(f"{way}_pressure"), "Pa") for way in ("suction", "discharge")
    )
    if low is not None and high is not None and not low < high:
        yield Problem(
            path=(*CYCLE, "discharge_pressure"),
            message="a pump delivers at a higher pressure than it draws at",
            found=f"{cycle['discharge_pressure']} and {cycle['suction_pressure']}",
            allowed="discharge_pressure > suction_pressure, both absolute",
            also=(*CYCLE, "suction_pressure"),
        )
