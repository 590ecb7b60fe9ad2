"""The shaft line of a case with what drives and damps it, ready to be solved at any speeds."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.cylinder_torque import (
    CylinderTorque,
    cylinder_gas,
    cylinder_torque,
    inertia_harmonics,
    phasor,
    weighted,
)
from vibecalc.excitation.gas_tables import GasCard, card_weights, gas_card
from vibecalc.excitation.model import (
    Firing,
    build_firing,
    gas_cards,
    motored_cards,
    with_tangential_effort,
)
from vibecalc.kinds import has_crank_train
from vibecalc.numerics.bounded import Bounded, reshaped, rounded
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray, IntArray, distinct
from vibecalc.numerics.synthesis import Cycles
from vibecalc.parts.crank_train import build_crank_train, crank_geometry
from vibecalc.parts.geometry import CrankGeometry
from vibecalc.torsion.asked import asked_orders
from vibecalc.torsion.damped_modes import (
    LineModes,
    damped_line_modes,
    moves_modes,
    undamped_line_modes,
)
from vibecalc.torsion.forced import (
    MaskedResponse,
    ModalLine,
    forced_masked,
    modal_line,
    ratio_response,
)
from vibecalc.torsion.line import Line, mapped
from vibecalc.torsion.model import ShaftLineModel, build_shaft_line
from vibecalc.torsion.modes import Modes, natural_modes
from vibecalc.torsion.poles import guesses
from vibecalc.torsion.speed_damping import SpeedDamping, turning
from vibecalc.torsion.station_torques import (
    ALONE,
    Harmonic,
    Orders,
    columns,
    given_harmonics,
    given_torque,
)
from vibecalc.torsion.tables import LineSpeeds, Torsion

if TYPE_CHECKING:
    from vibecalc.schema import Case, Machine
    from vibecalc.torsion.couplings import CouplingStates

#: as `Scene.once`
Once = Callable[[str, Callable[["Case"], Any]], Any]

# ----------------------------------------------------------------------------
# What the cylinders do to the stations of a shaft line, ready for any crank speed.
#
# The gas part is linear in the cards, whose weights follow the speed; the inertia part goes with
# its square. Both are summed over the cylinders of each station once, with their firing phases.
# ----------------------------------------------------------------------------


_NONE, _NOWHERE = np.zeros(0), np.zeros(0, dtype=np.int64)
_NOBODY = Firing(
    names=(), angle=_NONE, first=0.0, cycle=2.0 * np.pi, pressure_scale=_NONE,
    fires=_NONE.astype(bool), bank=_NONE,
)  # fmt: skip
#: of the phase with which a cylinder fires, and of what a speed makes of its torque
PHASOR_ROUNDINGS, SPEED_ROUNDINGS = 16.0, 12.0


class Drive(NamedTuple):
    """Torques on k of the stations at m orders for c cards, referred, complex, 0-to-peak.

    `gas` (c, m, k) in N m and `inertia` (m, k) in N m per (rad/s)^2, `mean` (c, k) of the gas in
    N m; `station` and `freedom` (k,) say where. `card_speed` (c,) in rad/s, empty for one card
    that holds at every speed; a table of tangential effort has such speeds and no `cards`.
    `cylinder` is a healthy one, `reciprocating_mass` in kg and `rod_inertia` in kg m^2 what moves
    in it; a line without cylinders has none of these. `given` are torques at stations beside those
    of cylinders, by column and place. `fires` (m,) are the orders of the engine; `orders` has, of
    all, what repeats together and what does not follow the speed.
    """

    orders: Orders = columns(_NONE, [], 1.0)
    given: tuple[tuple[int, int, Harmonic], ...] = ()
    fires: BoolArray = _NONE.astype(bool)
    gas: Bounded = Bounded(np.zeros((1, 0, 0), dtype=complex), np.zeros((1, 0, 0)))
    inertia: Bounded = Bounded(np.zeros((0, 0), dtype=complex), np.zeros((0, 0)))
    mean: Bounded = Bounded(np.zeros((1, 0)), np.zeros((1, 0)))
    station: IntArray = _NOWHERE
    freedom: IntArray = _NOWHERE
    card_speed: FloatArray = _NONE
    cards: tuple[GasCard, ...] = ()
    geometry: CrankGeometry = CrankGeometry(0.0, 1.0)
    firing: Firing = _NOBODY
    cylinder: CylinderTorque = CylinderTorque(
        _NONE, rounded(_NONE[None] + 0j, 0.0), rounded(_NONE + 0j, 0.0), rounded(np.zeros(1), 0.0)
    )
    reciprocating_mass: float = 0.0
    rod_inertia: float = 0.0

    @property
    def order(self) -> FloatArray:
        """Of the crank (m,), ascending; at the operating speed where it does not follow."""
        return self.orders.order

    @property
    def cycles(self) -> Cycles:
        """What of the orders (m,) repeats together."""
        return self.orders.cycles

    def frequency(self, speed: FloatArray) -> FloatArray:
        """Of all orders (s, m) in rad/s at speeds (s,)."""
        if not np.any(self.orders.fixed):
            return speed[:, None] * self.order
        follows = np.where(self.orders.fixed > 0.0, 0.0, self.order)
        return speed[:, None] * follows + self.orders.fixed

    def weights(self, speed: FloatArray) -> FloatArray:
        """Of the cards at speeds (...), (..., c)."""
        return card_weights(self.card_speed if len(self.card_speed) else np.zeros(1), speed)

    def torque(self, speed: FloatArray) -> Bounded:
        """Torques (s, m, k) at speeds (s,) in rad/s."""
        by_card = reshaped(self.gas, lambda one: one.reshape(len(one), -1))
        gas = rounded(self.weights(speed), SPEED_ROUNDINGS) @ by_card
        gas = reshaped(gas, lambda one: one.reshape(-1, *self.gas.shape[1:]))
        square = rounded(np.square(speed)[:, None, None], SPEED_ROUNDINGS)
        total = gas + square * self.inertia
        return total + given_torque(self.given, speed, *self.inertia.shape) if self.given else total

    def load(self, speed: FloatArray) -> ComplexArray:
        """The torques (s, m, k) alone, to the last bit those of `torque`; in memory k is first."""
        gas = self.gas.value
        total = np.square(speed)[:, None] * np.ascontiguousarray(self.inertia.value.T)[:, None]
        if len(gas) > 1:  # one alone has the weight 1
            gas = (self.weights(speed) @ gas.reshape(len(gas), -1)).reshape(-1, *gas.shape[1:])
        total += np.moveaxis(gas, -1, 0)
        if self.given:
            total += np.moveaxis(given_torque(self.given, speed, *self.inertia.shape).value, -1, 0)
        return np.moveaxis(total, 0, -1)

    def mean_torque(self, speed: FloatArray) -> Bounded:
        """Mean torques (s, k) at speeds (s,)."""
        return rounded(self.weights(speed), SPEED_ROUNDINGS) @ self.mean

    def healthy(self, speed: float) -> CylinderTorque:
        """One cylinder at one speed: gas (m,), mean ()."""
        return weighted(self.cylinder, self.weights(np.asarray(speed)))


def placed(place: IntArray, count: int) -> FloatArray:
    """1 where each of some things (k,) stands among so many places, (k, count), else 0."""
    return np.asarray((np.asarray(place)[:, None] == np.arange(count)).astype(float))


def build_drive(
    case: "Case",
    shaft: ShaftLineModel,
    *,
    all_fire: bool = False,
    orders: tuple[float, float] | None = None,
    once: Once | None = None,
) -> Drive:
    """What drives a validated line: its cylinders, and the torques given at stations.

    The orders of an engine are those that [response.torsion] asks for. `all_fire` leaves out that
    cylinders misfire; `orders` are others, the highest and the step. With `once`, as of a scene,
    the torques of a cylinder are those of runs before this one where they are the same.
    """
    if not has_crank_train(case.machine):
        drive = Drive()
    elif once is None or orders is not None:
        drive = _cylinders(case, orders)
    else:
        drive = once("torques of a cylinder of a shaft line", _cylinders)
    line, engine = case.machine.shaft_line, drive.order
    harmonics: list[Harmonic] = []
    if line is not None and line.excitations:
        harmonics = given_harmonics(case, shaft, lambda at: drive.mean_torque(at).value.sum(1))
    alone = not len(engine) and not harmonics  # a step in time: order 1 of nothing
    acting = ALONE if alone else engine
    every = columns(acting, [one.of for one in harmonics], case.machine.speed)
    given = [shaft.load_station] * alone + [one.of.station for one in harmonics]
    station = distinct([*shaft.cylinder_station.tolist(), *given]).astype(np.int64)
    fires = np.any(every.order[:, None] == engine, axis=1) & (every.fixed == 0.0)

    def spread(values: Any) -> Any:
        whole = np.zeros((len(every.order), values.shape[1]), values.dtype)
        whole[fires] = values
        return whole

    drive = drive._replace(
        orders=every,
        given=tuple(
            (every.column(one.of), int(np.searchsorted(station, one.of.station)), one)
            for one in harmonics
        ),
        fires=fires,
        inertia=reshaped(drive.inertia, spread) @ _on_stations(shaft, station),
        station=station,
        freedom=shaft.freedom[station],
        cylinder=with_orders(drive.cylinder, np.ones_like(engine, dtype=bool), every.order, fires),
    )
    out, torsion = ~drive.firing.fires & (not all_fire), case.response and case.response.torsion
    motored = None
    if np.any(out) and drive.cards and torsion and torsion.misfire_kind == "motored":
        motored = motored_torque(case.machine, drive)
    drive = with_gas(drive, shaft, drive.firing.pressure_scale, out, motored)
    return drive


def _on_stations(shaft: ShaftLineModel, station: IntArray) -> FloatArray:
    """Of each cylinder its referred share (c, k) in the torques of stations."""
    where = placed(np.searchsorted(station, shaft.cylinder_station), len(station))
    return where * shaft.station_ratio[shaft.cylinder_station][:, None]


def with_gas(
    drive: Drive,
    shaft: ShaftLineModel,
    scale: FloatArray,
    out: BoolArray,
    motored: CylinderTorque | None = None,
) -> Drive:
    """The drive with factors (c,) on the gas pressure of its cylinders.

    Those that are `out` (c,) have the gas of `motored` ones, or none.
    """
    on, one = _on_stations(shaft, drive.station), drive.cylinder
    gas, mean = cylinder_gas(one, scale, misfiring=out, motored=motored)  # (cards, c, orders)
    turned = gas * rounded(phasor(one.order, drive.firing.angle).T, PHASOR_ROUNDINGS)
    return drive._replace(
        gas=reshaped(turned, lambda part: np.swapaxes(part, -1, -2)) @ on,
        mean=mean @ rounded(on, SPEED_ROUNDINGS),
    )


def with_orders(
    torque: CylinderTorque, kept: BoolArray, order: FloatArray, fires: BoolArray
) -> CylinderTorque:
    """Those orders of a cylinder that are `kept`, as the ones that it `fires` of orders (m,)."""

    def spread(values: Any) -> Any:
        whole = np.zeros((*values.shape[:-1], len(order)), values.dtype)
        whole[..., fires] = values[..., kept]
        return whole

    gas, inertia = (reshaped(one, spread) for one in (torque.gas, torque.inertia))
    return torque._replace(order=order, gas=gas, inertia=inertia)


def _cylinders(case: "Case", orders: tuple[float, float] | None = None) -> Drive:
    """One cylinder of an engine, and the moving masses (m, c) of all, wherever they stand."""
    machine = case.machine
    firing, geometry = build_firing(case), crank_geometry(machine.crank_train)
    card_speed, cards = gas_cards(machine)
    if not cards:
        ends = np.array([0.0, firing.cycle])
        cards = (gas_card(ends, np.zeros(2), cycle=firing.cycle),)
    highest, step = orders or asked_orders(case)
    base = 2.0 * np.pi / firing.cycle
    every, rod_inertia = round(step / base), rod_difference(machine)
    masses = build_crank_train(machine.crank_train).reciprocating_mass
    mass = float(masses.max())
    one = cylinder_torque(
        cards,
        geometry,
        reciprocating_mass=mass,
        rod_inertia_difference=rod_inertia,
        harmonics=round(highest / base),
    )
    if machine.crank_train.tangential_effort is not None:
        card_speed, one = with_tangential_effort(machine, one)
        cards = ()
    kept = slice(every - 1, None, every)
    one = one._replace(order=one.order[kept], gas=one.gas[..., kept], inertia=one.inertia[kept])
    turned = rounded(phasor(one.order, firing.angle).T, PHASOR_ROUNDINGS)  # (cylinders, orders)
    moved = inertia_harmonics(geometry, 1.0, 0.0, one.order)
    rocked = inertia_harmonics(geometry, 0.0, rod_inertia, one.order)
    return Drive(
        orders=columns(one.order, [], 1.0),
        inertia=((masses[:, None] * moved + rocked) * turned).T,
        card_speed=card_speed,
        cards=tuple(cards),
        geometry=geometry,
        firing=firing,
        cylinder=one,
        reciprocating_mass=mass,
        rod_inertia=rod_inertia,
    )


def rod_difference(machine: "Machine") -> float:
    """Moment of the rod beyond its two point masses, kg m^2; 0 where the case gives none."""
    rod = machine.crank_train.rod
    if rod is None or rod.inertia is None:
        return 0.0
    from vibecalc.excitation.crank_forces import rod_difference as beyond

    return float(beyond(build_crank_train(machine.crank_train), rod).value)


def motored_torque(machine: "Machine", drive: Drive) -> CylinderTorque:
    """Of a cylinder without combustion, the cards and orders of a drive."""
    order = drive.order[drive.fires]
    harmonics = round(float(order[-1]) * drive.firing.cycle / (2.0 * np.pi))
    cards = motored_cards(machine, drive.cards)
    found = cylinder_torque(cards, drive.geometry, reciprocating_mass=0.0, harmonics=harmonics)
    return with_orders(found, np.isin(found.order, order), drive.order, drive.fires)


# ----------------------------------------------------------------------------
# The shaft line of a case with what drives and damps it, ready to be solved at any speeds.
# ----------------------------------------------------------------------------


class Model(NamedTuple):
    """A line in motion: its values at standstill, what speed adds, how it is solved.

    `speed_stiffness` (e,) in N m/rad per (rad/s)^2; `modal` takes the place of the matrices where
    the case damps by mode or asks for modes; a line damped by mode has no damping of its own.
    `stations` freedoms come first, then the rings of dampers; `rayleigh` (a, b) is what a J + b K
    damps it with. `line` has the dampings of the operating speed, `over_speed` what follows it;
    `couplings` are those whose values depend on what the line does. Of many machines, as a sweep
    over dampers has them, values of the line have an axis (p,) in front.
    """

    line: Line
    speed_stiffness: FloatArray
    method: str
    modal: ModalLine | None
    stations: int
    rayleigh: tuple[float, float] = (0.0, 0.0)
    over_speed: SpeedDamping | None = None
    couplings: "CouplingStates | None" = None

    @property
    def machines(self) -> int:
        """How many there are; 0 for one whose values have no axis for them."""
        line = self.line
        each = (line.inertia, line.stiffness, line.damping, line.loss_factor)
        return max(len(one) if one.ndim > 1 else 0 for one in each)

    @property
    def by_frequency(self) -> bool:
        """Whether some coupling depends on the frequency."""
        return self.couplings is not None and self.couplings.by_frequency

    def of(self, machine: IntArray) -> "Model":
        """Some of many machines (...), for frequencies (..., m): each entry may be another one."""
        if not self.machines:
            return self
        line = mapped(self.line, lambda one: one[machine][..., None, :] if one.ndim > 1 else one)
        return self._replace(line=line)

    def at(self, speed: FloatArray | float, frequency: FloatArray | float = 0.0) -> Line:
        """The line at speeds (...) in rad/s; what follows them then has their axes in front.

        It vibrates at a `frequency` (...) in rad/s, which couplings may depend on.
        """
        line = turning(self.line, self.over_speed, self.speed_stiffness, speed)
        if self.couplings is not None:
            line = self.couplings.on(line, speed, frequency)
        return line

    def solve(
        self,
        speed: FloatArray,
        frequency: FloatArray,
        torque: ComplexArray,
        freedom: IntArray,
        estimate: bool = True,
    ) -> MaskedResponse:
        """Referred angles (..., s, m, n) for torques (..., s, m, k) on k places of freedoms.

        `speed` (s,) and `frequency` (s, m) in rad/s.
        """
        if self.modal is not None:
            return ratio_response(self.modal, frequency, torque, freedom)
        line = self.at(speed[:, None], frequency)
        return forced_masked(
            line,
            frequency,
            torque,
            stations=freedom.tolist(),
            estimate=estimate,
            dense=self.method == "dense",
        )


class Setup(NamedTuple):
    """What the stages of a shaft line share.

    `undamped` gives, formed once, the undamped modes at the operating speed, rings free; `natural`
    the modes of the line as it vibrates there, which critical speeds, margins, vector sums and
    all numbers of modes belong to. Where a damping model takes the place of the dampings given,
    `shaft.station_values` hold those of the model; `shaft.line` stays as given.
    """

    torsion: Torsion
    speed: float
    shaft: ShaftLineModel
    drive: Drive
    model: Model
    undamped: Callable[[], Modes]
    natural: Callable[[], LineModes]

    @property
    def modes(self) -> Modes:
        """The undamped ones."""
        return self.undamped()

    def of(self, machine: IntArray) -> "Setup":
        """Some of many machines (s,), for speeds (s,)."""
        return self._replace(model=self.model.of(machine))


def line_speeds(options: LineSpeeds) -> FloatArray:
    """Speeds of a range, both ends included."""
    make = np.geomspace if options.spacing == "logarithmic" else np.linspace
    found = make(options.start, options.stop, options.points)
    found[[0, -1]] = options.start, options.stop
    return np.asarray(found)


#: bytes of an array from which on memory is still taken from the system and handed back
_RESERVED = 1 << 24


def _keep_freed_memory() -> None:
    """Let arrays of up to 16 MB be made in memory that arrays before them have left.

    A page that the system hands out anew costs more than the arithmetic on the numbers in it.
    glibc keeps what is freed up to twice the size of the largest piece that was ever handed back,
    which this makes and frees without touching it; other allocators take no notice.
    """
    np.empty(_RESERVED, dtype=np.uint8)


def build_setup(case: "Case", once: Once | None = None) -> Setup:
    """All of it from a validated case; see `build_drive` for `once`."""
    _keep_freed_memory()
    assert case.response is not None and case.response.torsion is not None
    torsion, speed, shaft = case.response.torsion, case.machine.speed, build_shaft_line(case)
    stations = len(shaft.freedom_names) - len(shaft.dampers)
    model, undamped = build_model(
        torsion, shaft.line, shaft.speed_stiffness, speed, stations, shaft.over_speed
    )
    if torsion.damping_model is not None:
        inertia, _, held = shaft.station_values
        of_inertia, of_stiffness = model.rayleigh
        damping = of_inertia * inertia + of_stiffness * held
        shaft = replace(shaft, station_values=np.array([inertia, damping, held]), station_laws=())
    natural = natural_of(torsion, model, undamped, speed)
    drive = build_drive(case, shaft, once=once)
    return Setup(torsion, speed, shaft, drive, model, undamped, natural)


def natural_of(
    torsion: Torsion, model: Model, undamped: Callable[[], Modes], speed: float
) -> Callable[[], LineModes]:
    """The modes of a line as it vibrates at a crank speed, formed when they are first wanted."""
    return cache(lambda: line_modes(torsion, model, undamped(), speed))


def undamped_modes(model: Model, speed: float) -> Modes:
    """At a speed in rad/s, rings free; each at its own frequency where couplings depend on it."""
    if model.couplings is None:
        return natural_modes(model.at(speed))
    found = model.couplings.modes(lambda frequency: model.at(speed, frequency))
    off = 0.5 * model.couplings.spread() * found.frequency
    return found._replace(frequency_error=found.frequency_error + off)


def line_modes(torsion: Torsion, model: Model, modes: Modes, speed: float) -> LineModes:
    """Poles where damping moves the modes of the line, else the undamped `modes` of that speed."""
    failure = ""
    line = model.at(speed, modes.frequency)
    if torsion.damping_model is None and moves_modes(line, modes):
        try:
            guess = None if model.by_frequency else guesses(model.at(speed), modes)
            return vibrating_modes(model, speed, guess)
        except NumericalFailure as problem:
            failure = str(problem)
    return undamped_line_modes(modes, damping_ratios(model, modes, speed), failure)


def vibrating_modes(
    model: Model, speed: float, guess: tuple[ComplexArray, ComplexArray] | None
) -> LineModes:
    """Poles of a line at a crank speed; `guess` as of `damped_line_modes`."""
    rings = model.line.inertia.shape[-1] - model.stations
    line_at = partial(model.at, speed) if model.by_frequency else None
    return damped_line_modes(model.at(speed), rings, line_at, guess)


def damping_ratios(model: Model, modes: Modes, speed: float) -> FloatArray:
    """By work and energy of undamped shapes (m,), 0 for rigid modes."""
    modal, line = model.modal, model.at(speed, modes.frequency)
    w, moving = modes.frequency, modes.frequency > 0.0
    if modal is not None:
        work = w * modal.dashpot + modal.loss
    else:
        twist = modes.shape[:, line.first] - modes.shape[:, line.second]
        taken = w[:, None] * line.damping + line.stiffness * line.loss_factor
        work = np.sum(taken * twist**2, axis=1) + w * (modes.shape**2 @ line.absolute_damping)
    safe = np.where(moving, w, 1.0)
    return np.where(moving, work / (2.0 * modes.modal_inertia * safe**2), 0.0)


def build_model(
    torsion: Torsion,
    line: Line,
    speed_stiffness: FloatArray,
    speed: float,
    stations: int,
    over_speed: SpeedDamping | None,
) -> tuple[Model, Callable[[], Modes]]:
    """A line, damped as the case says, and what forms its undamped modes at a speed in rad/s.

    Its first `stations` freedoms are those of stations, the others rings of dampers. A damping
    model takes the place of all dampings, those `over_speed` among them.

    Raises NumericalFailure where a sum over modes is asked for and damping couples them.
    """
    damping = torsion.damping_model
    plain = Model(line, speed_stiffness, torsion.method, None, stations)
    if damping is None:
        plain = plain._replace(over_speed=over_speed)
    undamped = cache(partial(undamped_modes, plain, speed))
    if damping is not None and damping.kind == "rayleigh":
        factors = _rayleigh_factors(undamped(), damping.modes, damping.ratios)
        line = _with_rayleigh(line, *factors)
        plain = plain._replace(line=line, rayleigh=factors)
    if damping is not None and damping.kind == "modal":
        modes, given = undamped(), damping.ratios
        ratios = np.zeros(len(modes.frequency))
        if len(given) == 1:
            ratios[modes.frequency > 0.0] = given[0]
        else:
            count = min(len(given), len(ratios))
            ratios[:count] = given[:count]
        plain = plain._replace(line=_with_rayleigh(line, 0.0, 0.0))
        return plain._replace(modal=modal_line(modes, ratios=ratios)), undamped
    if torsion.method == "modal":
        return plain._replace(modal=modal_line(undamped(), line=plain.at(speed))), undamped
    return plain, undamped


def _rayleigh_factors(
    modes: Modes, chosen: tuple[int, ...], ratios: tuple[float, ...]
) -> tuple[float, float]:
    """a and b of the damping a J + b K that gives the chosen modes their ratios."""
    natural = modes.frequency[[number - 1 for number in chosen]]
    if np.any(natural <= 0.0):
        number = chosen[int(np.argmin(natural))]
        raise NumericalFailure(
            f"Rayleigh damping: mode {number} is a rigid one, and a damping ratio of it says "
            "nothing; take elastic modes (a ring in oil without springs has a rigid one, too)"
        )
    values = np.array(ratios if len(ratios) == len(chosen) else ratios * len(chosen))
    terms = np.stack([1.0 / natural, natural], axis=1)
    of_inertia, of_stiffness = np.linalg.solve(terms, 2.0 * values).tolist()
    return of_inertia, of_stiffness


def _with_rayleigh(line: Line, of_inertia: float, of_stiffness: float) -> Line:
    """The line with a J + b K in place of its dampings and loss factors."""
    return line._replace(
        absolute_damping=of_inertia * line.inertia + of_stiffness * line.ground_stiffness,
        damping=of_stiffness * line.stiffness,
        loss_factor=np.zeros_like(line.loss_factor),
    )
