"""The shaft line of a case with what drives and damps it, ready to be solved at any speeds."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.case.torsion_tables import Torsion
from vibecalc.errors import NumericalFailure
from vibecalc.machine.shaft_line import ShaftLine, build_shaft_line
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.pipeline.stages.torsion.drive import Drive, build_drive
from vibecalc.response.torsion.forced import Masked, forced_masked
from vibecalc.response.torsion.forced_ratios import ModalLine, modal_line, ratio_response
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.line_modes import (
    LineModes,
    damped_line_modes,
    undamped_line_modes,
)
from vibecalc.response.torsion.modes import Modes, natural_modes

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


class Model(NamedTuple):
    """A line in motion: its values at standstill, what speed adds, how it is solved.

    `speed_stiffness` (e,) in N m/rad per (rad/s)^2; `modal` takes the place of the matrices where
    the case damps by mode or asks for modes; a line damped by mode has no damping of its own.
    `stations` freedoms come first, then the rings of dampers; `rayleigh` (a, b) is what a J + b K
    damps it with.
    """

    line: Line
    speed_stiffness: FloatArray
    method: str
    modal: ModalLine | None
    stations: int
    rayleigh: tuple[float, float] = (0.0, 0.0)

    def at(self, speed: FloatArray | float) -> Line:
        """The line at speeds (...) in rad/s; the stiffness then has their axes in front."""
        if not np.any(self.speed_stiffness):
            return self.line
        square = np.square(np.asarray(speed, dtype=float))[..., None]
        return self.line._replace(stiffness=self.line.stiffness + square * self.speed_stiffness)

    def solve(
        self,
        speed: FloatArray,
        order: FloatArray,
        torque: ComplexArray,
        freedom: IntArray,
        estimate: bool = True,
    ) -> Masked:
        """Referred angles (..., s, m, n) for torques (..., s, m, k) on k places of freedoms."""
        frequency = speed[:, None] * order
        loaded = np.unique(freedom)
        if len(loaded) < len(freedom):  # stations that rigid gears hold together
            torque = torque @ (freedom[:, None] == loaded).astype(float)
            freedom = loaded
        if self.modal is not None:
            return ratio_response(self.modal, frequency, torque, freedom)
        line = self.at(speed[:, None])
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

    `modes` are the undamped ones at the operating speed, rings free; `natural` gives, formed once,
    the modes of the line as it vibrates there, which critical speeds, margins, vector sums and
    all numbers of modes belong to. Where a damping model takes the place of the dampings given,
    `shaft.station_values` hold those of the model; `shaft.line` stays as given.
    """

    torsion: Torsion
    speed: float
    shaft: ShaftLine
    drive: Drive
    model: Model
    modes: Modes
    natural: Callable[[], LineModes]


def build_setup(case: "Case") -> Setup:
    """All of it from a validated case."""
    assert case.response is not None and case.response.torsion is not None
    torsion, speed, shaft = case.response.torsion, case.machine.speed, build_shaft_line(case)
    stations = len(shaft.freedom_names) - len(shaft.dampers)
    model, modes = build_model(torsion, shaft.line, shaft.speed_stiffness, speed, stations)
    if torsion.damping_model is not None:
        inertia, _, held = shaft.station_values
        of_inertia, of_stiffness = model.rayleigh
        damping = of_inertia * inertia + of_stiffness * held
        shaft = replace(shaft, station_values=np.array([inertia, damping, held]))
    natural = natural_of(torsion, model, modes, speed)
    return Setup(torsion, speed, shaft, build_drive(case, shaft), model, modes, natural)


def natural_of(
    torsion: Torsion, model: Model, modes: Modes, speed: float
) -> Callable[[], LineModes]:
    """The modes of a line as it vibrates at a crank speed, formed when they are first wanted."""
    return cache(lambda: line_modes(torsion, model, modes, speed))


def line_modes(torsion: Torsion, model: Model, modes: Modes, speed: float) -> LineModes:
    """Poles where a ring is damped against the line, else the undamped `modes` of that speed."""
    line = model.at(speed)
    ring = line.second >= model.stations
    hung = np.any((line.damping[ring] > 0.0) | (line.loss_factor[ring] > 0.0))
    failure = ""
    if torsion.damping_model is None and hung:
        try:
            return damped_line_modes(line, len(line.inertia) - model.stations)
        except NumericalFailure as problem:
            failure = str(problem)
    return undamped_line_modes(modes, damping_ratios(model, modes, speed), failure)


def damping_ratios(model: Model, modes: Modes, speed: float) -> FloatArray:
    """By work and energy of undamped shapes (m,), 0 for rigid modes."""
    modal, line = model.modal, model.at(speed)
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
    torsion: Torsion, line: Line, speed_stiffness: FloatArray, speed: float, stations: int
) -> tuple[Model, Modes]:
    """A line, damped as the case says, with its undamped modes at a speed in rad/s.

    Its first `stations` freedoms are those of stations, the others rings of dampers.

    Raises NumericalFailure where a sum over modes is asked for and damping couples them.
    """
    plain = Model(line, speed_stiffness, torsion.method, None, stations)
    modes = natural_modes(plain.at(speed))
    damping = torsion.damping_model
    if damping is not None and damping.kind == "rayleigh":
        factors = _rayleigh_factors(modes, damping.modes, damping.ratios)
        line = _with_rayleigh(line, *factors)
        plain = plain._replace(line=line, rayleigh=factors)
    if damping is not None and damping.kind == "modal":
        ratios = np.zeros(len(modes.frequency))
        given = damping.ratios
        if len(given) == 1:
            ratios[modes.frequency > 0.0] = given[0]
        else:
            count = min(len(given), len(ratios))
            ratios[:count] = given[:count]
        plain = plain._replace(line=_with_rayleigh(line, 0.0, 0.0))
        return plain._replace(modal=modal_line(modes, ratios=ratios)), modes
    if torsion.method == "modal":
        return plain._replace(modal=modal_line(modes, line=plain.at(speed))), modes
    return plain, modes


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
