"""Checks of form of a pump: what its pressure needs."""

from collections.abc import Iterator

from vibecalc.case.kind_parts import TRAIN
from vibecalc.case.raw import Data, misspelt, read_number, table_at
from vibecalc.errors import KeyPath, Problem

CYCLE: KeyPath = (*TRAIN, "pump_cycle")


def check_kind(data: Data) -> Iterator[Problem]:
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
