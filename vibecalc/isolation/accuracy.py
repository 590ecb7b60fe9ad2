"""Questions of the isolation: forces of the supports at the operating speed and over a run-up."""

from collections.abc import Callable

import numpy as np

from vibecalc.core.accuracy.kinds import Counted, forced, peak_over_cycle, peak_over_range
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.body_run_up import run_up_rows, sections
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.results import SupportForce
from vibecalc.isolation.run_up import cycle_peaks, run_up_peak
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import numbered
from vibecalc.numerics.linear import dynamics, response
from vibecalc.numerics.rounding import FloatArray
from vibecalc.response.adapters.loads import BodyLoads

#: largest force over the cycle of each support
LARGEST = paths_of(SupportForce, "steady_peak")[0]
#: why the motion of a body takes twice the least work
REFINED = 2.0, "one step of refinement costs as much as the solution"


def isolation_topics(scene: Scene) -> list[Topic]:
    """Force by order and peak over the cycle of the support with the largest; none at rest."""
    mounts, speed = scene.parts.mounts, scene.case.machine.speed
    if LARGEST not in scene.record:
        return []  # the foundation moves, and has questions of its own
    peaks = scene.record[LARGEST].values
    which = int(np.argmax(peaks))
    # the questions are of matrices that no frequency changes
    if mounts is None or mounts.spectrum is not None or not peaks[which] > 0.0:
        return []
    system: OnMounts = scene.handed_on["on_mounts"]
    readout = system.forces()
    order, load, w = driven(scene, system)
    still, rising = readout.still[which], readout.rising[which]

    def read(amplitudes: np.ndarray) -> np.ndarray:
        return np.asarray(amplitudes @ still.T + (w[:, None] * amplitudes) @ rising.T)

    name = f"support {mounts.names[which]!r} at {speed:.6g} rad/s, {len(order)} orders"
    path = paths_of(SupportForce, "steady_harmonics")[0]
    ask = Ask("support force by order", name, path, 4.0,
              "guard orders are solved for the error estimate")  # fmt: skip
    angle = "half the crank angle [rad]" if order[0] < 1.0 else "crank angle [rad]"
    rows = read(_motion(system, load, w)).T
    peak = peak_over_cycle(
        Ask("largest support force", name, LARGEST), rows, numbered(order), angle
    )
    return [*motion_topic(ask, system, load, w, read), peak]


def driven(scene: Scene, system: OnMounts) -> tuple[FloatArray, Bounded, FloatArray]:
    """Orders (m,) kept, what they load the system with (m, f), and their frequencies."""
    loads: BodyLoads = scene.handed_on["loads"]
    order = loads.order[: loads.retained]
    return order, system.felt(loads.load[: loads.retained]), order * scene.case.machine.speed


def motion_topic(
    ask: Ask,
    system: OnMounts,
    load: Bounded,
    w: FloatArray,
    read: Callable[[np.ndarray], np.ndarray] = np.asarray,
) -> list[Topic]:
    """Motion under loads (m, f) at frequencies (m,), as `read` shows it; none where none acts, or
    where frequencies change the matrices."""
    known = _known(load)
    if system.spectral is not None or not np.any(known):
        return []

    def own(_: float) -> Answer:
        return Answer(read(_motion(system, load, w)), 2.0 * len(w))

    solver = Solver("inverse and one step", own)
    return [forced(ask, [solver], system.matrices, w, known, read)]


def _known(load: Bounded) -> np.ndarray:
    """Loads without what is nothing but rounding."""
    return np.where(np.abs(load.value) > load.error, load.value, 0.0)


def _motion(system: OnMounts, load: Bounded, w: FloatArray) -> np.ndarray:
    """Motion (m, f) under loads (m, f) at frequencies (m,)."""
    known = _known(load)
    return response(dynamics(system.matrices, w), known, np.zeros(known.shape)).value


def run_up_topics(scene: Scene) -> list[Topic]:
    """The largest force of a support at any speed; none where all grow without bound."""
    if isolation_of(scene).run_up is None:
        return []
    parts, every = sections(scene), []
    read = run_up_rows(scene, parts[0].system)
    for given in [part.given(read.rows, read.shows, True) for part in parts]:
        value, _, place, _ = run_up_peak(given)
        rows = np.unique(read.row_of[read.lever_rows :])
        rows = rows[np.isfinite(value[rows]) & (value[rows] > 0.0)]
        every += [(value[row], float(place[row]), row, given) for row in rows.tolist()]
    if not every:
        return []
    _, known, row, given = max(every, key=lambda one: one[0])
    ends = float(given.start), float(given.stop)

    def curve(speed: FloatArray) -> FloatArray:
        return np.asarray(cycle_peaks(given.harmonics_at, given.orders, speed).value[:, row])

    def alone(_: float) -> Answer:
        rows = Counted(given.harmonics_at)
        peak = run_up_peak(given._replace(harmonics_at=rows))
        return Answer(peak.value[[row]], float(rows.asked), float(peak.speed[row]))

    ask = Ask("largest force of the run-up", f"from {ends[0]:.6g} to {ends[1]:.6g} rad/s",
              "isolation/support_force/run_up_peak", 50.0,
              "all supports, and every resonance, so that no narrow one is missed")  # fmt: skip
    solver = Solver("resonances and peaks", alone)
    return [peak_over_range(ask, solver, curve, ends, known, "crank speed [rad/s]", "speeds")]
