"""Made-up sweeps for the tests of chunks and stacked files: values that follow from the point."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from sample_results import result_of
from sweep_samples import DAMPING, SPEED, STIFFNESS, design_of, generator, spread

from vibecalc.core.results.layout import BUG, DONE, FAILED
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.core.results.sweep_file import SweepHead, columns_of
from vibecalc.core.study.sweep.assemble import sweep_head
from vibecalc.core.study.sweep.blocks import Block, combined, one_point
from vibecalc.core.study.sweep.design import Design
from vibecalc.core.study.sweep.journal import Journal
from vibecalc.core.study.sweep.prepare import identify

SAG, FORCE, SPREAD, MASKED = "isolation/sag", "excitation/force", "impact/speed", "isolation/curve"
KEPT = (SAG, FORCE, SPREAD)
DIRECTIONS = np.array(["x", "y", "z"])


class Made(NamedTuple):
    """A sweep with the journal of its chunks and the head of its file."""

    design: Design
    head: SweepHead
    journal: Journal

    def fill(self, *numbers: int) -> None:
        """Write these chunks, by default all."""
        self.journal.look()
        self.journal.start()
        for number in numbers or range(self.journal.chunks):
            self.journal.write(number, block_at(self.journal.points(number), self.head.stored))


def grid_of(*sizes: int) -> Design:
    keys = (STIFFNESS, DAMPING, SPEED)
    ends = (("5 N/mm", "50 N/mm"), ("1 N*s/m", "20 N*s/m"), ("1000 rpm", "3000 rpm"))
    axes = [spread(key, *end, size) for key, end, size in zip(keys, ends, sizes, strict=False)]
    return design_of(*axes)


def made(folder: Path, design: Design | None = None, size: int = 5, kept: Any = KEPT) -> Made:
    design = design or grid_of(4, 3, 2)
    identity = identify(generator().resolved, design, kept)
    head = sweep_head(result_of(), design, identity, kept)
    folder.mkdir(exist_ok=True)
    journal = Journal(
        path=folder / "sweep.h5.chunks", identity=identity, count=design.count, size=size
    )
    return Made(design, head, journal)


def outcome(point: int) -> tuple[int, str]:
    """Every seventh point fails; one is a mistake with a long text."""
    if point == 10:
        return BUG, "Traceback\n  a line with é and \0 and \ud800\n"
    return (FAILED, f"order {point % 2} meets mode 1") if point % 7 == 3 else (DONE, "")


def found_at(point: int) -> dict[str, Quantity]:
    """Results of one point; the series of later points are longer."""
    if outcome(point)[0] != DONE:
        return {}
    orders = np.arange(1, 4 + point // 6)
    series = (point + 1) * np.exp(1j * np.arange(3 * orders.size)).reshape(3, -1)
    direction = Axis(name="direction", values=DIRECTIONS, long_name="axis of the machine")
    order = Axis(name="order", values=orders)
    speeds = Axis(name="speed", values=np.linspace(0.0, 1.0 + point, 4), unit="rad/s")
    quantities = (
        Quantity(path=SAG, values=np.array(0.1 * point), unit="m", long_name="sag",
                 error_estimate=1e-12 * point),
        Quantity(path=FORCE, values=series, unit="N", long_name="force", amplitude="0-pk",
                 axes=(direction, order), error_estimate=1e-9),
        Quantity(path=SPREAD, values=np.array(1.0 / (point + 1)), unit="m/s", long_name="speed",
                 standard_error=1e-3 * point),
        Quantity(path=MASKED, values=np.arange(4.0), unit="N", long_name="curve", axes=(speeds,)),
    )  # fmt: skip
    return {quantity.path: quantity for quantity in quantities}


def block_at(points: np.ndarray, kept: Any = KEPT) -> Block:
    each = [one_point(point, *outcome(point), found_at(point)) for point in points.tolist()]
    return combined(each, points, kept)


class Seen(NamedTuple):
    """One quantity at the points of a block, with what it is."""

    values: np.ndarray
    errors: np.ndarray
    unit: str
    long_name: str
    amplitude: str | None
    axes: tuple[Axis, ...]


def quantities(block: Block) -> dict[str, Seen]:
    """What a block has, by path."""
    return {
        path: Seen(*(block.columns[name] for name in columns_of(path)[:2]), one.unit,
                   one.long_name, one.amplitude, one.axes)
        for path, one in block.described.items()
    }  # fmt: skip


def expected(path: str, point: int, shape: tuple[int, ...]) -> np.ndarray:
    """What a stacked file should have at a point: zeros after the series, NaN where it failed."""
    quantity = found_at(point).get(path)
    if quantity is None:
        return np.full(shape, np.nan)
    values = np.asarray(quantity.values)
    if values.shape == shape:
        return values
    return np.pad(values, [(0, size - old) for size, old in zip(shape, values.shape, strict=True)])
