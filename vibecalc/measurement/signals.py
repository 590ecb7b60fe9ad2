"""Orders of a signal in time: pulses of a tachometer, the angle, equal angles, blocks of turns.

A record is resampled at equal angles of the shaft (computed order tracking: Fyfe and Munck,
Mechanical Systems and Signal Processing 11, 1997, 187-205), and blocks of whole turns are
transformed. Amplitudes are 0-to-peak, a signal is the real part of A exp(i n theta) with theta = 0
at the first pulse, so that a positive phase leads.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# Pulses of a tachometer, and the time at each angle.
# ----------------------------------------------------------------------------

_TURN = 2.0 * np.pi


class Pulses(NamedTuple):
    """Times (k,) of pulses; those of the samples before and after; whether the wave is square."""

    times: FloatArray
    before: FloatArray
    after: FloatArray
    square: bool

    @property
    def sampling(self) -> float:
        """Standard uncertainty of a time by sampling alone, s: a jump may be anywhere between."""
        return float(np.mean(self.after - self.before)) / 12.0**0.5 if self.square else 0.0


#: of the range of a signal, a rise between two samples from which on it is a jump
_JUMP = 0.7


def pulses_of(times: FloatArray, signal: FloatArray, threshold: float, hysteresis: float) -> Pulses:
    """Where a signal (n,) rises through a threshold, on the straight line between two samples.

    The edge of a square wave may be anywhere between them: it is taken halfway, wherever the
    threshold lies.
    It counts again after it has been at or below the threshold less the hysteresis, so that noise
    on an edge makes no second pulse.
    """
    above, below = signal >= threshold, signal <= threshold - hysteresis
    above &= ~below
    place = np.arange(signal.size)
    # the last sample at which it was surely on either side
    seen = np.maximum.accumulate(np.where(above | below, place, -1))
    state = np.where(seen >= 0, above[np.maximum(seen, 0)], True)
    rises = 1 + np.flatnonzero(state[1:] & ~state[:-1])
    low, high = signal[rises - 1], signal[rises]
    before, after = times[rises - 1], times[rises]
    found = before + (threshold - low) / (high - low) * (after - before)
    jumps = high - low > _JUMP * np.ptp(signal)
    square = bool(np.mean(jumps) > 0.5) if rises.size else False
    if square:
        found = np.where(jumps, 0.5 * (before + after), found)
    return Pulses(found, before, after, square)


class Shaft(NamedTuple):
    """Times (k,) of a shaft at angles (k,) that rise, rad; a cubic spline joins them.

    Standard uncertainties in rad: `zero` of where the angle is zero, `wander` of what is left about
    it (root mean square), `scatter` of one pulse. `late` (p,) is by how much each pulse of a disc
    comes late, which repeats each turn; zeros where that is not seen. Of an even disc `scatter` is
    in the angle within each turn, see `shortened`, and `torsion` (root mean square) is what
    sampling may have made of its pattern.
    """

    angles: FloatArray
    times: FloatArray
    zero: float = 0.0
    wander: float = 0.0
    scatter: float = 0.0
    late: FloatArray = np.zeros(1)
    torsion: float = 0.0

    @property
    def start(self) -> float:
        """The first angle of whole turns from zero, rad."""
        return float(_TURN * np.ceil(self.angles[0] / _TURN - 1e-9))

    @property
    def turns(self) -> int:
        """Whole turns from there on."""
        return int(np.floor((self.angles[-1] - self.start) / _TURN * (1.0 + 1e-12)))

    def at(self, angles: FloatArray) -> FloatArray:
        """Times at angles, s."""
        from scipy.interpolate import CubicSpline

        return np.asarray(CubicSpline(self.angles, self.times)(angles))


def shaft_of_pulses(pulses: Pulses, per_turn: int, even: bool = False) -> Shaft:
    """The shaft of a tachometer; the angle is zero at the first pulse.

    The time of pulse k of a disc with p pulses is T(2 pi k / p) + T' d_j + e: T a smooth spline of
    as many pieces as the pulses ask for (AICc, Hurvich and Tsai, Biometrika 76, 1989, 297-307), d
    the pattern of the disc, j = k mod p, e what a pulse scatters by. Of a disc that is said to be
    `even` each pulse counts as it came, with all that it scatters by, and a pattern is motion of
    the shaft, up to what sampling may have made of it. Where pulses of a square wave show nothing
    but their sampling at a constant speed, that speed counts.
    """
    times, count = pulses.times, pulses.times.size
    angles = _TURN * np.arange(count) / per_turn
    rate = (angles[-1] - angles[0]) / (times[-1] - times[0])
    if count < 2 * per_turn + 8:
        off = rate * pulses.sampling
        return Shaft(angles, times, off / count**0.5, off, off, np.zeros(per_turn))
    if even and pulses.square and (steady := _at_constant_speed(pulses, angles)) is not None:
        off = rate * steady.room
        return Shaft(angles, steady.times, off / 3.0**0.5, off, 0.0, np.zeros(per_turn))
    fit = min(_fits(pulses, angles, per_turn), key=lambda one: one.criterion)
    spread, late = rate * fit.deviation, rate * fit.late
    if spread < _CLEAN and not np.any(np.abs(late) > _CLEAN):
        return Shaft(angles, times, spread / count**0.5, spread, spread, np.zeros(per_turn))
    zero = spread**2 * (per_turn if np.any(late) and not even else 1) / count
    # the jumps of a square wave all lie between their samples: so far can all move together
    low, high = np.max(pulses.before - fit.pulses), np.min(pulses.after - fit.pulses)
    shift = 0.0
    if pulses.square and low < high:
        shift, zero = 0.5 * (low + high), 0.25 * zero + (rate * (high - low)) ** 2 / 12.0
    if even:
        spread = rate * _scatter_of_each(pulses, fit)
        return Shaft(
            angles, times + shift, zero**0.5, spread, spread, np.zeros(per_turn),
            rate * _sampled_pattern(pulses, fit, per_turn),
        )  # fmt: skip
    wander = spread * ((fit.unknowns - 1.0) / count) ** 0.5
    return Shaft(angles - late[0], fit.smooth + shift, zero**0.5, wander, spread, late)


class _Steady(NamedTuple):
    """Times (k,) of a constant speed, s, and how far all pulses may be off it alike, s."""

    times: FloatArray
    room: float


def _at_constant_speed(pulses: Pulses, angles: FloatArray) -> _Steady | None:
    """The constant speed that lies between the samples of all jumps, None if there is none.

    Where there is one the pulses show nothing but their sampling, which at a constant speed repeats
    from turn to turn and would count as torsion of the shaft in every block alike. It is the line
    as far as can be from all of these samples, by a linear program.
    """
    from scipy.optimize import linprog

    line = np.stack([np.ones(angles.size), np.linspace(-1.0, 1.0, angles.size)], axis=1)
    straight = line @ np.linalg.lstsq(line, pulses.times, rcond=None)[0]
    width = float(np.max(pulses.after - pulses.before))
    above, below = ((one - straight) / width for one in (pulses.before, pulses.after))
    room = np.ones((angles.size, 1))
    found = linprog(
        [0.0, 0.0, -1.0],
        A_ub=np.block([[-line, room], [line, room]]),
        b_ub=np.concatenate([-above, below]),
        bounds=(None, None),
    )
    if found.status != 0 or found.x[2] <= 0.0:
        return None
    return _Steady(straight + width * (line @ found.x[:2]), width * float(found.x[2]))


def _scatter_of_each(pulses: Pulses, fit: "_Fit") -> float:
    """What one pulse of an even disc is off by, s: what is neither smooth motion nor repeats.

    Of what repeats, sampling may have made as much as it can be off by: at a constant speed each
    turn is sampled alike.
    """
    left = float(np.sum((pulses.times - fit.pulses) ** 2))
    apart = (left / (pulses.times.size - fit.unknowns)) ** 0.5
    repeated = float(np.sqrt(np.mean(fit.late**2)))
    return max(float(apart), min(pulses.sampling, float(np.hypot(apart, repeated))))


#: standard deviations of a mean over the turns up to which a pattern is one by chance
_BY_CHANCE = 1.5


def _sampled_pattern(pulses: Pulses, fit: "_Fit", per_turn: int) -> float:
    """Root mean square in s of what sampling may have made of the pattern of an even disc.

    At a constant speed each turn is sampled alike: what the pulses are off by then is the same in
    every block, whose scatter does not show it. What chance leaves of the mean over the turns is
    none: the blocks scatter by it.
    """
    apart = pulses.times - fit.smooth
    pattern = np.array([np.mean(apart[place::per_turn]) for place in range(per_turn)])
    repeated, turns = float(np.std(pattern)), apart.size / per_turn
    by_chance = _BY_CHANCE * float(np.std(apart)) / turns**0.5
    return min(pulses.sampling, repeated) if repeated > by_chance else 0.0


#: rad; pulses that scatter by less count as they came
_CLEAN = 1e-6


class _Fit(NamedTuple):
    """Smooth times (k,) and those with the pattern (k,); the pattern (p,) in s; what is left."""

    criterion: float
    smooth: FloatArray
    pulses: FloatArray
    late: FloatArray
    deviation: float
    unknowns: int


def _fits(pulses: Pulses, angles: FloatArray, per_turn: int) -> Iterator[_Fit]:
    """Least squares of the times for more and more pieces, without and with a pattern."""
    from scipy.interpolate import BSpline
    from scipy.sparse.linalg import splu

    times, count = pulses.times, pulses.times.size
    floor = max(pulses.sampling, 4.0 * EPSILON * float(np.max(np.abs(times))))
    # the speed about a pulse, over that of all of them
    turn = times[2 * per_turn :] - times[: -2 * per_turn]
    slope = np.pad(turn, per_turn, mode="edge") / np.mean(turn)
    own = np.eye(per_turn)[np.arange(count) % per_turn]
    columns = slope[:, None] * (own[:, 1:] - own[:, :1])
    pieces = 1
    while 2 * (pieces + 3 + per_turn) < count:
        inner = np.linspace(angles[0], angles[-1], pieces + 1)
        knots = np.concatenate([[inner[0]] * 3, inner, [inner[-1]] * 3])
        basis = BSpline.design_matrix(angles, knots, 3)
        normal = splu((basis.T @ basis).tocsc())

        def smoothed(values: FloatArray) -> FloatArray:
            found = np.zeros_like(values)
            for _ in range(2):  # the second takes away what the first has rounded
                found += basis @ normal.solve(basis.T @ (values - found))  # noqa: B023
            return found

        plain, rest = smoothed(times), columns - smoothed(columns)
        for uneven in (False, True)[:per_turn]:
            late, smooth = np.zeros(per_turn), plain
            if uneven:
                share = np.linalg.lstsq(rest, times - plain, rcond=None)[0]
                late[1:], late[0] = share, -share.sum()
                smooth = smoothed(times - columns @ share)
            whole = smooth + columns @ late[1:]
            unknowns = pieces + 3 + uneven * (per_turn - 1)
            left = float(np.sum((times - whole) ** 2))
            spread = max(left / count, floor**2)
            criterion = np.log(spread) + 2.0 * unknowns / (count - unknowns - 1.0)
            deviation = max(left / (count - unknowns), floor**2) ** 0.5
            yield _Fit(criterion, smooth, whole, late, deviation, unknowns)
        pieces *= 2


def rate_of(shaft: Shaft) -> float:
    """Mean speed, rad/s."""
    return float((shaft.angles[-1] - shaft.angles[0]) / (shaft.times[-1] - shaft.times[0]))


def shaft_of_speed(times: FloatArray, speed: FloatArray) -> Shaft:
    """The shaft of a speed > 0 (n,) in rad/s over time; the angle is zero at the first sample."""
    from scipy.interpolate import CubicSpline

    angle = CubicSpline(times, speed).antiderivative()
    return Shaft(np.asarray(angle(times)), times)


def uneven_pulse(times: FloatArray, per_turn: int = 1) -> int | None:
    """The first of the intervals between pulses that makes its turn unlike the one before.

    A pulse that was missed, or one too many, makes a turn longer or shorter by one of `per_turn`
    parts; None where none did.
    """
    turn = times[per_turn:] - times[:-per_turn]
    ratio = turn[1:] / turn[:-1]
    most = 1.0 + _ODD / per_turn
    odd = np.flatnonzero((ratio > most) | (ratio < 1.0 / most))
    return int(odd[0]) + per_turn if odd.size else None


#: of a part of a turn, what a turn may be longer than the one before it, of a shaft that turns
_ODD = 0.6

# ----------------------------------------------------------------------------
# Signals at equal angles, and the orders of blocks of whole turns.
# ----------------------------------------------------------------------------


class OrderBlocks(NamedTuple):
    """Complex amplitudes (..., blocks, lines) of the orders `lines` / turns, and the speeds.

    `error` (..., blocks, lines) is how far they change where splines of the next lower degree stand
    for the signals; `speeds` (blocks,) in rad/s are means over the turns of a block.
    """

    amplitudes: ComplexArray
    error: FloatArray
    speeds: FloatArray


def samples_per_turn(rate: float, shaft: Shaft) -> int:
    """Equal angles per turn that keep all that the samples have, a power of two."""
    slowest = _TURN * float(np.max(np.diff(shaft.times) / np.diff(shaft.angles)))
    return int(2 ** np.ceil(np.log2(max(rate * slowest, 8.0))))


def amplitudes_of_blocks(
    samples: FloatArray, per_turn: int, turns: int, lines: int, window: str
) -> ComplexArray:
    """Orders (..., blocks, lines + 1) of samples (..., n) at equal angles, n whole blocks of turns.

    Line j is the order j / turns. With a window of Hann each line has half of its neighbours in it.
    """
    size = per_turn * turns
    blocks = samples.reshape(*samples.shape[:-1], -1, size)
    weights = np.ones(size)
    if window == "hann":
        weights = 1.0 - np.cos(_TURN * np.arange(size) / size)
    found = np.fft.rfft(blocks * (weights / size))[..., : lines + 1]
    return np.asarray(np.where(np.arange(lines + 1) > 0, 2.0, 1.0) * found)


class Tracked(NamedTuple):
    """Orders of a record by block, and the shaft whose angle they are of.

    `by_angle` (c, o) is the standard uncertainty of orders asked for by an angle that is off, in
    the unit of the signals; `unsteady` says how phasors do not stand still, and `runs` whether the
    speed changes so much that they may.
    """

    blocks: OrderBlocks
    shaft: Shaft
    by_angle: FloatArray
    unsteady: str
    runs: bool


#: of its mean, what a speed changes by in a run-up, whose phasors may turn
_RUNS = 0.05


class Recording:
    """Signals (c, n) sampled at times (n,), and how orders are made of them.

    Blocks have so many turns; `lines` + 1 lines of orders 0, 1 / turns, 2 / turns ... are kept.
    Between samples stand splines of an odd degree, and of the next lower one for the error.
    """

    def __init__(
        self,
        times: FloatArray,
        signals: FloatArray,
        turns: int,
        lines: int,
        window: str = "none",
        degree: int = 5,
    ):
        from scipy.interpolate import make_interp_spline

        self.times, self.turns, self.lines, self.window = times, turns, lines, window
        degrees = (degree, max(degree - 2, 1))
        self.splines = [make_interp_spline(times, signals.T, one) for one in degrees]

    def tracked(self, shaft: Shaft, orders: FloatArray, given: bool, torsion: float) -> "Tracked":
        """Blocks for the angle at which some orders stand still, where the shaft is steady.

        A speed as `given` has no pulses; `torsion` (rad, root mean square) is what neither shows.
        """
        speeds = self.blocks(shaft).speeds
        runs = float(np.ptp(speeds)) > _RUNS * float(np.mean(speeds))
        if not (given and runs):
            shaft = self.settled(shaft, orders, given=given)
        found, at = self.blocks(shaft), np.rint(orders * self.turns).astype(int)
        phasors = np.moveaxis(found.amplitudes[..., at], 1, 0)
        words = unsteadiness(phasors, orders)
        every = np.arange(self.lines + 1) / self.turns
        if phasors[0].size > 1 and not runs:
            # what all phasors of a block turn by is no scatter of one against another
            turn, _ = common_turn(phasors, orders)
            zero = float(np.hypot(shaft.zero, _of_mean(turn - turn.mean())))
            # pulses that are all off alike leave the shaft as steady as the signals show it
            shaft = shaft._replace(zero=zero, wander=min(shaft.wander, float(np.std(turn))))
            turned = found.amplitudes * np.exp(-1j * np.multiply.outer(turn - turn.mean(), every))
            found = found._replace(amplitudes=turned)
        torsion = float(np.hypot(torsion, shaft.torsion))
        off = by_angle(np.mean(found.amplitudes, axis=1), every, shaft.wander, torsion)
        return Tracked(found, shaft, off[..., at], words, runs)

    def settled(self, shaft: Shaft, orders: FloatArray, *, given: bool) -> Shaft:
        """The shaft with the angle at which the phasors of some orders stand still.

        A speed as given is corrected by how they turn, and pulses as far as what they scatter by
        lets them be off.
        """
        for look in range(0 if given else _LOOKS, 2 * _LOOKS):
            phasors = self.phasors(shaft, orders)
            if look < _LOOKS:
                bend = np.array([coarse_turn(phasors, orders) * len(phasors), 0.0])
            else:
                bend = _straight_and_bent(common_turn(phasors, orders)[0])
                if not given and np.hypot(*bend) > _ROOM * shaft.wander:
                    break
            angles = _moved(shaft.angles, bend)
            # a speed has no mark: its angle begins with the record
            shaft = shaft._replace(angles=angles - angles[0] if given else angles)
        return shaft

    def phasors(self, shaft: Shaft, orders: FloatArray) -> ComplexArray:
        """Amplitudes (b, c, m) of some orders."""
        lines = np.rint(orders * self.turns).astype(int)
        return np.moveaxis(self.blocks(shaft, 1).amplitudes[..., lines], 1, 0)

    def blocks(self, shaft: Shaft, splines: int = 2) -> OrderBlocks:
        """Orders block by block; the samples have to go on over all angles of the shaft.

        Of one of the `splines` no error is known.
        """
        rate = (self.times.size - 1) / (self.times[-1] - self.times[0])
        per_turn, turns = samples_per_turn(rate, shaft), self.turns
        while per_turn * turns < 4 * self.lines:
            per_turn *= 2
        count = shaft.turns // turns * turns * per_turn
        at = shaft.at(shaft.start + _TURN * np.arange(count + 1) / per_turn)
        found = [
            amplitudes_of_blocks(
                np.moveaxis(spline(at[:-1]), 0, -1), per_turn, turns, self.lines, self.window
            )
            for spline in self.splines[:splines]
        ]
        ends = at[:: per_turn * turns]
        return OrderBlocks(found[0], np.abs(found[0] - found[-1]), _TURN * turns / np.diff(ends))


# ----------------------------------------------------------------------------
# Phasors that stand still: an angle that runs ahead turns order n by n times as much.
# ----------------------------------------------------------------------------

#: how often the angle is corrected, coarsely and finely; how far pulses may be, over their wander
_LOOKS, _ROOM = 3, 17.0
#: rad of the highest order, and standard deviations, from which on a turn against pulses is one
_TURNED, _SURE = 0.3, 6.0


def coarse_turn(blocks: ComplexArray, orders: FloatArray) -> float:
    """Angle by which phasors (b, c, m) turn from block to block, of the best sum of products."""
    product = np.sum(blocks[1:] * blocks[:-1].conj(), axis=(0, 1))
    span, least = np.pi / np.min(orders), np.max(orders) / np.min(orders)
    tried = np.linspace(-span, span, 2 * int(20.0 * least) + 1)
    turned = product * np.exp(-1j * np.outer(tried, orders))
    return float(tried[np.argmax(turned.real.sum(axis=1))])


def common_turn(blocks: ComplexArray, orders: FloatArray) -> tuple[FloatArray, float]:
    """Angle (b,) by which phasors (b, c, m) are ahead of their mean, and what one may be off by.

    Phases are weighted by what each scatters by from block to block, which a slow turn leaves as it
    is.
    """
    mean = blocks.mean(axis=0)
    size = orders * np.abs(mean)
    across = (blocks * np.exp(-1j * np.angle(mean))).imag
    noise = np.mean(np.abs(np.diff(blocks, axis=0)) ** 2, axis=0) / 4.0
    noise += (EPSILON * np.max(np.abs(mean))) ** 2
    weight = size**2 / noise
    turn = np.sum(size * across / noise, axis=(1, 2)) / np.sum(weight)
    return turn, float(np.sum(weight) ** -0.5)


def _straight_and_bent(turn: FloatArray) -> FloatArray:
    """Parts of a turn (b,) over the record that go with x and x^2, x = -1/2 to 1/2."""
    x = (np.arange(turn.size) + 0.5) / turn.size - 0.5
    powers = np.stack([np.ones_like(x), x, x**2], axis=1)[:, : min(3, turn.size)]
    found = np.linalg.lstsq(powers, turn, rcond=None)[0]
    return np.append(found[1:], 0.0)[:2]


def _moved(angles: FloatArray, bend: FloatArray) -> FloatArray:
    """Angles that a turn of the phasors has corrected; the mean stays, and with it the zero."""
    x = (angles - angles[0]) / (angles[-1] - angles[0]) - 0.5
    return np.asarray(angles + bend[0] * x + bend[1] * (x**2 - 1.0 / 12.0))


def unsteadiness(blocks: ComplexArray, orders: FloatArray) -> str:
    """In words, how phasors (b, c, m) do not stand still; nothing where they do."""
    turn, off = common_turn(blocks, orders)
    highest, bend = float(np.max(orders)), float(np.hypot(*_straight_and_bent(turn)))
    if highest * bend > _TURNED and bend > _SURE * off * (12.0 / turn.size) ** 0.5:
        return f"order {highest:g} turns by {np.degrees(highest * bend):.2g} deg over the record"
    apart = turn - turn.mean()
    alike = float(np.sum(apart[1:] * apart[:-1]) / max(float(np.sum(apart**2)), 1e-300))
    if highest * float(np.std(turn)) > 0.5 and alike > 0.6:
        return "the phases of the blocks wander"
    mean, size = np.abs(blocks.mean(axis=0)), np.abs(blocks).mean(axis=0)
    strongest = np.unravel_index(np.argmax(size), size.shape)
    if mean[strongest] < 0.7 * size[strongest]:
        return "the strongest order does not stand still from block to block"
    return ""


class MeanOrders(NamedTuple):
    """Means (...) over blocks, standard uncertainties along the phasor and across it (...)."""

    amplitudes: ComplexArray
    along: FloatArray
    across: FloatArray


def mean_of_blocks(amplitudes: ComplexArray) -> MeanOrders:
    """Mean over the first axis of (b, ...), b >= 2, and what the scatter of blocks leaves open.

    Standard deviations of the mean (JCGM 100:2008, 4.2.3), of both parts of the blocks turned into
    the phase of the mean; where a block is like the one before it they count as fewer.
    """
    mean = np.mean(amplitudes, axis=0)
    turned = (amplitudes - mean) * np.exp(-1j * np.angle(mean))
    along, across = (_of_mean(part) for part in (turned.real, turned.imag))
    return MeanOrders(np.asarray(mean), along, across)


def _of_mean(apart: FloatArray) -> FloatArray:
    count, square = len(apart), np.sum(apart**2, axis=0)
    tied = np.sum(apart[1:] * apart[:-1], axis=0) / np.where(square > 0.0, square, 1.0)
    # as chance makes few blocks seem alike
    tied = np.where(tied > 2.0 / count**0.5, tied, 0.0)
    more = (1.0 + tied) / np.maximum(1.0 - tied, 0.1)
    return np.asarray(np.sqrt(square / (count - 1) / count * more))


#: mean square between pulses of a cubic spline through pulses that scatter by one each
_BETWEEN = 0.8742


def shortened(mean: ComplexArray, orders: FloatArray, scatter: float) -> FloatArray:
    """By how much orders (..., o) come out too short where each pulse of an even disc is off.

    The pulses count as they came, and `scatter` (rad, root mean square) goes into the angle within
    each turn: no scatter of blocks shows it. E exp(i n e) is 1 - n^2 <e^2> / 2.
    """
    return np.asarray(0.5 * np.abs(mean) * _BETWEEN * (orders * scatter) ** 2)


def by_angle(mean: ComplexArray, lines: FloatArray, wander: float, torsion: float) -> FloatArray:
    """What an angle that is off makes uncertain of orders (..., l), one part of the phasor.

    Of lines (l,) of orders. `wander` (rad, root mean square) makes each phasor shorter; a
    torsional vibration that nobody knows of (the same) at any whole order takes parts of one order
    to the ones that far away.
    """
    size = lines * np.abs(mean)
    worst = np.zeros(size.shape)
    step = max(int(np.rint(1.0 / (lines[1] - lines[0]))), 1) if lines.size > 1 else 1
    for apart in range(step, lines.size, step) if torsion else ():
        moved = np.zeros(size.shape)
        moved[..., apart:] += size[..., :-apart] ** 2
        moved[..., :-apart] += size[..., apart:] ** 2
        worst = np.maximum(worst, moved)
    return np.hypot(0.5 * size * lines * wander**2, 0.5 * torsion * np.sqrt(worst))
