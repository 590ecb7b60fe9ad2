"""Points per second of a sweep: by arrays, by stages that are used again, by a process for each.

All in one run, so that the ratios mean something on a busy machine: the ways take turns, and the
least time of each counts. A process for each point is `vibecalc run` on the case with its keys set.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from rows import Report, Row, Table, reported

from vibecalc.core.case.load import LoadedCase, validate
from vibecalc.core.case.raw import case_at
from vibecalc.core.case.study_tables import Sweep
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.design import Design, make_design
from vibecalc.core.study.sweep.evaluate import ArrayEvaluator, Evaluator

CASES = Path(__file__).resolve().parents[1] / "cases"
TURNS = 2
SPEED = {"key": "machine.speed", "from": "2000 rpm", "to": "4000 rpm", "points": 100}
SPEEDS = {"key": "machine.speed", "from": "1000 rpm", "to": "4700 rpm", "points": 10_000}
STIFFNESS = {"key": "machine.mounts.each.stiffness", "from": 5e3, "to": 5e4, "points": 100}
ROD = {"key": "machine.crank_train.rod_length", "from": "0.15 m", "to": "0.3 m", "points": 100}
PHASE = {"key": "machine.crank_train.cylinders[1].crank_phase", "from": 0, "to": 6, "points": 100}
RUN_UP = {"key": "isolation.run_up.to", "from": 450, "to": 600, "points": 20}
SPRINGS = {"key": "machine.mounts.each.stiffness", "from": 5e3, "to": 2e5, "points": 40}
DAMPERS = {"key": "machine.mounts.each.damping", "from": 5, "to": 500, "points": 25}
AROUND = {"key": "isolation.gravity", "from": 9.78, "to": 9.83, "points": 2}
METHOD = {"key": "response.method", "values": ["modal", "direct"]}
SKEW = {"key": "machine.motor.skew_angle", "from": "1 deg", "to": "20 deg", "points": 40}
RING = "machine.shaft_line.dampers[0]"
SPRING = {"key": f"{RING}.stiffness", "from": "300 kN*m/rad", "to": "1.2 MN*m/rad", "points": 10}
DASHPOT = {"key": f"{RING}.damping", "from": 1000, "to": 4000, "points": 10}


class Sweeping(NamedTuple):
    """A sweep to time: its case, axes and what is kept; the last axis varies fastest."""

    name: str
    case: str
    axes: tuple[dict[str, object], ...]
    keep: tuple[str, ...]
    arrays: bool


SWEEPS = (
    Sweeping("masses and balance sums over speed", "generator", (SPEED,),
             ("excitation/mass/reciprocating", "excitation/balance/total_sine"), True),
    Sweeping("largest force over rod and throw", "generator", (ROD, PHASE),
             ("excitation/force_peak", "excitation/couple_peak"), True),
    Sweeping("support force over speed and mounts", "generator", (SPEED, STIFFNESS),
             ("isolation/support_force/steady_peak",), True),
    Sweeping("mean energies over 10,000 speeds", "compressor", (SPEEDS,),
             ("response/kinetic_energy/mean", "response/potential_energy/mean"), True),
    Sweeping("1000 rigid bodies, steady force", "generator_180", (SPRINGS, DAMPERS),
             ("isolation/support_force/steady_peak",), True),
    Sweeping("1000 rigid bodies, highest of the run-up", "generator_180", (SPRINGS, DAMPERS),
             ("isolation/support_force/run_up_peak",), True),
    Sweeping("run-up over its end and gravity", "generator", (RUN_UP, AROUND),
             ("isolation/support_force/run_up_peak",), False),
    Sweeping("motor force over skew", "compressor_motor", (SKEW,),
             ("excitation/motor/peak", "excitation/force_peak"), False),
    Sweeping("energies by both methods, same operations", "compressor", (METHOD,),
             ("response/operations/kinetic_energy/peak", "response/translation_peak"), False),
    Sweeping("largest torques of a shaft line over its damper", "engine_damped", (SPRING, DASHPOT),
             ("response/torsion/largest/torque_half_range", "response/torsion/reduction"), True),
)  # fmt: skip


def rate(points: int, work: Callable[[], object]) -> float:
    """Points per second of wall time."""
    started = time.perf_counter()
    work()
    return points / (time.perf_counter() - started)


def plain(loaded: LoadedCase, design: Design, keep: tuple[str, ...], numbers: np.ndarray) -> None:
    """Each point checked and run on its own, in this process."""
    for number in numbers:
        case = validate(case_at(loaded.resolved, design.settings(int(number))))
        assert not check_machine(case)
        run_case(case, wanted=frozenset(keep))


def processes(path: Path, design: Design, numbers: np.ndarray) -> None:
    """Each point by a process of its own."""
    command = [sys.executable, "-m", "vibecalc", "run", str(path), "-q"]
    with tempfile.TemporaryDirectory() as folder:
        for number in numbers:
            settings = design.settings(int(number))
            options = [
                part for key, value in settings.items() for part in ("--set", f"{key}={value}")
            ]
            out = Path(folder) / f"{number}.h5"
            # a reference or limit that is missed is no failure of the run
            done = subprocess.run(
                [*command, "-o", str(out), *options], capture_output=True, check=False
            )
            assert out.exists(), done.stderr.decode()


def some(count: int, points: int) -> np.ndarray:
    """A few points spread over the sweep, neighbours together as in a chunk."""
    return np.arange(count) if points >= count else np.linspace(0, count - 1, points).astype(int)


def measured(sweep: Sweeping) -> dict[str, float]:
    """Best points per second of each way."""
    path = CASES / f"{sweep.case}.toml"
    (loaded,) = load_checked([path])
    design = make_design(Sweep.model_validate({"axes": sweep.axes}), loaded.resolved)
    count, keep = design.count, sweep.keep
    every, few = np.arange(count), some(count, 20)
    best: dict[str, float] = {}
    for _ in range(TURNS):
        ways: dict[str, tuple[int, Callable[[], object]]] = {
            "plain": (len(few), lambda: plain(loaded, design, keep, few)),
            "process": (2, lambda: processes(path, design, some(count, 2))),
        }
        if sweep.arrays:
            ways["arrays"] = (count, lambda: ArrayEvaluator(loaded, design, keep)(every))
        first = every[: min(count, 200)]
        ways["reuse"] = (len(first), partial(Evaluator(loaded, design, keep), first))
        for way, (points, work) in ways.items():
            best[way] = max(best.get(way, 0.0), rate(points, work))
    return best


def measure() -> Report:
    """Rates of each sweep, and the ratios to a process for each point and to runs."""
    rows, lines = [], []
    for sweep in SWEEPS:
        best = measured(sweep)
        arrays = best.get("arrays")
        lines.append(
            [sweep.name, *(f"{best[way]:.3g}" for way in ("process", "plain", "reuse")),
             f"{arrays:.3g}" if arrays else "-"]
        )  # fmt: skip
        rows.append(
            Row(sweep.name, "stages used again", "runs one after another, one process",
                best["reuse"] / best["plain"], error="equal")
        )  # fmt: skip
        if arrays:
            rows.append(
                Row(sweep.name, "by arrays", "a process for each point",
                    arrays / best["process"], error="within the estimates")
            )  # fmt: skip
            rows.append(
                Row(sweep.name, "by arrays", "runs one after another, one process",
                    arrays / best["plain"], error="within the estimates")
            )  # fmt: skip
    table = Table(
        "Points per second", ["sweep", "process", "one run after another", "reuse", "arrays"], lines
    )
    return Report(
        "Sweeps",
        f"Wall time, one thread, the best of {TURNS} turns.",
        rows,
        [table],
    )


if __name__ == "__main__":
    reported(measure)
