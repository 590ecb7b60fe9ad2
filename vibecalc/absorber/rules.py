"""Rules between the keys of an absorber's tables: which go together, each number given once."""

from collections.abc import Iterator

from vibecalc.core.case.raw import Data, either, misspelt, read_number, table_at, tables_at
from vibecalc.errors import KeyPath, Problem

# ----------------------------------------------------------------------------
# Checks of form of primary and secondary: each number in one way, all in one kind of motion.
# ----------------------------------------------------------------------------

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


# ----------------------------------------------------------------------------
# Checks of form of what an absorber is built of: what goes with what, each number in one way.
# ----------------------------------------------------------------------------

MACHINE: KeyPath = ("machine",)
#: part -> the part that it goes with
_NEEDS = {
    "flywheel": "rod",
    "oil": "gap",
    "stock_oils": "gap",
    "oil_catalogue": "gap",
    "stock_springs": "springs",
    "stock_dampers": "secondary",
    "spring_catalogue": "springs",
    "rod": "primary",
    "springs": "secondary",
    "gap": "secondary",
    "ring": "primary",
}
_OILS = ("oil", "stock_oils", "oil_catalogue")
_CATALOGUES = ("spring_catalogue", "oil_catalogue")
_BENDING = ("total_length", "span", "elastic_modulus")


def check_hardware(data: Data, machine: Data, motion: str) -> Iterator[Problem]:
    """Yield the problems of rod, flywheel, springs, ring, gap, oils and stock."""
    several = "secondaries" in machine
    for part, other in _NEEDS.items():
        there = other in machine or (other == "secondary" and "ring" in machine)
        if part in machine and not there and not misspelt(machine, MACHINE, other):
            yield Problem(
                path=(*MACHINE, part),
                message=f"[machine.{part}] needs [machine.{other}]",
                hint="several absorbers have no parts as built" if several else "",
            )
    if "ring" in machine and several:
        yield Problem(
            path=(*MACHINE, "ring"),
            message="[machine.ring] is the mass of one absorber, and there are several",
            allowed="an inertia or a mass_ratio for each",
            also=(*MACHINE, "secondaries"),
        )
    if isinstance(machine.get("rod"), dict):
        yield from _rod(machine["rod"], "flywheel" in machine)
    if isinstance(machine.get("springs"), dict):
        yield from _springs(data, machine["springs"], motion)
    yield from _hardware_units(machine, motion)
    if isinstance(machine.get("gap"), dict):
        yield from _oils(machine, machine["gap"])
    for part in _CATALOGUES:
        columns = table_at(machine, part)
        sizes = {name: len(rows) for name, rows in columns.items() if isinstance(rows, list)}
        if len(set(sizes.values())) > 1:
            yield Problem(
                path=(*MACHINE, part),
                message=f"the columns of {part} are not of one length",
                found=", ".join(f"{size} of {name}" for name, size in sizes.items()),
                allowed="as many entries in each",
            )


def _rod(rod: Data, bends: bool) -> Iterator[Problem]:
    path: KeyPath = (*MACHINE, "rod")
    for one, other in (("length", "shear_modulus"), ("shear_modulus", "length")):
        if one in rod and other not in rod and not misspelt(rod, path, other):
            yield Problem(
                path=(*path, one),
                message=f"the rod has {one} and no {other}: they give its stiffness together",
                allowed="both, or neither for a rod that only bends",
            )
    if bends:
        yield from either(rod, path, "mass", ("density",))
        for key in _BENDING:
            if key not in rod and not misspelt(rod, path, key):
                yield Problem(
                    path=path,
                    message=f"[machine.flywheel] asks how the rod bends, and the rod has no {key}",
                    allowed=", ".join((*_BENDING, "mass or density")),
                    also=(*MACHINE, "flywheel"),
                )
    elif not ({"length", "shear_modulus"} & rod.keys()) and not misspelt(rod, path, "length"):
        yield Problem(
            path=path,
            message="the rod is neither twisted nor bent",
            allowed="length and shear_modulus, or [machine.flywheel] on its end",
        )


def _springs(data: Data, springs: Data, motion: str) -> Iterator[Problem]:
    path: KeyPath = (*MACHINE, "springs")
    wire = [key for key in WIRE if key in springs]
    yield from either(springs, path, "rate", WIRE, needed=False)
    missing = [key for key in WIRE if key not in springs and not misspelt(springs, path, key)]
    if wire and missing and "rate" not in springs:
        yield Problem(
            path=path,
            message=f"a spring from its wire needs {' and '.join(missing)}, too",
            allowed=f"all of {', '.join(WIRE)}, or rate",
            also=(*path, wire[0]),
        )
    unrated = not wire and "rate" not in springs and "tuning" not in data
    if unrated and not misspelt(springs, path, "rate", *WIRE):
        yield Problem(
            path=path,
            message="the springs have no rate, and no [tuning] finds one",
            allowed=f"rate, or {', '.join(WIRE)}, or [tuning]",
        )
    if motion == "torsion" and "radius" not in springs and not misspelt(springs, path, "radius"):
        yield Problem(
            path=path,
            message="springs of a mass that turns need the radius of their hooks",
            allowed="radius = '140 mm', for example",
        )
    elif motion == "translation" and "radius" in springs:
        yield Problem(
            path=(*path, "radius"),
            message="springs of a mass that moves in a line have no radius",
            allowed="count, angle and rate",
            also=(*MACHINE, "primary"),
        )
    if "allowed_stress" in springs and not wire:
        yield Problem(
            path=(*path, "allowed_stress"),
            message="the stress of a spring follows from its wire, which is not given",
            allowed=", ".join(WIRE),
        )


