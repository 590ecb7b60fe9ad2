"""Orders of records: means over blocks, their scatter, and the results of both."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.measurement import results
from vibecalc.measurement.signals import MeanOrders, mean_of_blocks, shortened
from vibecalc.measurement.tables import Measurement
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray


class ChannelOrders(NamedTuple):
    """Harmonics of one channel: blocks (b, n), their mean, what interpolation makes of it (n,).

    The uncertainty of the mean has scatter of blocks and of the angle in it; `zero` (n,) is what
    phases are unsure of together, rad. `speeds` (b,) in rad/s; `lines` (l,) are root mean square
    amplitudes of the orders 0, 1 / turns, 2 / turns, ...
    """

    name: str
    at: str
    use: str
    blocks: ComplexArray
    mean: MeanOrders
    error: FloatArray
    speeds: FloatArray
    lines: FloatArray
    turns: int
    zero: FloatArray


def record_means(table: Measurement) -> Iterator[ChannelOrders]:
    """Each channel of each record."""
    names = iter(table.channel_names)
    for record in table.record:
        found = record.found
        assert found is not None  # put there when the file was read
        count, blocks = len(record.channels), len(found.speeds)
        shape = (count, blocks, len(table.orders))
        values = np.array(found.real).reshape(shape) + 1j * np.array(found.imaginary).reshape(shape)
        errors = np.array(found.error).reshape(count, -1)
        lines = np.array(found.lines).reshape(count, -1)
        off = np.array(found.by_angle).reshape(count, -1)
        orders, scatter = np.array(table.orders), found.pulse_scatter * (record.disc == "even")
        for place, channel in enumerate(record.channels):
            yield ChannelOrders(
                name=next(names),
                at=channel.at,
                use=channel.use,
                blocks=values[place],
                mean=_with(mean_of_blocks(values[place]), off[place], orders, scatter),
                error=errors[place],
                speeds=np.array(found.speeds),
                lines=lines[place],
                turns=record.turns,
                zero=found.zero * np.array(table.orders),
            )


def _with(mean: MeanOrders, off: FloatArray, orders: FloatArray, scatter: float) -> MeanOrders:
    along = np.hypot(mean.along, np.hypot(off, shortened(mean.amplitudes, orders, scatter)))
    return MeanOrders(mean.amplitudes, along, np.hypot(mean.across, off))


def emit_records(scene: Scene, table: Measurement) -> None:
    """Emit orders by channel with their uncertainty, blocks, and the spectra of the records."""
    channels = list(record_means(table))
    if not channels:
        return
    zero = np.stack([one.zero for one in channels])
    means, along, across = (
        np.stack([getattr(one.mean, key) for one in channels])
        for key in ("amplitudes", "along", "across")
    )
    error = np.stack([one.error for one in channels]) + 8.0 * EPSILON * np.abs(means)
    size = np.where(np.abs(means) > 0.0, np.abs(means), 1.0)
    turn = np.minimum(error / size, np.pi)
    # of records with other numbers of blocks or lines, up to the shortest
    blocks = min(len(one.speeds) for one in channels)
    speeds = np.stack([one.speeds[:blocks] for one in channels])
    amplitudes = np.stack([one.blocks[:blocks] for one in channels])
    shafts = [record.found for record in table.record for _ in record.channels]
    scatter, correction = (
        np.array([getattr(found, key) for found in shafts])
        for key in ("pulse_scatter", "speed_correction")
    )
    group = results.Records(
        acceleration=Bounded(means, error),
        phase=Bounded(np.angle(means), turn),
        uncertainty=Bounded(along, error),
        phase_uncertainty=Bounded(np.minimum(np.hypot(across / size, zero), np.pi), turn),
        pulse_scatter=Bounded(scatter, np.array(16.0 * EPSILON)),
        speed_correction=Bounded(correction, np.array(16.0 * EPSILON)),
        block_speed=rounded(speeds, 32.0),
        block_acceleration=Bounded(amplitudes, np.repeat(error[:, None], blocks, axis=1)),
    )
    names = np.array([one.name for one in channels], dtype=object)
    orders, block = np.array(table.orders), np.arange(1, blocks + 1)
    scene.emit_all(group, {"channel": names, "order": orders, "block": block})
    alike = [one for one in channels if one.turns == channels[0].turns]
    length = min(len(one.lines) for one in alike)
    spectrum = np.stack([one.lines[:length] for one in alike])
    axes = {
        "channel": np.array([one.name for one in alike], dtype=object),
        "order_line": np.arange(length) / channels[0].turns,
    }
    scene.emit_all(results.Records(spectrum=Bounded(spectrum, np.max(error))), axes)
    _warn(scene, table)
    scene.cite(
        "computed order tracking",
        "orders of records by a tachometer",
        "Fyfe and Munck, Mechanical Systems and Signal Processing 11, 1997, 187-205",
    )


#: of a speed as given, a correction that gets a sentence
_CORRECTED = 1e-4


def _warn(scene: Scene, table: Measurement) -> None:
    """Say what records tell of their shafts."""
    for record in table.record:
        found = record.found
        assert found is not None
        mean = float(np.mean(found.speeds)) * 30.0 / np.pi
        if abs(found.speed_correction) > _CORRECTED:
            scene.warn(
                f"{record.file}: the phases of its blocks drift steadily at the given speed, "
                f"which is corrected by {100.0 * found.speed_correction:+.4g} %, to {mean:.6g} rpm"
            )
        late = np.degrees(np.sqrt(np.mean(np.square(found.disc_pattern))))
        if late and record.disc is None:
            scene.warn(
                f"{record.file}: its pulses have a pattern of {late:.2g} deg that repeats each "
                "turn. It is ascribed to the disc; +- includes its effect as torsional vibration "
                "of the shaft: set disc = 'uneven' or 'even'"
            )
        if found.unsteady:
            scene.warn(
                f"{record.file}: {found.unsteady}, as in a run-up through a resonance: means of "
                "such blocks are no vibration at one speed; see the blocks against their speed"
            )
