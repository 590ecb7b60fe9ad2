"""The modal route of the source, one mode at a time, named for what it is."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF, ComplexArray, FloatArray, floats
from vibecalc.torsion.adapters.setup import Setup, build_setup, line_speeds, placed
from vibecalc.torsion.asked import has_holzer
from vibecalc.torsion.modes_of_tree import relative_residual
from vibecalc.torsion.study_results import PUBLISHED
from vibecalc.torsion.tables import AsPublished

# ----------------------------------------------------------------------------
# Modal twist of a shaft line at chosen speeds, as Baca (2007, chapter 4) examines an engine.
#
# A modal coordinate is not the twist of a shaft: its size follows from how the mode is scaled (the
# source sets the first station to one), and the instant t = 0 is not that of the peak. What a shaft
# bears is in `forced` and `sections`. Kept here under the names of the source's equations.
#
# Torques are complex, T(t) = Re(T_q exp(i q speed t)), so that a cosine part a and a sine part b
# are T_q = a - i b; orders q are half orders j / 2 in four-stroke. The atan of the source, which
# loses the quadrant, does not appear: phases stay in complex numbers.
# ----------------------------------------------------------------------------


class ModalExcitation(NamedTuple):
    """Modes (m) against orders (q), all with the scaling of the shapes that were given.

    `vector_sum` (m, q) complex in N m is sum_i Gamma_i T_qi; its magnitude is the harmonic
    intensity, the numerator of Q. `deflection` (m, q) complex in rad is that over the modal
    stiffness: magnitude Q, phase minus xi.
    """

    vector_sum: ComplexArray
    deflection: ComplexArray


def modal_excitation(
    shape: ArrayLike, frequency: ArrayLike, inertia: ArrayLike, torque: ArrayLike
) -> ModalExcitation:
    """Vector sums of eqs. 4.17 and 4.28 over the stations.

    Parameters
    ----------
    shape, frequency : (m, n) and (m,) in rad/s, rigid modes left out.
    inertia : (n,) in kg m^2.
    torque : (q, n) complex in N m, with the firing phase of each station in it, once.

    NumericalFailure for a rigid mode: it has no static deflection.
    """
    modes, natural, mass = floats(shape, frequency, inertia)
    if np.any(natural <= 0.0):
        raise NumericalFailure("a rigid mode has no static deflection; leave it out")
    total = modes @ np.asarray(torque, dtype=np.complex128).T
    stiffness = (np.square(modes) @ mass) * natural**2
    return ModalExcitation(total, total / stiffness[:, None])


def magnifier(ratio: ArrayLike, damping_ratio: ArrayLike = 0.0) -> ComplexArray:
    """1 / (1 - r^2 + 2 i zeta r), r = q speed / natural frequency (eqs. 4.18 and 4.29).

    NumericalFailure where an undamped mode is met exactly: the source puts eq. 4.19 there.
    """
    r, zeta = floats(ratio, damping_ratio)
    below = np.asarray((1.0 - r) * (1.0 + r) + 2j * zeta * r)
    if np.any(below == 0.0):
        raise NumericalFailure("an order meets an undamped natural frequency")
    return np.asarray(1.0 / below)


def empirical_magnifier(deflection: ArrayLike) -> FloatArray:
    """3.8 / Q^(1/4) on an undamped critical speed (eq. 4.19), Q > 0 in rad.

    Empirical and with a hidden unit: it is not independent of the scaling of the mode.
    """
    (static,) = floats(deflection)
    if np.any(static <= 0.0):
        raise NumericalFailure("the empirical magnifier needs a positive static deflection")
    return np.asarray(3.8 / static**0.25)


def modal_twist(
    excitation: ModalExcitation,
    frequency: ArrayLike,
    order: ArrayLike,
    speed: ArrayLike,
    damping_ratio: ArrayLike = 0.0,
) -> ComplexArray:
    """gamma_c (m, s) in rad of eqs. 4.17 (damping ratio zero) and 4.28 over speeds (s,) in rad/s.

    The twist at t = 0 is its real part; the source calls the magnitude "real + imaginary". The
    torque is one for all speeds, as there.
    """
    natural, orders, turning, zeta = floats(frequency, order, speed, damping_ratio)
    ratio = orders * turning[:, None] / natural[:, None, None]
    zeta = np.broadcast_to(zeta, natural.shape)[:, None, None]
    return np.asarray((magnifier(ratio, zeta) * excitation.deflection[:, None, :]).sum(axis=-1))


def twist_on_criticals(
    excitation: ModalExcitation, order: ArrayLike, damping_ratio: ArrayLike | None = None
) -> FloatArray:
    """Partial sums over the orders of the twist at t = 0 on each critical speed, (m, w, q) in rad.

    Entry [c, w, j] sums the first j + 1 orders at the critical speed of order w (figures 4.16 to
    4.18 and 4.25 to 4.27; the last is the sum of all). On it the ratio r is q_j / q_w whatever the
    frequency (eq. 4.20). Without `damping_ratio` (m,) the resonant order gets the empirical
    magnifier of eq. 4.19; an order with no intensity there adds nothing.
    """
    (orders,) = floats(order)
    ratio, static = orders / orders[:, None], np.abs(excitation.deflection)
    if damping_ratio is None:
        resonant = np.eye(orders.size, dtype=bool)
        driven = static > 0.0
        bump = np.where(driven, empirical_magnifier(np.where(driven, static, 1.0)), 0.0)
        plain = magnifier(np.where(resonant, 0.0, ratio))
        factor: ComplexArray = np.where(resonant, bump[:, None, :], plain)
    else:
        factor = magnifier(ratio, np.asarray(damping_ratio, dtype=float)[:, None, None])
    return np.cumsum((factor * excitation.deflection[:, None, :]).real, axis=-1)


# ----------------------------------------------------------------------------
# Damping proportional to inertia and stiffness: the series of Rayleigh and of Caughey.
#
# Baca (2007, eq. 4.27): 2 zeta = sum_d alpha_d W^(2 d - 1), d = 0, 1 for Rayleigh. Such a series
# fits damping ratios that are given at some frequencies; between and beyond them it says what its
# powers say, and from three terms on that may be negative. It cannot stand for a damper at one
# station.
# ----------------------------------------------------------------------------


class Series(NamedTuple):
    """alpha_d in s^(2 d - 1), shape (k,), from a fit with frequencies over their largest one.

    That is `reference`; `condition` times the rounding is what coefficients may lose. `coefficient`
    is that system's own: c_d with 2 zeta = sum c_d (W / reference)^(2 d - 1).
    """

    alpha: FloatArray
    condition: float
    reference: float
    coefficient: FloatArray


def caughey_series(frequency: ArrayLike, damping_ratio: ArrayLike) -> Series:
    """The series of k terms through damping ratios (k,) at frequencies (k,) in rad/s.

    Two terms are Rayleigh's. NumericalFailure for equal or vanishing frequencies, and where fewer
    than four digits of a coefficient remain: with eight modes of an engine the powers run to
    W^13, and the coefficients beyond the first few mean little.
    """
    natural, wanted = floats(frequency, damping_ratio)
    if np.any(natural <= 0.0) or np.unique(natural).size < natural.size:
        raise NumericalFailure("a damping series needs frequencies above zero, all different")
    reference = float(natural.max())
    power = 2.0 * np.arange(natural.size) - 1.0
    system = (natural / reference)[:, None] ** power
    condition = float(np.linalg.cond(system))
    coefficient = np.linalg.solve(system, 2.0 * wanted)
    # one step of refinement
    coefficient = coefficient + np.linalg.solve(system, 2.0 * wanted - system @ coefficient)
    if condition * UNIT_ROUNDOFF > SINGULAR:
        raise NumericalFailure(
            f"a damping series of {natural.size} terms is ill conditioned here "
            f"(condition {condition:.1g}): fewer than four digits of it remain"
        )
    with np.errstate(under="ignore"):
        alpha = coefficient * reference**-power
    return Series(alpha, condition, reference, np.asarray(coefficient, dtype=np.float64))


def series_damping(series: Series, frequency: ArrayLike) -> FloatArray:
    """Damping ratios that a series gives at frequencies (...) in rad/s, above zero."""
    (natural,) = floats(frequency)
    if np.any(natural <= 0.0):
        raise NumericalFailure("a rigid mode has no damping ratio")
    power = 2.0 * np.arange(series.alpha.size) - 1.0
    return np.asarray(0.5 * (natural[..., None] / series.reference) ** power @ series.coefficient)


# ----------------------------------------------------------------------------
# Adapter: the modal route of the source, one mode at a time, named for what it is.
# ----------------------------------------------------------------------------

#: frequencies of the residual of Holzer's table, and the last over the highest natural one
_FREQUENCIES, _BEYOND = 800, 1.05
#: a first freedom that moves less than this share of the largest is a node of the mode
_NODE = 1e-9


def run_torsion_as_published(scene: Scene) -> None:
    """Emit everything for [response.torsion.as_published]."""
    setup = build_setup(scene.case)
    options = setup.torsion.as_published
    assert options is not None
    place, shape = _shapes(setup, options)
    frequency = Bounded(setup.modes.frequency[place], setup.modes.frequency_error[place])
    every, order = setup.modes.frequency, setup.drive.order
    empirical, undamped = (options.magnifier == one for one in ("empirical", "undamped"))
    ratio = 0.0 if empirical or undamped else options.damping_ratio
    zeta = np.full(len(place), ratio)
    speeds = line_speeds(setup.torsion.speeds) if setup.torsion.speeds is not None else None

    def kernel(
        lowest: FloatArray, shape: FloatArray, natural: FloatArray, torque: ComplexArray
    ) -> dict[str, Any]:
        """By the names of the results."""
        series = caughey_series(lowest, np.full(len(lowest), options.damping_ratio))
        inertia, stiffness = np.append(series.alpha, 0.0)[:2]
        excitation = modal_excitation(shape, natural, setup.model.line.inertia, torque)
        found = {
            "rayleigh_inertia": inertia,
            "rayleigh_stiffness": stiffness,
            "rayleigh_damping_ratio": series_damping(series, natural),
            "intensity": excitation.vector_sum,
            "static_twist": excitation.deflection,
        }
        if speeds is not None:
            twist = modal_twist(excitation, natural, order, speeds, zeta)
            found |= {"twist": twist.real, "twist_magnitude": np.abs(twist)}
        if not undamped:
            met = twist_on_criticals(excitation, order, None if empirical else zeta)[..., -1]
            best = np.argmax(np.abs(met), axis=1)[:, None]
            largest = np.take_along_axis(np.abs(met), best, axis=1)[:, 0]
            found |= {"twist_at_critical": met, "largest_twist": largest}
        return found

    torque = _torque(setup)
    found = with_errors(kernel, every[every > 0.0][:2], shape, frequency, torque)
    axes = {"elastic_mode": place + 1, "order": order, "speed": speeds}
    if has_holzer(scene.case):
        line = setup.model.line
        driven = np.linspace(0.0, _BEYOND * every.max(), _FREQUENCIES + 1)[1:]
        axes["frequency"] = driven / (2.0 * np.pi)

        def closing(inertia: FloatArray, stiffness: FloatArray) -> FloatArray:
            moved = line._replace(inertia=inertia, stiffness=stiffness)
            return relative_residual(moved, driven)

        found["residual"] = with_errors(closing, line.inertia, line.stiffness)
    for name, value in {"natural_frequency": frequency, **found}.items():
        scene.emit(f"{PUBLISHED}{name}", value, axes=axes)
    for name, of in (("intensity", "intensity"), ("twist", "twist_at_critical")):
        if of in found:
            best = order[np.argmax(np.abs(found[of].value), axis=1)]
            scene.emit(f"{PUBLISHED}largest_{name}_order", best, 0.0, axes)
    scene.cite(
        "modal method of the source: modal twist at crank angle zero, shape 1 at the first "
        "station; not the twist of a shaft",
        "numbers as published",
        "Baca Vasquez (2007), equations 4.17 to 4.20 and 4.27 to 4.29; docs/theory_torsion.md",
    )


def _shapes(setup: Setup, options: AsPublished) -> tuple[np.ndarray, Bounded]:
    """Places of the elastic modes asked for, shapes with 1 at the first freedom."""
    modes, shaft = setup.modes, setup.shaft
    elastic = np.flatnonzero(modes.frequency > 0.0)[: options.modes]
    if elastic.size == 0:
        raise NumericalFailure("the shaft line has no elastic mode")
    # a ring that hangs on the first station stands in front of it
    first = int(shaft.freedom[0])
    first = next((one.ring for one in shaft.dampers if one.carrier == first), first)
    angle = Bounded(modes.shape[elastic], modes.shape_error[elastic, None])
    base = angle[:, first]
    node = np.abs(base.value) < _NODE
    if np.any(node):
        raise NumericalFailure(
            f"as published, mode {elastic[node][0] + 1} is to have the angle 1 at the first "
            "freedom of the line, which stands still in it"
        )
    return elastic, angle / base[:, None]


def _torque(setup: Setup) -> Bounded:
    """Torque (m, n) of the operating speed on all freedoms, referred."""
    drive = setup.drive
    on = placed(drive.freedom, setup.model.line.inertia.size)
    return drive.torque(np.array([setup.speed]))[0] @ on
