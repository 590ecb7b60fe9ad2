"""Rules of the tables of engines and shaft lines, before anything is built."""

from collections.abc import Iterator

from vibecalc.core.case.raw import Data, either, misspelt, read_number, table_at, tables_at
from vibecalc.errors import KeyPath, Problem

# ----------------------------------------------------------------------------
# Checks of form of a shaft line: each number said once, shafts from station to station.
# ----------------------------------------------------------------------------

LINE: KeyPath = ("machine", "shaft_line")
#: kind of damper -> keys that it needs, keys that it may have beside them
DAMPERS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "viscous": (("inertia", "damping"), ()),
    "spring": (("inertia", "stiffness"), ("damping", "loss_factor")),
    "pendulum": (("order", "mass", "arm_radius"), ("damping", "count")),
}
#: values of keys that say nothing: a resolved case holds them for every kind
_SILENT = {"loss_factor": 0.0, "count": 1, "damping": 0.0}


def check_shaft_line(data: Data) -> Iterator[Problem]:
    """Yield what stations, shafts, gears and dampers lack or say twice."""
    for place, station in tables_at(data, *map(str, LINE), "stations"):
        path: KeyPath = (*LINE, "stations", place)
        yield from _named(station, path, "station")
        yield from _one_of(station, path, "inertia", ("throw",))
        yield from either(station, path, "cylinder", ("cylinders",), needed=False)
        throw = station.get("throw")
        ends = [key for key in ("beyond_journal", "beyond_pin") if key in (throw or {})]
        if isinstance(throw, dict) and len(ends) == 1:
            yield Problem(
                path=(*path, "throw", ends[0]),
                message=f"{ends[0]} alone: a rectangular web has two ends",
                allowed="beyond_journal and beyond_pin, or neither for half discs at both ends",
            )
    shafts = tables_at(data, *map(str, LINE), "shafts")
    for place, shaft in shafts:
        path = (*LINE, "shafts", place)
        yield from _one_of(shaft, path, "stiffness", ("section", "throw"))
        yield from either(shaft, path, "damping", ("damping_ratio",), needed=False)
        yield from either(shaft, path, "diameter", ("section_modulus",), needed=False)
    said = [place for place, shaft in shafts if "between" in shaft]
    if said and len(said) < len(shafts):
        silent = next(place for place, shaft in shafts if "between" not in shaft)
        yield Problem(
            path=(*LINE, "shafts", silent),
            message="this shaft does not say between which stations it is, and others do",
            allowed="between = ['first', 'second'] for every shaft, or for none",
            also=(*LINE, "shafts", said[0], "between"),
        )
    for place, gear in tables_at(data, *map(str, LINE), "gears"):
        path = (*LINE, "gears", place)
        yield from _one_of(gear, path, "ratio", ("teeth",))
        if "mesh_stiffness" in gear and "pitch_radius" not in gear:
            yield Problem(
                path=(*path, "mesh_stiffness"),
                message="mesh_stiffness needs pitch_radius: it is along the line of action",
                allowed="pitch_radius of the first wheel beside it",
            )
    for place, damper in tables_at(data, *map(str, LINE), "dampers"):
        yield from _damper(damper, (*LINE, "dampers", place))


def _named(station: Data, path: KeyPath, what: str) -> Iterator[Problem]:
    """A station without a name is told by the schema; one of blanks alone is not."""
    name = station.get("name")
    if isinstance(name, str) and name and not name.strip():
        yield Problem(
            path=(*path, "name"),
            message=f"the {what} has a name of blanks",
            allowed="a name that can be read",
        )


def _one_of(table: Data, path: KeyPath, one: str, others: tuple[str, ...]) -> Iterator[Problem]:
    """Exactly one of these keys."""
    yield from either(table, path, one, others)
    given = [key for key in others if key in table]
    if one not in table and len(given) > 1:
        yield Problem(
            path=(*path, given[1]),
            message=f"{given[1]} and {given[0]} exclude each other",
            allowed=f"one of {', '.join((one, *others))}",
            also=(*path, given[0]),
        )


