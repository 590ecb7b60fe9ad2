"""Orders of records: means over blocks, their scatter, and the results of both."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.measurement.signals import MeanOrders, mean_of_blocks
from vibecalc.measurement.stage import channel_names
from vibecalc.measurement.tables import Measurement
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

ROOT = "measurement/record"


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
    names = iter(channel_names(table))
    for record in table.record:
        found = record.found
        assert found is not None  # put there when the file was read
        count, blocks = len(record.channels), len(found.speeds)
        shape = (count, blocks, len(table.orders))
        values = np.array(found.real).reshape(shape) + 1j * np.array(found.imaginary).reshape(shape)
        errors = np.array(found.error).reshape(count, -1)
        lines = np.array(found.lines).reshape(count, -1)
        off = np.array(found.by_angle).reshape(count, -1)
        for place, channel in enumerate(record.channels):
            yield ChannelOrders(
                name=next(names),
                at=channel.at,
                use=channel.use,
                blocks=values[place],
                mean=_with(mean_of_blocks(values[place]), off[place]),
                error=errors[place],
                speeds=np.array(found.speeds),
                lines=lines[place],
                turns=record.turns,
                zero=found.zero * np.array(table.orders),
            )


def _with(mean: MeanOrders, off: FloatArray) -> MeanOrders:
    return MeanOrders(mean.amplitudes, np.hypot(mean.along, off), np.hypot(mean.across, off))


def emit_records(scene: Scene, table: Measurement) -> None:
    """Emit orders by channel with their uncertainty, blocks, and the spectra of the records."""
    channels = list(record_means(table))
    if not channels:
        return
    names = np.array([one.name for one in channels], dtype=object)
    orders = {"channel": names, "order": np.array(table.orders)}
    means = np.stack([one.mean.amplitudes for one in channels])
    error = np.stack([one.error for one in channels]) + 8.0 * EPSILON * np.abs(means)
    scene.emit(f"{ROOT}/acceleration", means, error, orders)
    size = np.where(np.abs(means) > 0.0, np.abs(means), 1.0)
    scene.emit(f"{ROOT}/phase", np.angle(means), np.minimum(error / size, np.pi), orders)
    along = np.stack([one.mean.along for one in channels])
    across = np.stack([one.mean.across for one in channels])
    scene.emit(f"{ROOT}/uncertainty", along, error, orders)
    zero = np.stack([one.zero for one in channels])
    off = np.minimum(np.hypot(across / size, zero), np.pi)
    scene.emit(f"{ROOT}/phase_uncertainty", off, np.minimum(error / size, np.pi), orders)
    # of records with other numbers of blocks or lines, up to the shortest
    blocks = min(len(one.speeds) for one in channels)
    axes = {"block": np.arange(1, blocks + 1)}
    speeds = np.stack([one.speeds[:blocks] for one in channels])
    scene.emit(f"{ROOT}/block_speed", speeds, 16.0 * EPSILON * speeds, {"channel": names, **axes})
    amplitudes = np.stack([one.blocks[:blocks] for one in channels])
    known = np.repeat(error[:, None], blocks, axis=1)
    at = {"channel": names, **axes, "order": orders["order"]}
    scene.emit(f"{ROOT}/block_acceleration", amplitudes, known, at)
    alike = [one for one in channels if one.turns == channels[0].turns]
    length = min(len(one.lines) for one in alike)
    lines = np.stack([one.lines[:length] for one in alike])
    line = np.arange(length) / channels[0].turns
    shown = np.array([one.name for one in alike], dtype=object)
    scene.emit(
        f"{ROOT}/spectrum", lines, float(np.max(error)), {"channel": shown, "order_line": line}
    )
    _emit_shafts(scene, table, names)
    scene.cite(
        "computed order tracking",
        "orders of records by a tachometer",
        "Fyfe and Munck, Mechanical Systems and Signal Processing 11, 1997, 187-205",
    )


#: of a speed as given, a correction that gets a sentence
_CORRECTED = 1e-4


def _emit_shafts(scene: Scene, table: Measurement, names: np.ndarray) -> None:
    """Emit what pulses scatter by and what a speed is corrected by; say what a record tells."""
    each = [(record, record.found) for record in table.record for _ in record.channels]
    axes = {"channel": names}
    for key in ("pulse_scatter", "speed_correction"):
        values = [getattr(found, key) for _, found in each]
        scene.emit(f"{ROOT}/{key}", values, 16.0 * EPSILON, axes)
    for record in table.record:
        found = record.found
        assert found is not None
        mean = float(np.mean(found.speeds)) * 30.0 / np.pi
        if abs(found.speed_correction) > _CORRECTED:
            scene.warn(
                f"{record.file}: the phases of its blocks turn evenly against the speed as given; "
                f"it is corrected by {100.0 * found.speed_correction:+.4g} %, to {mean:.6g} rpm"
            )
        late = np.degrees(np.sqrt(np.mean(np.square(found.disc_pattern))))
        if late and record.disc is None:
            scene.warn(
                f"{record.file}: its pulses have a pattern of {late:.2g} deg that repeats each "
                "turn. It is taken for that of the disc, and +- has in it what it would be as "
                "torsional vibration of the shaft: say disc = 'uneven' or 'even'"
            )
        if found.unsteady:
            scene.warn(
                f"{record.file}: {found.unsteady}, as in a run-up through a resonance: means of "
                "such blocks are no vibration at one speed; the blocks stand over their speed"
            )
