"""Checks of form of primary and secondary: each number in one way, all in one kind of motion."""

from collections.abc import Iterator

from vibecalc.case.raw import Data, misspelt, read_number, table_at, tables_at
from vibecalc.errors import KeyPath, Problem

PRIMARY: KeyPath = ("machine", "primary")
SECONDARY: KeyPath = ("machine", "secondary")
TORSION = ("inertia", "stiffness", "damping")
TRANSLATION = ("mass", "linear_stiffness", "linear_damping")
BOTH = {"torsion": TORSION, "translation": TRANSLATION}
#: ways to one number of a secondary
MASSES = ("mass_ratio", "inertia", "mass")
SPRINGS = ("stiffness_ratio", "stiffness", "linear_stiffness")
DAMPERS = ("damping_ratio", "own_damping_ratio", "damping", "linear_damping")
WIRE = ("wire_diameter", "coil_diameter", "turns", "shear_modulus")


def motion_of(machine: Data) -> str:
    """The kind of motion that the primary's units tell: torsion, translation or "" for ratios."""
    primary = table_at(machine, "primary")
    for motion, keys in BOTH.items():
        if primary.keys() & set(keys):
            return motion
    return "torsion" if _from_rod(machine) else ""


def check_primary(machine: Data, motion: str) -> Iterator[Problem]:
    """Yield what the primary lacks or says twice."""
    primary = table_at(machine, "primary")
    if not primary:
        yield Problem(
            path=PRIMARY,
            message="[machine.primary] is empty",
            allowed="damping_ratio = 0.0 for ratios alone, or inertia and stiffness, or mass and "
            "linear_stiffness",
        )
        return
    yield from _mixed(primary, PRIMARY)
    yield from _once(primary, PRIMARY, ("damping_ratio", "damping", "linear_damping"))
    if not motion or _mixing(primary):
        return
    heavy, stiff, _ = BOTH[motion]
    rod = _from_rod(machine)
    half = bool(table_at(machine, "rod").keys() & {"length", "shear_modulus"})  # told there
    if rod and stiff in primary:
        yield Problem(
            path=(*PRIMARY, stiff),
            message=f"the primary's stiffness stands twice: [machine.rod] and {stiff} give it",
            allowed=f"{stiff}, or a rod with length and shear_modulus: one way or the other",
            also=("machine", "rod"),
        )
    for key, there in ((heavy, heavy in primary), (stiff, stiff in primary or half)):
        if not there and not misspelt(primary, PRIMARY, key):
            instead = ", or [machine.rod] with length and shear_modulus" if key == stiff else ""
            yield Problem(
                path=PRIMARY,
                message=f"the primary has units, and no {key}",
                found=", ".join(key for key in primary if key != "damping_ratio") or "a rod",
                allowed=f"{heavy} and {stiff}{instead}",
                hint="damping_ratio alone makes a scene of ratios" if not rod else "",
            )


def check_secondaries(machine: Data, motion: str, tuned: bool) -> Iterator[Problem]:
    """Yield what one absorber or several lack or say twice."""
    secondary, ring = table_at(machine, "secondary"), "ring" in machine
    if secondary or (ring and "secondaries" not in machine):
        path: KeyPath = SECONDARY if secondary else ("machine", "ring")
        yield from _masses(secondary, path, ring)
        yield from _ways(secondary, path, motion, tuned, _built(machine))
    for place, one in tables_at(machine, "secondaries"):
        path = ("machine", "secondaries", place)
        yield from _masses(one, path, False)
        yield from _ways(one, path, motion, tuned, (False, False))


def _masses(one: Data, path: KeyPath, ring: bool) -> Iterator[Problem]:
    yield from _once(one, path, MASSES)
    given = next((key for key in MASSES if key in one), "")
    if ring and given:
        yield Problem(
            path=(*path, given),
            message="the inertia of the seismic mass stands twice: [machine.ring] gives it",
            allowed=f"{given}, or a ring: one way or the other",
            also=("machine", "ring"),
        )
    elif not ring and not given and not misspelt(one, path, *MASSES):
        yield Problem(
            path=path,
            message=f"{_named(path)} has no mass",
            allowed="mass_ratio, inertia (torsion), mass (translation), or [machine.ring]",
        )


