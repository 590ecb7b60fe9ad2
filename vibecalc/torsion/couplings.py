"""Elastic couplings of a shaft line: what their makers permit, and the line with them."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.torsion.line import Line
from vibecalc.torsion.modes import Modes, natural_modes

if TYPE_CHECKING:
    from vibecalc.torsion import line_part_tables as tables

# ----------------------------------------------------------------------------
# A coupling by the values of its maker, each dependence as factors on its nominal values.
# ----------------------------------------------------------------------------


class Rows(NamedTuple):
    """Factors on stiffness and loss factor at the rows (r,) of some quantity, in SI."""

    at: FloatArray
    stiffness: FloatArray
    loss_factor: FloatArray

    def factors(self, value: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of values (...): linear between the rows, constant beyond them."""
        return tuple(np.interp(value, self.at, one) for one in self[1:])  # type: ignore[return-value]


class Permissible(NamedTuple):
    """What the maker permits, in SI, infinite where nothing is said.

    Torques on the coupling's own shaft: `mean`, `peak`, and `vibratory` as a half range at
    `frequency` in rad/s; power loss in W, own speed in rad/s, temperature of the element in K.
    """

    mean: float
    peak: float
    vibratory: float
    frequency: float
    power: float
    speed: float
    temperature: float


class Coupling(NamedTuple):
    """A coupling that is element number `element` of a line, at `ratio` times the crank speed.

    Nominal `stiffness` in N m/rad and `loss_factor` psi / (2 pi), own values; what they depend on,
    None for nothing: the magnitude of the mean torque in N m, the temperature in K, the frequency
    in rad/s, the vibratory torque (half range of all orders) in N m. `temperature` is that of the
    element, or of the air about it in K where `resistance` in K/W gives the rise; 0 for none known.
    `service` (r, 2) are temperatures and the factor S_theta of DIN 740-2 by which torques count.
    """

    name: str
    type: str
    element: int
    ratio: float
    stiffness: float
    loss_factor: float
    mean_torque: Rows | None
    over_temperature: Rows | None
    frequency: Rows | None
    amplitude: Rows | None
    temperature: float
    resistance: float
    service: FloatArray
    permissible: Permissible

    @property
    def varies(self) -> bool:
        """Whether stiffness or loss factor depend on anything."""
        return any(
            rows is not None
            for rows in (self.mean_torque, self.over_temperature, self.frequency, self.amplitude)
        )

    def values(
        self,
        mean_torque: FloatArray,
        temperature: FloatArray,
        frequency: FloatArray,
        amplitude: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Stiffness in N m/rad and loss factor (...), own, under conditions (...) in SI."""
        stiffness: FloatArray = np.asarray(self.stiffness)
        loss: FloatArray = np.asarray(self.loss_factor)
        for rows, value in (
            (self.mean_torque, np.abs(mean_torque)),
            (self.over_temperature, temperature),
            (self.frequency, frequency),
            (self.amplitude, amplitude),
        ):
            if rows is not None:
                of_stiffness, of_loss = rows.factors(value)
                stiffness, loss = stiffness * of_stiffness, loss * of_loss
        return stiffness, loss

    def service_factor(self, temperature: FloatArray) -> FloatArray:
        """S_theta (...) at temperatures (...) in K, 1 where the maker gives none."""
        if not len(self.service):
            return np.ones_like(np.asarray(temperature, dtype=float))
        return np.interp(temperature, self.service[:, 0], self.service[:, 1])

    def frequency_factor(self, frequency: FloatArray) -> FloatArray:
        """S_f (...) of its vibratory torque at frequencies (...)."""
        return np.sqrt(np.maximum(np.asarray(frequency) / self.permissible.frequency, 1.0))


# ----------------------------------------------------------------------------
# What a coupling bears, and how much of what its maker permits that is.
#
# Below the frequency of T_KW the frequency factor is 1, above it sqrt(f / f_KW): the power loss of
# a rubber element goes with f T^2 (DIN 740-2:1986, frequency factor S_f; makers print
# T_KW(f) = T_KW sqrt(10 Hz / f)).
# ----------------------------------------------------------------------------

#: entries of the axis `coupling_limit`
LIMITS = ("T_KN", "T_Kmax", "T_KW", "T_KW by orders", "P_KV", "n_max", "temperature")


def permitted_of(may: Permissible) -> tuple[float, ...]:
    """What the maker permits by each of `LIMITS`, infinite where nothing is said."""
    return (may.mean, may.peak, may.vibratory, may.vibratory, may.power, may.speed, may.temperature)


def has_limit(may: Permissible) -> list[bool]:
    """Which of `LIMITS` the maker says."""
    return [bool(np.isfinite(one)) for one in permitted_of(may)]


# ----------------------------------------------------------------------------
# Natural modes of a line whose couplings follow the frequency: each at its own.
# ----------------------------------------------------------------------------

#: secant steps until a mode stands at its own frequency
_ROUNDS = 40


def modes_at_own_frequency(line_at: Callable[[float], Line]) -> Modes:
    """Undamped modes, each of the line (no leading axes) that `line_at` gives for its frequency.

    Each is the one of its number in every line. Raises NumericalFailure where the frequency of a
    mode does not come to stand.
    """
    start = natural_modes(line_at(0.0))
    rows = [_own(line_at, number, frequency) for number, frequency in enumerate(start.frequency)]
    return Modes(*(np.concatenate(part) for part in zip(*rows, strict=True)))


def _own(line_at: Callable[[float], Line], number: int, frequency: float) -> Modes:
    """The mode of a number, as the only one, with what its frequency is off in its errors."""
    at, last = float(frequency), None
    for _ in range(_ROUNDS):
        found = natural_modes(line_at(at))
        left = float(found.frequency[number]) - at
        slope = 0.0 if last is None or at == last[0] else (left - last[1]) / (at - last[0]) + 1.0
        slope = slope if slope < STEEP else 0.0
        if abs(left) <= 4.0 * EPSILON * at + float(found.frequency_error[number]):
            one = Modes(*(part[number : number + 1] for part in found))
            off = (one.frequency_error + abs(left)) / max(1.0 - slope, 1.0 - STEEP)
            return one._replace(
                frequency_error=off, shape_error=one.shape_error + off / max(at, 1.0)
            )
        last, at = (at, left), at + left / (1.0 - slope)
    raise NumericalFailure(
        f"mode {number + 1} of the shaft line, near {at:.6g} rad/s, has no natural frequency: "
        "its couplings stiffen as fast as it rises"
    )


#: slope of a natural frequency by that at which couplings are taken, from which on it is not used
STEEP = 0.95


# ----------------------------------------------------------------------------
# The line at a speed and a frequency, under the conditions that its couplings are in.
# ----------------------------------------------------------------------------


class Moved(NamedTuple):
    """What errors of conditions may move: angles (s, m, n), twists, torques (s, m, e), heat (s, e).

    Referred, as the solution itself.
    """

    angle: FloatArray
    twist: FloatArray
    torque: FloatArray
    heat: FloatArray


#: of couplings at speeds (3, ..., c), own: mean torque in N m, temperature in K, and half range of
#: the torque in N m
Conditions = FloatArray


class CouplingStates(NamedTuple):
    """Couplings (c,) that vary, and what gives their conditions (u, c) at ascending speeds (u,).

    Formed once: `critical`, the critical speeds (m, q) of the line, and `spread`, the largest
    relative error that those of the conditions make in a stiffness or loss factor. `moved` is what
    these errors make of the solution at speeds (s,); None where the conditions are given.
    """

    couplings: tuple[Coupling, ...]
    conditions: Callable[[FloatArray], Conditions]
    critical: Callable[[], Bounded]
    spread: Callable[[], float] = float
    moved: Callable[[FloatArray], Moved] | None = None

    @property
    def by_frequency(self) -> bool:
        """Whether some coupling depends on the frequency."""
        return any(one.frequency is not None for one in self.couplings)

    def modes(self, line_at: Callable[[float], Line]) -> Modes:
        """Undamped ones of what `line_at` gives at a frequency in rad/s, each at its own."""
        return modes_at_own_frequency(line_at) if self.by_frequency else natural_modes(line_at(0.0))

    def on(self, line: Line, speed: FloatArray | float, frequency: FloatArray | float) -> Line:
        """The line with its couplings at speeds and frequencies (...) in rad/s that broadcast."""
        speed, frequency = np.asarray(speed, dtype=float), np.asarray(frequency, dtype=float)
        shape = np.broadcast_shapes(speed.shape, frequency.shape)
        at, place = np.unique(speed, return_inverse=True)
        found, place = self.conditions(at), place.reshape(speed.shape)
        whole = (*shape, len(line.first))
        stiffness, loss = (
            np.array(np.broadcast_to(one, whole)) for one in (line.stiffness, line.loss_factor)
        )
        for c, one in enumerate(self.couplings):
            mean, temperature, amplitude = (part[place, c] for part in found)
            own, eta = one.values(mean, temperature, frequency, amplitude)
            stiffness[..., one.element] = one.ratio**2 * own
            loss[..., one.element] = eta
        return line._replace(stiffness=stiffness, loss_factor=loss)


# ----------------------------------------------------------------------------
# Nominal values of a coupling, and its rows as factors on them.
#
# What the case says by itself is nominal; of a value that stands in rows only, that of the first
# row is. Rows over a temperature that is given are read there, once and for all.
# ----------------------------------------------------------------------------

_AXES = {
    "over_mean_torque": "torque",
    "over_temperature": "temperature",
    "over_frequency": "frequency",
    "over_amplitude": "torque",
}


class Nominal(NamedTuple):
    """Stiffness in N m/rad and psi of a coupling, and its rows as factors on them by their key."""

    stiffness: float
    relative_damping: float
    rows: dict[str, Rows]


def nominal(given: "tables.Coupling") -> Nominal:
    """Of a coupling whose values stand once each, as the rules of its table hold."""
    value = {"stiffness": given.stiffness, "relative_damping": given.relative_damping}
    rows: dict[str, Rows] = {}
    for key, axis in _AXES.items():
        table = getattr(given, key)
        if table is None:
            continue
        at = np.array(getattr(table, axis), dtype=float)
        factors: list[FloatArray] = []
        for name in value:
            column, factor = getattr(table, name), getattr(table, f"{name}_factor")
            if column is not None:
                value[name] = column[0]
                factor = np.array(column) / column[0]
            factors.append(np.ones(len(at)) if factor is None else np.array(factor))
        rows[key] = Rows(at, *factors)
    stiffness, psi = value["stiffness"], value["relative_damping"]
    assert stiffness is not None and psi is not None  # each stands once, say the rules
    if given.temperature is not None and "over_temperature" in rows:
        warm = rows.pop("over_temperature").factors(np.asarray(given.temperature))
        stiffness, psi = stiffness * float(warm[0]), psi * float(warm[1])
    return Nominal(stiffness, psi, rows)


def permissible(given: "tables.Coupling") -> Permissible:
    """What the maker of a coupling permits, its power loss at the temperature of the air."""
    power, rows = given.power_loss, given.power_loss_over_temperature
    if rows is not None:
        assert given.ambient_temperature is not None  # its rows want one, says the form
        power = float(np.interp(given.ambient_temperature, rows.temperature, rows.power_loss))
    return Permissible(
        given.nominal_torque or math.inf,
        given.maximum_torque or math.inf,
        given.vibratory_torque or math.inf,
        given.vibratory_frequency,
        power or math.inf,
        given.maximum_speed or math.inf,
        given.maximum_temperature or math.inf,
    )


def coupling_of(given: "tables.Coupling", name: str, element: int, ratio: float) -> Coupling:
    """The coupling of the shaft number `element`, at so many times the crank speed."""
    own, may = nominal(given), permissible(given)
    resistance = given.thermal_resistance or 0.0
    if given.temperature_rise is not None:
        resistance = given.temperature_rise / may.power
    warm, service = given.over_temperature, np.zeros((0, 2))
    if warm is not None and warm.service_factor is not None:
        service = np.array([warm.temperature, warm.service_factor]).T
    known = given.ambient_temperature if resistance else given.temperature
    return Coupling(
        name=name,
        type=given.type or "",
        element=element,
        ratio=ratio,
        stiffness=own.stiffness,
        loss_factor=own.relative_damping / (2.0 * math.pi),
        mean_torque=own.rows.get("over_mean_torque"),
        over_temperature=own.rows.get("over_temperature"),
        frequency=own.rows.get("over_frequency"),
        amplitude=own.rows.get("over_amplitude"),
        temperature=known or 0.0,
        resistance=resistance,
        service=service,
        permissible=may,
    )