def _hardware_units(machine: Data, motion: str) -> Iterator[Problem]:
    """Parts have units, so that the primary needs them; what turns needs torsion."""
    turning = [part for part in ("rod", "ring", "gap") if part in machine]
    moving = [part for part in ("stock_dampers",) if part in machine]
    placed = [*turning, *moving, *(["springs"] if "springs" in machine else [])]
    if not isinstance(machine.get("primary"), dict) or not machine["primary"]:
        return
    if not motion and placed and placed != ["rod"]:
        part = next(part for part in placed if part != "rod")
        yield Problem(
            path=(*MACHINE, part),
            message=f"[machine.{part}] has units, and the primary is of ratios alone",
            allowed="a primary with inertia and stiffness",
            also=(*MACHINE, "primary"),
        )
    elif motion == "torsion" and moving:
        yield Problem(
            path=(*MACHINE, moving[0]),
            message=f"[machine.{moving[0]}] move in a line, and the primary turns",
            allowed="[machine.gap] with oils in stock, or a primary with mass and linear_stiffness",
            also=(*MACHINE, "primary"),
        )
    elif motion == "translation" and turning:
        yield Problem(
            path=(*MACHINE, turning[0]),
            message=f"[machine.{turning[0]}] turns, and the primary moves in a line",
            allowed="a primary with inertia and stiffness",
            also=(*MACHINE, "primary"),
        )


def _oils(machine: Data, gap: Data) -> Iterator[Problem]:
    path: KeyPath = (*MACHINE, "gap")
    there = [part for part in _OILS if part in machine]
    if there and "temperature" not in gap and not misspelt(gap, path, "temperature"):
        yield Problem(
            path=path,
            message=f"[machine.{there[0]}] needs the temperature at which the oil runs",
            allowed="temperature = '60 degC', for example",
            also=(*MACHINE, there[0]),
        )
    if "bore_clearance" in gap and "inner_radius" not in gap:
        yield Problem(
            path=(*path, "bore_clearance"),
            message="a disc without a bore has no film in it",
            allowed="inner_radius > 0 beside it",
        )


# ----------------------------------------------------------------------------
# Checks of form of [tuning] and [response.absorber].
# ----------------------------------------------------------------------------

TUNING: KeyPath = ("tuning",)
RESPONSE: KeyPath = ("response", "absorber")
#: restricted kind of tuning -> what it holds, the bound that it then makes idle
_HELD = {
    "viscous": ("the spring is none", "stiffness_ratio"),
    "undamped_spring": ("the damper is none", "damping_ratio"),
}
#: keys of [tuning] that several absorbers do not have
_OF_ONE = ("compare", "temperatures", "chart")
#: closed forms that make no mean square small
_OF_AMPLITUDES = ("den_hartog", "nishihara_asami")
_VARIED = ("primary_damping", "mass_ratio", "stiffness_ratio", "secondary_damping", "own_damping")


def check_tuning(data: Data, machine: Data) -> Iterator[Problem]:
    """Yield what contradicts itself in [tuning], and what it lacks."""
    tuning = data["tuning"]
    kind = tuning.get("kind", "free")
    held, idle = _HELD.get(kind, ("", "")) if isinstance(kind, str) else ("", "")
    bounds = table_at(tuning, "bounds")
    if idle in bounds:
        yield Problem(
            path=(*TUNING, "bounds", idle),
            message=f"of kind {kind!r} {held}, and a bound holds nothing",
            allowed=f"no {idle} in the bounds, or kind = 'free'",
            also=(*TUNING, "kind"),
        )
    if kind == "lanchester" and bounds:
        yield Problem(
            path=(*TUNING, "bounds"),
            message="Lanchester's damper is that of a formula, which knows no bounds",
            allowed="kind = 'viscous', whose damper is found within them",
            also=(*TUNING, "kind"),
        )
    for key in ("stiffness_ratio", "damping_ratio"):
        ends = bounds.get(key)
        if isinstance(ends, list) and len(ends) == 2:
            yield from _ordered((*TUNING, "bounds", key), ends[0], ends[1], "", "<=")
    yield from _methods(tuning)
    yield from _kinds(tuning, kind)
    yield from _ranges(tuning)
    if "temperatures" in tuning and not any(part in machine for part in _OILS):
        yield Problem(
            path=(*TUNING, "temperatures"),
            message="what warms is an oil, and there is none",
            allowed="[machine.gap] with [machine.oil] or oils in stock",
        )
    if "secondaries" in machine:
        yield from _several(tuning, kind)


