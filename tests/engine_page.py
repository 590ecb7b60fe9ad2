"""Numbers of chapter 4 of Baca Vasquez (2007) for docs/validation_engine.md.

Printed, as the source came to them, and right; units are those of the printed number.
"""

from functools import cache

import engine_source as source
import numpy as np
from engine_as_published import ORDER, full_torque, modes
from pages import Row

from vibecalc.parts.firing import CYCLES, angles_in_order
from vibecalc.torsion.adapters.as_published import (
    caughey_series,
    modal_excitation,
    series_damping,
    twist_on_criticals,
)
from vibecalc.torsion.line import chain
from vibecalc.torsion.modes import natural_modes

#: slips of Appendices IV to VI; the right way next to it
PROGRAM = {"speed": source.SPEED_OF_PROGRAM, "slip_44": True, "slip_43": True, "phases": 2}
RIGHT = {"speed": source.SPEED_OF_TEXT}
FREQUENCIES = {
    7: ("0", "264.15", "767.52", "1235.91", "1639.16", "1949.90", "2145.93"),
    8: ("0", "135.05", "286.43", "773.29", "1238.70", "1640.55", "1950.49", "2146.07"),
}


@cache
def line_modes(freedoms: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (n,) and shapes (n, n) by rows, one at the first station."""
    damped = freedoms == 8
    found = natural_modes(
        chain(
            source.DAMPED_INERTIA if damped else source.INERTIA,
            source.DAMPED_STIFFNESS if damped else source.STIFFNESS,
        )
    )
    return found.frequency, found.shape / found.shape[:, :1]


def data() -> tuple[Row, ...]:
    order = [str(one) for one in source.FIRING_ORDER]
    angle = angles_in_order(order, (), CYCLES["four_stroke"], 0.0)
    inertia = source.DAMPER_MASS_RATIO * 6 * source.CYLINDER_INERTIA
    ratio = source.DAMPER_STIFFNESS_RATIO
    return (
        *(
            Row(f"4.2.4, firing angle, deg, cylinder {n + 1}", f"{printed:.0f}",
                float(np.degrees(angle[str(n + 1)])), None, "reproduced")
            for n, printed in enumerate(np.degrees(source.FIRING_ANGLE))
        ),
        Row("Appendix II, rows of the card", "74", float(len(source.CARD_BAR)), None, "misprint",
            "360 degrees twice, with one pressure"),
        Row("4.4.2.1, J_E1, kg m^2", "27.5126", inertia, None, "reproduced"),
        Row("4.4.2.1, K_E1, N m/rad", "5.9712e5", ratio * source.THROW_STIFFNESS / 6.0, None,
            "reproduced", "0.157 of a sixth of one throw; the printed formula is six springs in "
            "series and gives 5.790e5"),
    )  # fmt: skip


def frequencies() -> tuple[Row, ...]:
    return tuple(
        Row(f"{place}, rad/s, mode {m + 1}", text, float(line_modes(n)[0][m]), None, "reproduced")
        for n, place in ((7, "4.4.1.1"), (8, "4.4.2.2"))
        for m, text in enumerate(FREQUENCIES[n])
    )


def damping() -> tuple[Row, ...]:
    natural = line_modes(8)[0][1:]
    series = caughey_series(natural[:2], [source.PRIMARY_DAMPING_RATIO] * 2)
    ratio = series_damping(series, natural)
    unused = "Rayleigh damping; Appendix VI has 0.01 for every mode"
    return (
        Row("4.4.2.3, alpha0, 1/s", "1.8355", float(series.alpha[0]), None, "reproduced"),
        Row("4.4.2.3, alpha1, s", "4.7452e-5", float(series.alpha[1]), None, "reproduced"),
        *(
            Row(f"4.4.2.3, zeta{m}", text, float(ratio[m - 2]), None, "reproduced", unused)
            for m, text in zip(range(4, 9), ("0.0195", "0.0301", "0.0395", "0.0467", "0.0513"),
                               strict=True)
        ),
    )  # fmt: skip


def criticals() -> tuple[Row, ...]:
    rows = []
    for (n, mode), speeds in source.CRITICAL_SPEED.items():
        place = {7: "4.4.1.3", 8: "4.4.2.4"}[n]
        frequency = float(line_modes(n)[0][mode - 1])
        for w, speed in zip(source.CRITICAL_W, speeds, strict=True):
            text = "1535" if speed == 1535.0 else f"{speed:.1f}"
            verdict, reason = {
                89.9: ("misprint", "digits swapped"),
                270.2: ("compatible", "twice the rounded 135.1"),
            }.get(speed, ("reproduced", ""))
            label = f"{place}, {n} dof, mode {mode}, w = {w}"
            rows.append(Row(label, text, 2.0 * frequency / w, None, verdict, reason))
    for (n, mode), old in source.OLD_FREQUENCY.items():
        rows.append(
            Row(f"captions, {n} dof, rad/s, mode {mode}", f"{old:.1f}",
                float(line_modes(n)[0][mode - 1]), None, "misprint",
                "frequency of an earlier damper; the speeds beside it are right")
        )  # fmt: skip
    return tuple(rows)


def excitation(freedoms: int, **case: object):
    frequency, shape, inertia = modes(freedoms)
    torque = full_torque(freedoms, **case)
    return modal_excitation(shape[1:4], frequency[1:4], inertia, torque)


@cache
def _largest(freedoms: int, program: bool) -> tuple[float, ...]:
    found = excitation(freedoms, **(PROGRAM if program else RIGHT))
    return tuple((np.argmax(np.abs(found.vector_sum), axis=1) + 1.0).tolist())


def intensities() -> tuple[Row, ...]:
    rows = []
    for n, figure in ((7, "Fig. 4.15"), (8, "Fig. 4.24")):
        for place, printed in enumerate(source.LARGEST_HARMONIC[n]):
            right, slipped = _largest(n, False)[place], _largest(n, True)[place]
            same = right == printed
            rows.append(
                Row(f"{figure}, harmonic of mode {place + 2}", str(printed), right,
                    None if same else slipped, "reproduced" if same else "with the slip",
                    "" if same else "firing phase twice, and 800 rad/s for 400")
            )  # fmt: skip
    return tuple(rows)


@cache
def largest_twists(freedoms: int, program: bool, **changes: object) -> tuple[float, ...]:
    """Largest |twist at t = 0| over the 30 critical speeds, modes 2 to 4."""
    found = excitation(freedoms, **(PROGRAM if program else RIGHT) | changes)
    if program:
        given = found.deflection
        real = given.real
        if freedoms == 7:
            # atan(b / a) of the source: every cosine comes out positive
            found = found._replace(deflection=np.abs(real) + 1j * given.imag)
        else:
            turned = np.where(real < 0.0, -given, given)
            found = found._replace(deflection=turned)
    ratio = None if freedoms == 7 else [0.01] * 3
    total = twist_on_criticals(found, ORDER, ratio)[..., -1]
    return tuple(np.abs(total).max(axis=1).tolist())


def twists() -> tuple[Row, ...]:
    seven, eight, slipped = (largest_twists(*one) for one in ((7, 0), (8, 0), (8, 1)))
    late = "mode {}, one figure late; firing phase twice, 800 rad/s, quadrant lost, 0.01 for all"
    other = "nearest: {}, in another mode; the empirical magnifier depends on its scale"
    return (
        Row("Fig. 4.16, mode 2, rad", "16.25e-5", seven[0], None, "not reproducible",
            other.format("1.66e-4")),
        Row("Fig. 4.17, mode 3, rad", "20e-3", seven[1], None, "not reproducible",
            other.format("1.96e-4, so that the exponent is -5")),
        Row("Fig. 4.26, mode 3, rad", "3.6e-3", eight[1], slipped[0], "compatible",
            late.format(2) + "; read off a figure"),
        Row("Fig. 4.27, mode 4, rad", "9e-4", eight[2], slipped[1], "with the slip",
            late.format(3)),
    )  # fmt: skip


SECTIONS = {
    "1. Data: firing, card, damper": data,
    "2. Natural frequencies": frequencies,
    "4. Rayleigh damping": damping,
    "5. Critical speeds": criticals,
    "6. Harmonics of largest intensity": intensities,
    "7. Largest modal twists": twists,
}