def _ways(
    one: Data, path: KeyPath, motion: str, tuned: bool, built: tuple[bool, bool]
) -> Iterator[Problem]:
    yield from _mixed(one, path)
    yield from _units(one, path, motion)
    parts = (("spring", SPRINGS, "[machine.springs]"), ("damper", DAMPERS, "[machine.oil]"))
    for (what, keys, hardware), has in zip(parts, built, strict=True):
        given = [key for key in keys if key in one]
        yield from _once(one, path, keys)
        if tuned and given:
            yield Problem(
                path=(*path, given[0]),
                message=f"{given[0]} is fixed, and [tuning] finds the {what}",
                allowed=f"no {', '.join(keys)} beside [tuning], or no [tuning]",
                hint=f"what is built stands in {hardware}, beside the tuning; tuning.kind and "
                "tuning.bounds hold a value",
                also=("tuning",),
            )
        elif given and has:
            yield Problem(
                path=(*path, given[0]),
                message=f"the {what} stands twice: {hardware} gives it",
                allowed=f"{given[0]}, or {hardware}: one way or the other",
                also=("machine", "springs" if what == "spring" else "oil"),
            )
        elif not (tuned or given or has) and not misspelt(one, path, *keys):
            yield Problem(
                path=path,
                message=f"{_named(path)} has no {what}, and no [tuning] finds one",
                allowed=f"one of {', '.join(keys)} (0 for none), {hardware}, or [tuning]",
            )
    loose = any(read_number(one.get(key), "") == 0.0 for key in SPRINGS if key in one)
    if "own_damping_ratio" in one and loose:
        yield Problem(
            path=(*path, "own_damping_ratio"),
            message="without a spring the absorber has no frequency of its own for this ratio",
            allowed="damping_ratio, which is referred to the primary, or a stiffness > 0",
            also=(*path, next(key for key in SPRINGS if key in one)),
        )


def _built(machine: Data) -> tuple[bool, bool]:
    """Whether springs and oil as built are the spring and the damper of one secondary."""
    sprung = bool(table_at(machine, "springs").keys() & {"rate", *WIRE})
    return sprung, "oil" in machine and "gap" in machine


def _units(one: Data, path: KeyPath, motion: str) -> Iterator[Problem]:
    """A number with a unit needs a primary of that kind of motion."""
    if _mixing(one):
        return
    for name, keys in BOTH.items():
        for key in keys:
            if key in one and name != motion:
                yield Problem(
                    path=(*path, key),
                    message=f"{key} is that of {name}, and the primary is "
                    + (f"in {motion}" if motion else "of ratios alone"),
                    allowed=", ".join((*BOTH.get(motion, ()), *MASSES[:1], *SPRINGS[:1]))
                    + ", damping_ratio",
                    also=PRIMARY,
                )
                return


def _mixing(table: Data) -> bool:
    return all(table.keys() & set(keys) for keys in BOTH.values())


def _mixed(table: Data, path: KeyPath) -> Iterator[Problem]:
    if _mixing(table):
        turning, moving = ([key for key in keys if key in table] for keys in BOTH.values())
        yield Problem(
            path=(*path, moving[0]),
            message=f"{moving[0]} and {turning[0]} exclude each other: a mass moves, an inertia "
            "turns",
            allowed=f"{', '.join(TORSION)} in torsion, or {', '.join(TRANSLATION)} in translation",
            also=(*path, turning[0]),
        )


def _once(table: Data, path: KeyPath, keys: tuple[str, ...]) -> Iterator[Problem]:
    given = [key for key in keys if key in table]
    if len(given) > 1 and not ({given[0], given[1]} <= {*TORSION, *TRANSLATION}):
        yield Problem(
            path=(*path, given[1]),
            message=f"{given[1]} and {given[0]} exclude each other",
            allowed=f"one of {', '.join(keys)}",
            also=(*path, given[0]),
        )


def _from_rod(machine: Data) -> bool:
    rod = table_at(machine, "rod")
    return "length" in rod and "shear_modulus" in rod


def _named(path: KeyPath) -> str:
    return f"[{path[0]}.{path[1]}]" if len(path) == 2 else f"secondaries[{path[2]}]"
