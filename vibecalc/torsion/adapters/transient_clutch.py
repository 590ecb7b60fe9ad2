"""A clutch of a case that takes one part of the line along: the run, and what the clutch does."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.adapters.transient_motion import Journey, dampable, torques
from vibecalc.torsion.line import Line, part_of
from vibecalc.torsion.question_tables import Transient
from vibecalc.torsion.shaft_line_tables import Layout
from vibecalc.torsion.study_results import TRANSIENT
from vibecalc.torsion.transient.clutch import Clutch, Engagement, engage, slip_view
from vibecalc.torsion.transient.march import TransientRun
from vibecalc.torsion.transient.motion import Stretch, stretch

# ----------------------------------------------------------------------------
# Clutch-in: before it each part turns steadily. What keeps it so, the governor of the engine and
# what drives or brakes the other part, goes on unchanged, so that mean torques are left out and the
# friction of the clutch alone moves momentum from one part to the other.
# ----------------------------------------------------------------------------

#: times of the slip that are kept
_TIMES = 400


def run_clutch(
    scene: Scene, setup: Setup, options: Transient, rtol: float
) -> tuple[Journey, TransientRun]:
    """The run with what lasts after it; emits what the clutch does."""
    assert options.clutch is not None and options.driven_speed is not None
    assert options.friction_torque is not None
    line, equivalent = dampable(setup, options)
    parts = scene.case.machine.shaft_line
    assert parts is not None
    shaft, speed, cycle = setup.shaft, setup.speed, setup.drive.firing.cycle
    element = shaft.section_names.index(options.clutch)
    ratio = abs(float(shaft.section_ratio[element]))
    joined = np.arange(line.stiffness.size) != element
    part = part_of(line, joined)
    clutch = Clutch(
        element,
        options.friction_torque * ratio,
        options.engaging_time or 0.0,
        np.asarray(part != part[shaft.freedom[Layout(parts).crank]]),
        options.driven_speed / ratio,
    )
    order = np.append(0.0, setup.drive.order)
    before = options.time_before or cycle / speed

    def vibrating(at: float) -> Stretch:
        gas, inertia = torques(setup, at)
        gas[:, 0] = 0.0
        return stretch(1.0, 0.0, gas, inertia)

    found = engage(line, order, clutch, vibrating, speed, before, options.time_after, cycle, rtol)
    _emit_clutch(scene, setup, line, clutch, found, ratio, before)
    scene.warn(
        "clutch-in: both parts of the line turn steadily before it; the torques that balance their "
        "means are assumed constant, and only the friction of the clutch changes the speeds"
    )
    held = np.isfinite(found.held)
    ends = (vibrating(found.common_speed),) if held else ()
    path = Journey(
        line, order, found.run.course.parts, found.common_speed, "steady", None, (0.0, 0.0), ends,
        equivalent,
    )  # fmt: skip
    return path, found.run


def _emit_clutch(
    scene: Scene, setup: Setup, line: Line, clutch: Clutch, found: Engagement, ratio: float,
    before: float,
) -> None:  # fmt: skip
    """Slip, heat and common speed; torques and speeds of the clutch on its own shaft."""
    run, stem = found.run, f"{TRANSIENT}clutch/"
    # the errors of the torques, as energies, in the velocities of the two ends
    energy = run.torque_error / np.sqrt(np.where(line.stiffness > 0.0, line.stiffness, np.inf))
    ends = line.inertia[[line.first[clutch.element], line.second[clutch.element]]]
    slack = float(np.max(energy) / np.sqrt(np.min(ends))) + 1e-12 * setup.speed
    inertia = np.array([line.inertia[~clutch.driven].sum(), line.inertia[clutch.driven].sum()])
    rate = clutch.friction_torque * float((1.0 / inertia).sum())
    late = 2.0 * (1 + found.engagements) * slack / rate + 1e-12 * float(run.course.time[-1])
    scene.emit(f"{stem}slip_time", found.slip_time, late)
    heat_error = found.heat_error + clutch.friction_torque * slack * found.slip_time
    scene.emit(f"{stem}heat", found.heat, heat_error)
    scene.emit(f"{stem}engagements", found.engagements, 0.0)
    if np.isfinite(found.held):
        scene.emit(f"{stem}held", found.held - before, late)
        scene.emit(f"{stem}common_speed", found.common_speed, 1e-12 * setup.speed + rate * late)
        use_error = float(run.torque_error[clutch.element]) / clutch.friction_torque + 1e-12
        scene.emit(f"{stem}utilisation", found.use, use_error)
    else:
        scene.warn(
            f"the clutch still slips after {float(run.course.time[-1]) - before:.4g} s: "
            "increase `time_after` to reach the common speed of both parts"
        )
    time, slip = _slips(line, clutch, found)
    scene.emit(f"{stem}slip_speed", ratio * slip, ratio * slack, {"clutch_time": time})


def _slips(line: Line, clutch: Clutch, found: Engagement) -> tuple[FloatArray, FloatArray]:
    """Times in s and slips in rad/s, referred, at ends of steps."""
    times, values = [], []
    run, last = found.run, found.run.blocks[-1]
    for block, states in zip(run.blocks, run.states, strict=True):
        since = float(run.course.time[block.stretch]) + block.offset
        kept = states if block is last else states[:-1]
        times.append(since + block.step * np.arange(len(kept)))
        slips = found.slip[block.stretch] != 0
        view = (
            slip_view(run.drive.systems[block.stretch], line, clutch) if slips else 0.0 * states[0]
        )
        values.append(kept @ view)
    time, value = np.concatenate(times), np.concatenate(values)
    every = max(1, -(-len(time) // _TIMES))
    return time[::every], value[::every]