def _damper(damper: Data, path: KeyPath) -> Iterator[Problem]:
    kind = damper.get("kind")
    if not isinstance(kind, str) or kind not in DAMPERS:
        return
    needed, other = DAMPERS[kind]
    missing = [key for key in needed if key not in damper and not misspelt(damper, path, key)]
    if missing:
        yield Problem(
            path=path,
            message=f"a damper of kind {kind!r} needs {' and '.join(missing)}",
            allowed=", ".join((*needed, *other)),
            also=(*path, "kind"),
        )
    known = {key for row in DAMPERS.values() for keys in row for key in keys}
    for key in damper:
        said = key in known and damper[key] != _SILENT.get(key)
        if said and key not in (*needed, *other):
            yield Problem(
                path=(*path, key),
                message=f"a damper of kind {kind!r} has no {key}",
                allowed=", ".join((*needed, *other)),
                also=(*path, "kind"),
            )


# ----------------------------------------------------------------------------
# Checks of form of [response.torsion] and [damper_design].
# ----------------------------------------------------------------------------

TORSION: KeyPath = ("response", "torsion")
TRANSIENT: KeyPath = (*TORSION, "transient")
DESIGN: KeyPath = ("damper_design",)
_PASS = ("from", "to")
_RATES = ("acceleration", "duration")
#: kind of change -> keys that it needs; one of acceleration and duration with those of speeds
CHANGES: dict[str, tuple[str, ...]] = {
    "run_up": _PASS,
    "run_down": _PASS,
    "start": ("to",),
    "load_step": ("on", "torque"),
    "misfire_onset": ("cylinder",),
}


def check_torsion(data: Data) -> Iterator[Problem]:
    """Yield what is asked of the line twice, backwards or not wholly."""
    torsion = table_at(data, *TORSION)
    yield from _ordered(torsion.get("speeds"), (*TORSION, "speeds"))
    orders = table_at(torsion, "orders")
    yield from either(orders, (*TORSION, "orders"), "count", ("highest",), needed=False)
    step = read_number(orders.get("step"), "")
    if step is not None and step > 0.0 and step not in (0.5, 1.0):
        yield Problem(
            path=(*TORSION, "orders", "step"),
            message="an engine excites half orders and whole orders, no others",
            found=f"step = {step:g}",
            allowed="0.5 or 1",
        )
    onset = table_at(torsion, "transient").get("kind") == "misfire_onset"
    if torsion.get("misfire_kind") == "motored" and not torsion.get("misfire") and not onset:
        yield Problem(
            path=(*TORSION, "misfire_kind"),
            message="misfire_kind says how cylinders misfire, and none does",
            allowed="misfire = ['1'], for example, beside it",
        )
    for place, limit in tables_at(data, *map(str, TORSION), "limits"):
        path: KeyPath = (*TORSION, "limits", place)
        yield from either(limit, path, "rule", ("curve",))
        for key in ("tensile_strength", "design_factor"):
            said = limit.get(key, 1.0) != 1.0  # a resolved case holds the default of the factor
            if said and "curve" in limit and "rule" not in limit:
                yield Problem(
                    path=(*path, key),
                    message=f"{key} is of a rule, and the curve says the stress itself",
                    allowed=f"no {key}, or a rule instead of the curve",
                    also=(*path, "curve"),
                )
    damping = torsion.get("damping_model")
    if isinstance(damping, dict):
        yield from _damping(damping, (*TORSION, "damping_model"))
    change = torsion.get("transient")
    if isinstance(change, dict):
        yield from _transient(change)
    design = data.get("damper_design")
    if isinstance(design, dict):
        yield from _ordered(design.get("speeds"), (*DESIGN, "speeds"))
        if "speeds" not in design and "speeds" not in torsion:
            yield Problem(
                path=DESIGN,
                message="[damper_design] does not say over which speeds",
                allowed="speeds = { from = '300 rpm', to = '900 rpm' } here or in "
                "[response.torsion]",
            )


def _ordered(speeds: object, path: KeyPath) -> Iterator[Problem]:
    if not isinstance(speeds, dict):
        return
    low, high = (read_number(speeds.get(key), "rad/s") for key in _PASS)
    if low is not None and high is not None and not low < high:
        yield Problem(
            path=(*path, "from"),
            message="speeds go from a lower one to a higher one",
            found=f"from {str(speeds['from'])[:40]} to {str(speeds['to'])[:40]}",
            allowed="from < to",
        )


