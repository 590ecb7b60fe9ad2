"""The modal twist as published: complex factors, the source's real form, orders left out."""

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.topics.torsion_forced import orders_and_torque
from vibecalc.accuracy.topics.torsion_modes import exact_once
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup, build_setup
from vibecalc.response.torsion.as_published import modal_excitation, twist_on_criticals
from vibecalc.response.torsion.line import Line, stiffness_matrix

KEPT = (3.0, 6.0, 12.0, 18.0, 24.0)


def topics(scene: Scene) -> list[Topic]:
    """The twist of each mode on its critical speeds; nothing without damping or eq. 4.19."""
    setup = build_setup(scene.case)
    options = setup.torsion.as_published
    if options is None or not setup.model.line.inertia.all():
        return []
    ratio = None if options.magnifier == "empirical" else options.damping_ratio
    if options.magnifier == "undamped":
        return []
    line, order = setup.model.line, setup.drive.order
    _, torque = orders_and_torque(setup)
    elastic = np.flatnonzero(setup.modes.frequency > 0.0)[: options.modes]
    first = _first_freedom(setup)
    exact = exact_once(line)
    m, q, n = len(elastic), len(order), len(line.inertia)

    def scaled(shape: FloatArray) -> FloatArray:
        return np.asarray(shape[elastic] / shape[elastic, first][:, None])

    def kernel(count: float) -> Answer:
        kept = slice(0, int(count))
        found = modal_excitation(
            scaled(setup.modes.shape), setup.modes.frequency[elastic], line.inertia, torque[kept]
        )
        zeta = None if ratio is None else np.full(m, ratio)
        sums = twist_on_criticals(found, order[kept], zeta).value[..., -1]
        whole = np.zeros((m, q))
        whole[:, kept] = sums
        return Answer(whole, count * (m * n + 2.0 * m * count))

    def dense(_: float) -> Answer:
        frequency, shape = _of_symmetric(line)
        value = _twist(scaled(shape), frequency[elastic], line, torque, order, ratio)
        return Answer(value, 4.5 * n**3 / 4.0 + q * (m * n + 2.0 * m * q))

    def single_angle(_: float) -> Answer:
        """Phases by an arc tangent of one argument, which takes a half turn for none."""
        frequency, shape = setup.modes.frequency[elastic], scaled(setup.modes.shape)
        value = _twist(shape, frequency, line, torque, order, ratio, half_turn_lost=True)
        return Answer(value, q * (m * n + 2.0 * m * q))

    def reference() -> Reference:
        frequency, shape = exact()
        value = _exact_twist(scaled(shape), frequency[elastic], line, torque, order, ratio)
        return Reference(
            value, 16.0 * UNIT_ROUNDOFF,
            "modes of the symmetric form in 40 digits, rounded, then eqs. 4.20 and 4.28 in 30",
        )  # fmt: skip

    settings = tuple(sorted({*(one for one in KEPT if one < q), float(q)}))
    ladders = (
        Ladder(
            "complex factors", "all orders to the highest, each with its phase", "orders", settings,
            kernel, default=float(q), citation="Baca Vasquez 2007, equations 4.17 to 4.29",
        ),
        Ladder(
            "modes of the symmetric form", "the same with numpy.linalg.eigh", "", NOTHING_TO_SET,
            dense,
        ),
        Ladder(
            "one-argument arc tangent", "phases as the source takes them: a half turn is lost", "",
            NOTHING_TO_SET, single_angle, citation="Baca Vasquez 2007, equation 4.18",
        ),
    )  # fmt: skip
    return [
        Topic(
            "modal route as published", "twist on critical speeds",
            f"modal twist of {m} modes at crank angle zero on the critical speeds of {q} orders",
            "response/torsion/as_published/twist_at_critical", "rad", "complex multiplications",
            reference, ladders,
        )
    ]  # fmt: skip


def _first_freedom(setup: Setup) -> int:
    """Where shapes are 1: at the first station, or the ring that stands in front of it."""
    first = int(setup.shaft.freedom[0])
    return next((one.ring for one in setup.shaft.dampers if one.carrier == first), first)


def _of_symmetric(line: Line) -> tuple[FloatArray, FloatArray]:
    root = np.sqrt(line.inertia)
    square, vector = np.linalg.eigh(stiffness_matrix(line) / root / root[:, None])
    return np.sqrt(np.abs(square)), vector.T / root


def _twist(
    shape: FloatArray, frequency: FloatArray, line: Line, torque: ComplexArray, order: FloatArray,
    ratio: float | None, half_turn_lost: bool = False,
) -> FloatArray:  # fmt: skip
    """Sum of all orders at crank angle zero on each critical speed, (m, q)."""
    total = shape @ torque.T
    static = total / ((shape**2 @ line.inertia) * frequency**2)[:, None]
    r = order / order[:, None]
    below = (1.0 - r) * (1.0 + r) + 2j * (ratio or 0.0) * r
    resonant = np.eye(len(order), dtype=bool)
    factor = 1.0 / np.where(resonant & (ratio is None), 1.0, below)
    term = factor * static[:, None, :]
    if ratio is None:
        size = np.abs(static)
        bump = 3.8 / np.where(size > 0.0, size, 1.0) ** 0.25 * static
        term = np.where(resonant, bump[:, None, :], term)
    if half_turn_lost:
        with np.errstate(divide="ignore", invalid="ignore"):
            angle = np.arctan(term.imag / term.real)
        term = np.abs(term) * np.exp(1j * np.where(np.isfinite(angle), angle, 0.0))
    return np.asarray(term.real.sum(axis=-1))


def _exact_twist(
    shape: FloatArray, frequency: FloatArray, line: Line, torque: ComplexArray, order: FloatArray,
    ratio: float | None,
) -> FloatArray:  # fmt: skip
    """The same in long arithmetic."""
    import mpmath

    value = np.zeros((len(shape), len(order)))
    with mpmath.workdps(30):
        orders = [mpmath.mpf(one) for one in order.tolist()]
        for c, (own, w) in enumerate(zip(shape.tolist(), frequency.tolist(), strict=True)):
            inertia = sum(
                mpmath.mpf(a) ** 2 * mpmath.mpf(j)
                for a, j in zip(own, line.inertia.tolist(), strict=True)
            )
            static = [
                sum(mpmath.mpf(a) * mpmath.mpc(complex(t)) for a, t in zip(own, row, strict=True))
                / (inertia * mpmath.mpf(w) ** 2)
                for row in torque
            ]
            for k, met in enumerate(orders):
                total = mpmath.mpf(0)
                for j, (one, q) in enumerate(zip(static, orders, strict=True)):
                    r = q / met
                    if ratio is None and j == k:
                        size = abs(one)
                        part = one * mpmath.mpf("3.8") / mpmath.root(size, 4) if size else one
                    else:
                        part = one / (1 - r * r + 2j * mpmath.mpf(ratio or 0.0) * r)
                    total += part.real
                value[c, k] = float(total)
    return value
