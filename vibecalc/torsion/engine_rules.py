"""Checks of form of an engine: cycle, gas and firing said once, and what its tables need."""

from collections.abc import Iterator

from vibecalc.core.case.raw import Data, either, misspelt, table_at, tables_at
from vibecalc.errors import KeyPath, Problem
from vibecalc.torsion.rules import check_shaft_line, check_torsion

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