def check_curves(data: Data, machine: Data, motion: str) -> Iterator[Problem]:
    """Yield what contradicts itself in [response.absorber]."""
    asked = table_at(data, *RESPONSE)
    yield from either(asked, RESPONSE, "frequency_ratios", ("frequencies",), needed=False)
    if "frequencies" in asked and not motion and isinstance(machine.get("primary"), dict):
        yield Problem(
            path=(*RESPONSE, "frequencies"),
            message="the primary is of ratios alone and has no frequency in Hz",
            allowed="frequency_ratios, or a primary with inertia and stiffness",
            also=("machine", "primary"),
        )
    for key, unit in (("frequency_ratios", ""), ("frequencies", "rad/s")):
        table = table_at(asked, key)
        yield from _ordered((*RESPONSE, key, "from"), table.get("from", 0), table.get("to"), unit)
    vary = asked.get("vary")
    if not isinstance(vary, dict):
        return
    given = [key for key in _VARIED if vary.get(key)]
    if len(given) != 1 and not misspelt(vary, (*RESPONSE, "vary"), *_VARIED):
        yield Problem(
            path=(*RESPONSE, "vary", *given[1:2]),
            message=f"{' and '.join(given)} cannot vary together"
            if given
            else "nothing varies in [response.absorber.vary]",
            allowed=f"one of {', '.join(_VARIED)}, with its values",
        )
    elif given and "secondaries" in machine and given != ["primary_damping"]:
        yield Problem(
            path=(*RESPONSE, "vary", given[0]),
            message=f"{given[0]} of which absorber? There are several",
            allowed="primary_damping, or a sweep over keys of the secondaries",
            also=("machine", "secondaries"),
        )


def _kinds(tuning: Data, kind: object) -> Iterator[Problem]:
    """A mean square is tuned freely; Lanchester's damper is for one response."""
    if tuning.get("norm") == "h2":
        for key, wrong in (("kind", kind != "free"), ("bounds", bool(tuning.get("bounds")))):
            if wrong:
                yield Problem(
                    path=(*TUNING, key),
                    message=f"a mean square is tuned with spring and damper both free, without "
                    f"{key}",
                    allowed=f"no {key}, or norm = 'h_infinity'",
                    also=(*TUNING, "norm"),
                )
    elif kind == "lanchester":
        for key, own in (("excitation", "force"), ("response", "displacement")):
            if tuning.get(key, own) != own:
                yield Problem(
                    path=(*TUNING, key),
                    message="Lanchester's damper is tuned for a force and the displacement",
                    found=f"{key} = {str(tuning[key])[:40]!r}",
                    allowed="kind = 'viscous', which is tuned for any of them",
                    also=(*TUNING, "kind"),
                )


def _methods(tuning: Data) -> Iterator[Problem]:
    compared = tuning.get("compare")
    others = [one for one in compared if isinstance(one, str)] if isinstance(compared, list) else []
    for place, name in enumerate(others):
        path: KeyPath = (*TUNING, "compare", place)
        if name in others[:place]:
            yield Problem(
                path=path,
                message=f"method {name!r} stands twice",
                allowed="each method once",
                also=(*TUNING, "compare", others.index(name)),
            )
        elif name in _OF_AMPLITUDES and tuning.get("norm") == "h2":
            yield Problem(
                path=path,
                message=f"the closed form {name!r} is for the largest amplitude",
                found="norm = 'h2'",
                allowed="norm = 'h_infinity', or 'warburton' beside 'h2'",
                also=(*TUNING, "norm"),
            )


def _ranges(tuning: Data) -> Iterator[Problem]:
    chart = table_at(tuning, "chart", "mass_ratio")
    yield from _ordered(
        (*TUNING, "chart", "mass_ratio", "from"), chart.get("from"), chart.get("to"), ""
    )


def _several(tuning: Data, kind: object) -> Iterator[Problem]:
    wrong = [key for key in _OF_ONE if key in tuning]
    if tuning.get("norm", "h_infinity") != "h_infinity":
        wrong.append("norm")
    if kind != "free":
        wrong.append("kind")
    if tuning.get("sensitivity") is True:
        wrong.append("sensitivity")
    for key in wrong:
        yield Problem(
            path=(*TUNING, key),
            message=f"several absorbers are tuned for the largest amplitude, without {key}",
            allowed="excitation, response, bounds, mistuning",
            hint="one absorber in [machine.secondary] has it",
            also=("machine", "secondaries"),
        )


def _ordered(
    path: KeyPath, first: object, last: object, unit: str, sign: str = "<"
) -> Iterator[Problem]:
    low, high = read_number(first, unit), read_number(last, unit)
    if low is None or high is None or low < high or (sign == "<=" and low == high):
        return
    yield Problem(
        path=path,
        message=f"{path[-2] if path[-1] == 'from' else path[-1]} goes from a lower number to a "
        "higher one",
        found=f"from {first} to {last}",
        allowed=f"from {sign} to",
    )


# ----------------------------------------------------------------------------
# Checks of form of an absorber: which tables go together, and what is asked of them.
# ----------------------------------------------------------------------------

ABSORBER = "absorber"


def check_absorber(data: Data) -> Iterator[Problem]:
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
