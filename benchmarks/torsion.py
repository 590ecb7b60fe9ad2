"""Torsion of shaft lines against opentorsion, on the same lines in one run.

Forced response of 7 inertias (six throws driven, and one) and of 200 at 30 orders x 2500 speeds,
error estimate on and off; modes of 200 inertias. mpmath decides where both differ most who is off.
opentorsion solves a sample of the frequencies of the long line, scaled up. CPU time, one thread,
the ways taking turns, least of some repeats.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mpmath
import numpy as np
from rows import Report, Row, Table, reported, seconds
from timing import in_turns

from vibecalc.torsion.forced import forced
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.modes import natural_modes

SPEEDS, ORDERS = np.linspace(20.0, 300.0, 2500), np.arange(1, 31) * 0.5
HARD = ("uniform", "alternating", "graded stiffness", "graded", "weak link")


def engine() -> Line:
    """The seven inertias of the published engine, with dashpots in shafts and at throws."""
    line = chain(np.array([18.64] * 6 + [2655.0]), np.array([22.82e6] * 5 + [19.21e6]))
    return line._replace(
        damping=1e-5 * line.stiffness, absolute_damping=np.array([5.0] * 6 + [0.0])
    )


def long_line(count: int = 200) -> Line:
    """So many inertias of random size with dashpots in their shafts."""
    generator = np.random.default_rng(1)
    stiffness = 1e6 * (1.0 + generator.random(count - 1)) * count / 7
    line = chain(0.05 + 0.1 * generator.random(count), stiffness)
    return line._replace(damping=1e-5 * stiffness)


def hard_line(name: str) -> Line:
    """200 inertias of one of the `HARD` kinds."""
    inertia, stiffness = np.ones(200), np.ones(199)
    if name == "alternating":
        stiffness[1::2] = 1e6
    if name.startswith("graded"):
        stiffness = np.geomspace(1.0, 1e6, 199)
    if name == "graded":
        inertia = np.geomspace(1.0, 1e6, 200)
    if name == "weak link":
        stiffness[99] = 1e-6
    return chain(inertia, stiffness)


def assembly(line: Line) -> object:
    """The same line for opentorsion."""
    import opentorsion

    shafts = [
        opentorsion.Shaft(i, i + 1, k=float(k), c=float(c))
        for i, (k, c) in enumerate(zip(line.stiffness, line.damping, strict=True))
    ]
    disks = [
        opentorsion.Disk(i, I=float(j), c=float(c))
        for i, (j, c) in enumerate(zip(line.inertia, line.absolute_damping, strict=True))
    ]
    return opentorsion.Assembly(shafts, disk_elements=disks)


def exact(line: Line, w: float, torque: np.ndarray) -> np.ndarray:
    """Angles of a row from its tridiagonal equations in 40 digits."""
    with mpmath.workdps(40):
        at = mpmath.mpf(w)
        k = [mpmath.mpc(a, at * b) for a, b in zip(line.stiffness, line.damping, strict=True)]
        d = [
            mpmath.mpc(-at * at * a, at * b)
            for a, b in zip(line.inertia, line.absolute_damping, strict=True)
        ]
        x = [mpmath.mpc(complex(one)) for one in torque]
        for e, one in enumerate(k):
            d[e] += one
            d[e + 1] += one
        for e, one in enumerate(k):
            d[e + 1] -= one * one / d[e]
            x[e + 1] += one / d[e] * x[e]
        x[-1] /= d[-1]
        for e in range(len(k) - 1, -1, -1):
            x[e] = (x[e] + k[e] * x[e + 1]) / d[e]
        return np.array([complex(one) for one in x])


def response(
    name: str, line: Line, driven: int, sample: int, repeats: dict[str, int], aim: float
) -> list[Row]:
    """Ratio and difference of the forced response, with the error estimate and without."""
    generator, w = np.random.default_rng(3), SPEEDS[:, None] * ORDERS
    torque = generator.normal(size=(*w.shape, driven)) + 1j * generator.normal(
        size=(*w.shape, driven)
    )
    stations, n = list(range(driven)), len(line.inertia)
    taken = generator.permutation(w.size)[:sample]
    load = np.zeros((n, sample), dtype=complex)
    load[:driven] = torque.reshape(-1, driven)[taken].T
    other, at = assembly(line), w.ravel()[taken]
    took = in_turns(
        {
            "other": lambda: other.ss_response(load, at),  # type: ignore[attr-defined]
            "ours": lambda: forced(line, w, torque, stations=stations),
            "quick": lambda: forced(line, w, torque, stations=stations, estimate=False),
        },
        repeats,
    )
    theirs = took["other"] * w.size / sample
    found = forced(line, w, torque, stations=stations)
    ours, uncertainty = found.angle.reshape(-1, n)[taken].T, found.error.ravel()[taken]
    their = other.ss_response(load, at)[0]  # type: ignore[attr-defined]
    largest = np.max(np.abs(ours), axis=0)
    apart = np.max(np.abs(ours - their), axis=0) / largest
    worst = np.zeros(3)
    for i in np.argsort(apart)[-5:]:
        true = exact(line, float(at[i]), load[:, i])
        size = np.max(np.abs(true))
        off = [float(np.max(np.abs(one[:, i] - true)) / size) for one in (ours, their)]
        worst = np.maximum(worst, [*off, uncertainty[i] / size])
    return [
        Row(
            f"forced response of {name}, {driven} driven, {w.size} solves", label,
            "opentorsion ss_response", theirs / took[way], aim,
            f"{worst[0]:.0e} ({worst[1]:.0e})" + (f", estimated {worst[2]:.0e}" * (way == "ours")),
            f"{seconds(took[way])} against {seconds(theirs)}",
        )
        for label, way in (("with error estimate", "ours"), ("without estimate", "quick"))
    ]  # fmt: skip


def below(line: Line, frequency: mpmath.mpf) -> int:
    """Modes below a frequency in 40 digits (signs of the elimination)."""
    d = [-(frequency**2) * mpmath.mpf(j) for j in line.inertia.tolist()]
    number = 0
    for e, k in enumerate(line.stiffness.tolist()):
        whole = d[e] + k
        number += whole < 0
        d[e + 1] += k * d[e] / whole
    return number + int(d[-1] < 0)


def true_frequency(line: Line, number: int, near: float) -> mpmath.mpf:
    """Natural frequency of a mode in 40 digits, by halving what the counts hold."""
    low, high = (
        mpmath.mpf(near) * (1 - mpmath.mpf("1e-9")),
        mpmath.mpf(near) * (1 + mpmath.mpf("1e-9")),
    )
    assert below(line, low) <= number < below(line, high)
    for _ in range(36):
        mid = (low + high) / 2
        low, high = (low, mid) if below(line, mid) > number else (mid, high)
    return (low + high) / 2


def modes() -> tuple[list[Row], Table]:
    """Modes of 200 inertias: times of both and their worst errors over some modes."""
    rows, lines = [], []
    for name in HARD:
        line = hard_line(name)
        other = assembly(line)
        took = in_turns(
            {
                "modal": lambda o=other: o.modal_analysis(),  # type: ignore[misc,attr-defined]
                "eig": lambda o=other: o.undamped_modal_analysis(),  # type: ignore[misc,attr-defined]
                "ours": lambda one=line: natural_modes(one),  # type: ignore[misc]
            },
            {"modal": 2, "eig": 4, "ours": 12},
        )
        ours = natural_modes(line).frequency
        square = other.undamped_modal_analysis()[0]  # type: ignore[attr-defined]
        their = np.sort(np.sqrt(np.abs(square)))
        worst = [0.0, 0.0]
        with mpmath.workdps(40):
            for number in [1, 2, 3, 5, 20, 50, 99, 100, 101, 150, 198, 199]:
                true = true_frequency(line, number, float(ours[number]))
                for place, one in enumerate((their, ours)):
                    off = float(abs(mpmath.mpf(float(one[number])) - true) / true)
                    worst[place] = max(worst[place], off)
        rows.append(
            Row(f"modes of 200 inertias, {name}", "vibecalc", "opentorsion, eigenvalues of K and M",
                took["eig"] / took["ours"], 10.0, f"{worst[1]:.0e} ({worst[0]:.0e})",
                f"{seconds(took['ours'])} against {seconds(took['eig'])}; modal_analysis "
                f"{seconds(took['modal'])}")
        )  # fmt: skip
        lines.append([name, f"{their[0]:.0e}", f"{ours[0]:.0e}"])
    columns = ["row of 200", "opentorsion", "vibecalc"]
    return rows, Table("The rigid mode, rad/s (zero)", columns, lines)


def measure() -> Report:
    """Forced response and modes."""
    few = {"other": 2, "ours": 8, "quick": 8}
    short, long = ("7 inertias", engine()), ("200 inertias", long_line())
    rows = [row for driven in (6, 1) for row in response(*short, driven, 75000, few, 150.0)]
    few = {"other": 2, "ours": 3, "quick": 3}
    rows += [row for driven in (1, 6) for row in response(*long, driven, 200, few, 400.0)]
    found, rigid = modes()
    return Report(
        "Torsion of shaft lines",
        "Errors are relative to the largest angle of a frequency, at the five frequencies of the "
        "sample at which both differ most, and of 12 modes, against 40 digits; in brackets those "
        "of opentorsion. With 200 inertias 200 of its frequencies were timed and scaled up.",
        [*rows, *found],
        [rigid],
    )


if __name__ == "__main__":
    reported(measure)
