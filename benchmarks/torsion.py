"""Torsion of shaft lines against opentorsion, on the same lines in one run.

Forced response of 7 inertias (all six throws driven) and of 200 at 30 orders x 2500 speeds, error
estimate on and off; modes of 200 inertias; a whole command against `import numpy, h5py`; memory
against the number of speeds. Differences are relative to the largest response of the frequency;
mpmath decides at the worst ones who is off. opentorsion solves a sample of the frequencies of the
long line, scaled up. CPU time, one thread, the ways taking turns, least of some repeats.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mpmath
import numpy as np

from vibecalc.response.torsion.forced import forced
from vibecalc.response.torsion.line import Line, chain
from vibecalc.response.torsion.modes import natural_modes

SPEEDS, ORDERS = np.linspace(20.0, 300.0, 2500), np.arange(1, 31) * 0.5
CASE = Path(__file__).resolve().parents[1] / "cases" / "engine_damped.toml"
HARD = ("uniform", "alternating", "graded stiffness", "graded", "weak link")


def engine() -> Line:
    """The seven inertias of the published engine, with dashpots in shafts and at throws."""
    line = chain(np.array([18.64] * 6 + [2655.0]), np.array([22.82e6] * 5 + [19.21e6]))
    return line._replace(
        damping=1e-5 * line.stiffness, absolute_damping=np.array([5.0] * 6 + [0.0])
    )


def long_line() -> Line:
    """200 inertias of random size with dashpots in their shafts."""
    generator = np.random.default_rng(1)
    stiffness = 1e6 * (1.0 + generator.random(199)) * 200 / 7
    line = chain(0.05 + 0.1 * generator.random(200), stiffness)
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


def in_turns(ways: dict[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """Least CPU seconds of each way, the ways taking turns."""
    least = dict.fromkeys(ways, np.inf)
    for _ in range(repeats):
        for name, work in ways.items():
            start = time.process_time()
            work()
            least[name] = min(least[name], time.process_time() - start)
    return least


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


def response(name: str, line: Line, driven: int, sample: int, repeats: int) -> None:
    """Ratio and difference of the forced response."""
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
    print(f"{name}, {driven} driven, {w.size} solves: opentorsion {theirs:.2f} s")
    for label, way in (("with error estimate", "ours"), ("without", "quick")):
        print(f"  {label:20}{1e3 * took[way]:8.1f} ms {theirs / took[way]:8.0f} times")
    found = forced(line, w, torque, stations=stations)
    ours, doubt = found.angle.reshape(-1, n)[taken].T, found.error.ravel()[taken]
    their = other.ss_response(load, at)[0]  # type: ignore[attr-defined]
    largest = np.max(np.abs(ours), axis=0)
    apart = np.max(np.abs(ours - their), axis=0) / largest
    over_all = float(np.max(np.abs(ours - their)) / np.max(largest))
    print(f"  difference {over_all:.1e} of the largest response, at worst {apart.max():.1e} of")
    print(f"  that of its frequency; our estimate there {np.max(doubt / largest):.1e} at most")
    print("  against 40 digits at the worst five, opentorsion, ours, our estimate:")
    for i in np.argsort(apart)[-5:]:
        true = exact(line, float(at[i]), load[:, i])
        size = np.max(np.abs(true))
        a, b = (float(np.max(np.abs(one[:, i] - true)) / size) for one in (their, ours))
        print(f"    {at[i]:10.3f} rad/s {a:9.1e} {b:9.1e} {doubt[i] / size:9.1e}")


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


def modes() -> None:
    """Modes of 200 inertias: times of both and their worst errors over some modes."""
    print("modes of 200 inertias: opentorsion / ours, worst relative error of 12 modes, rigid mode")
    for name in HARD:
        line = hard_line(name)
        other = assembly(line)
        took = in_turns(
            {
                "modal": lambda o=other: o.modal_analysis(),  # type: ignore[misc,attr-defined]
                "eig": lambda o=other: o.undamped_modal_analysis(),  # type: ignore[misc,attr-defined]
                "ours": lambda one=line: natural_modes(one),  # type: ignore[misc]
            },
            3,
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
        print(
            f"  {name:18}{1e3 * took['ours']:7.2f} ms; eig(K, M) {took['eig'] / took['ours']:5.0f},"
            f" modal_analysis {took['modal'] / took['ours']:6.0f} times; errors {worst[0]:.0e},"
            f" ours {worst[1]:.0e}; rigid {their[0]:.0e}, ours {ours[0]:.0e}"
        )


def cpu_of(command: list[str], repeats: int) -> float:
    """Median CPU seconds of a command in a fresh process, after one to fill the caches."""
    spent = []
    for _ in range(repeats + 1):
        before = os.times()
        subprocess.run(command, check=True, capture_output=True)
        after = os.times()
        spent.append(
            after.children_user - before.children_user
            + after.children_system - before.children_system
        )  # fmt: skip
    return statistics.median(spent[1:])


def whole_command() -> None:
    """`vibecalc run` on the damped engine against the two imports."""
    yardstick = cpu_of([sys.executable, "-c", "import numpy, h5py"], 7)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "vibecalc", "run", str(CASE), "-q", "-o", folder + "/"]
        try:
            ours = cpu_of(command, 3)
        except subprocess.CalledProcessError as error:
            print(f"vibecalc run {CASE.name} ended with exit code {error.returncode}")
            return
    print(
        f"vibecalc run {CASE.name}: {ours:.2f} s CPU, import numpy, h5py {yardstick:.3f} s: "
        f"{ours / yardstick:.1f} times"
    )


def memory() -> None:
    """Peak of what blocks of 64 speeds hold beside their input, against the number of speeds."""
    line = engine()
    torque = np.ones((len(ORDERS), 7), dtype=complex)
    for count in (2500, 10000, 40000):
        w = np.linspace(20.0, 300.0, count)[:, None] * ORDERS
        tracemalloc.start()
        largest = 0.0
        for start in range(0, count, 64):
            block = forced(line, w[start : start + 64], torque)
            largest = max(largest, float(np.max(np.abs(block.angle))))
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        print(f"memory of {count * len(ORDERS):8} solves by blocks: {peak / 2**20:.2f} MiB")


if __name__ == "__main__":
    response("7 inertias", engine(), 6, 75000, 9)
    response("7 inertias", engine(), 1, 75000, 9)
    response("200 inertias", long_line(), 1, 400, 7)
    response("200 inertias", long_line(), 6, 400, 7)
    modes()
    memory()
    whole_command()
    sys.exit(0)