def _damping(damping: Data, path: KeyPath) -> Iterator[Problem]:
    modes, ratios = damping.get("modes"), damping.get("ratios")
    if damping.get("kind") == "rayleigh":
        sized = isinstance(modes, list) and len(modes) == 2 and modes[0] != modes[1]
        if not sized or (isinstance(ratios, list) and len(ratios) not in (1, 2)):
            yield Problem(
                path=path,
                message="Rayleigh damping goes through the ratios of two modes",
                allowed="modes = [2, 3] and ratios = [0.01, 0.01], for example",
            )
        elif isinstance(modes, list) and 1 in modes:
            yield Problem(
                path=(*path, "modes", modes.index(1)),
                message="mode 1 is the rigid one, and has no damping ratio",
                allowed="two elastic modes, from 2",
            )
    elif damping.get("kind") == "modal" and "modes" in damping:
        yield Problem(
            path=(*path, "modes"),
            message="modes are for Rayleigh damping: modal ratios are those of all modes in turn",
            allowed="no modes, or kind = 'rayleigh'",
            also=(*path, "kind"),
        )


def _transient(change: Data) -> Iterator[Problem]:
    kind = change.get("kind")
    if not isinstance(kind, str) or kind not in CHANGES:
        return
    needed = CHANGES[kind]
    rates = _RATES if "to" in needed else ()
    for key in needed:
        if key not in change:
            yield Problem(
                path=TRANSIENT,
                message=f"a change of kind {kind!r} needs {key}",
                allowed=", ".join((*needed, *rates)),
                also=(*TRANSIENT, "kind"),
            )
    if rates:
        yield from either(change, TRANSIENT, rates[0], rates[1:])
    known = {key for keys in CHANGES.values() for key in keys} | set(_RATES)
    for key in change:
        if key in known and key not in (*needed, *rates):
            yield Problem(
                path=(*TRANSIENT, key),
                message=f"a change of kind {kind!r} has no {key}",
                allowed=", ".join((*needed, *rates)) or "no such key",
                also=(*TRANSIENT, "kind"),
            )
    low, high = (read_number(change.get(key), "rad/s") for key in _PASS)
    if kind in ("run_up", "run_down") and low is not None and high is not None:
        right = low < high if kind == "run_up" else low > high
        if not right:
            yield Problem(
                path=(*TRANSIENT, "from"),
                message=f"a {kind.replace('_', '-')} goes from a "
                + (
                    "lower speed to a higher one"
                    if kind == "run_up"
                    else "higher speed to a lower one"
                ),
                found=f"from {str(change['from'])[:40]} to {str(change['to'])[:40]}",
                allowed="from < to" if kind == "run_up" else "from > to",
            )


# ----------------------------------------------------------------------------
# Checks of form of an engine: cycle, gas and firing said once, and what its tables need.
# ----------------------------------------------------------------------------

MACHINE: KeyPath = ("machine",)
TRAIN: KeyPath = ("machine", "crank_train")
ASKED: tuple[KeyPath, ...] = (("response", "torsion"), ("damper_design",))
GAS = ("gas_pressure", "gas_cards", "gas_cycle")


def check_engine(data: Data) -> Iterator[Problem]:
    """Yield what an engine lacks or says twice."""
    machine = table_at(data, "machine")
    if "cycle" not in machine and not misspelt(machine, MACHINE, "cycle"):
        from vibecalc.core.case.diagnose import missing_key

        yield missing_key((*MACHINE, "cycle"))
    asked = [path for path in ASKED if path[-1] in table_at(data, *path[:-1])]
    for path in asked:
        if "shaft_line" not in machine and not misspelt(machine, MACHINE, "shaft_line"):
            yield Problem(
                path=path,
                message=f"[{'.'.join(map(str, path))}] needs [machine.shaft_line]",
                allowed="stations and shafts of the line",
            )
    if "rotor" in machine and "shaft_line" in machine:
        yield Problem(
            path=(*MACHINE, "rotor"),
            message="what turns with the crankshaft stands twice: [machine.rotor] and "
            "[machine.shaft_line]",
            allowed="one of them; the stations of the line have inertias of their own",
            also=(*MACHINE, "shaft_line"),
        )
    train = table_at(data, *TRAIN)
    if train:
        yield from _gas(data, train, bool(asked))
        yield from _firing(data, machine, train, bool(asked))
    yield from check_shaft_line(data)
    yield from check_torsion(data)


def _gas(data: Data, train: Data, needed: bool) -> Iterator[Problem]:
    """The gas in one of three ways, with the bore that makes a force of it."""
    given = [key for key in GAS if train.get(key)]
    for key in given[1:]:
        yield Problem(
            path=(*TRAIN, key),
            message=f"{key} and {given[0]} exclude each other",
            allowed=f"one of {', '.join(GAS)}",
            also=(*TRAIN, given[0]),
        )
    if needed and not given and not misspelt(train, TRAIN, *GAS):
        yield Problem(
            path=TRAIN,
            message=f"[machine.crank_train] has neither {', '.join(GAS[:-1])} nor {GAS[-1]}",
            allowed="one of them: a table over the cycle, several over the speed, or a computed "
            "cycle",
            hint="no gas at all is pressure_scale = 0 for each cylinder",
        )
    if given and "bore" not in train and not misspelt(train, TRAIN, "bore"):
        yield Problem(
            path=(*TRAIN, given[0]),
            message=f"{given[0]} needs the bore: the gas force is pressure times area",
            allowed="bore in [machine.crank_train]",
        )
    for place, cylinder in tables_at(data, *map(str, (*TRAIN, "cylinders"))):
        if "gas_force" in cylinder:
            yield Problem(
                path=(*TRAIN, "cylinders", place, "gas_force"),
                message="gas_force is over one turn, an engine's gas over its cycle",
                allowed=f"one of {', '.join(GAS)} in [machine.crank_train], with a pressure_scale "
                "for this cylinder",
                also=(*MACHINE, "kind"),
            )
    cycle = train.get("gas_cycle")
    if isinstance(cycle, dict):
        ways = ("peak_pressure", "mean_indicated_pressure")
        path = (*TRAIN, "gas_cycle")
        yield from either(cycle, path, ways[0], ways[1:])
        if "injection_ends" in cycle and cycle.get("kind") == "spark":
            yield Problem(
                path=(*path, "injection_ends"),
                message="injection_ends is of a diesel, and this cycle has a spark",
                allowed="no injection_ends, or kind = 'diesel'",
                also=(*path, "kind"),
            )


def _firing(data: Data, machine: Data, train: Data, needed: bool) -> Iterator[Problem]:
    """When each cylinder fires, in one of two ways."""
    cylinders = tables_at(data, *map(str, (*TRAIN, "cylinders")))
    own = [place for place, cylinder in cylinders if "firing_angle" in cylinder]
    place_of: KeyPath = (*TRAIN, "cylinders")
    if "firing_order" in train and own:
        yield Problem(
            path=(*place_of, own[0], "firing_angle"),
            message="firing_angle and firing_order exclude each other",
            allowed="firing_order, or a firing_angle for every cylinder",
            also=(*TRAIN, "firing_order"),
        )
    elif own:
        for place, cylinder in cylinders:
            if place not in own:
                yield Problem(
                    path=(*place_of, place),
                    message=f"cylinder {str(cylinder.get('name', place + 1))[:60]!r} has no "
                    "firing_angle, and others have one",
                    allowed="a firing_angle for every cylinder, or firing_order",
                    also=(*place_of, own[0], "firing_angle"),
                )
    elif (
        needed
        and not train.get("firing_order")
        and machine.get("cycle") == "four_stroke"  # in two strokes the throws say it
        and len(cylinders) > 1
        and not misspelt(train, TRAIN, "firing_order")
        and not any(misspelt(one, (*place_of, at), "firing_angle") for at, one in cylinders)
    ):
        yield Problem(
            path=TRAIN,
            message="[machine.crank_train] does not say when its cylinders fire",
            allowed="firing_order = ['1', '3', '4', '2'], or a firing_angle for every cylinder",
            hint="a throw passes its top dead centre twice in four strokes and fires once",
        )
    if "firing_intervals" in train and "firing_order" not in train:
        yield Problem(
            path=(*TRAIN, "firing_intervals"),
            message="firing_intervals go with firing_order",
            allowed="firing_order beside them",
        )
