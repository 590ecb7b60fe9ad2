"""Adapter, continued: who accelerates a shaft line, and what of its torques that is."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.entries.torsion_studies import TRANSIENT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_motion import acceleration_at, mean_torque, speed_at
from vibecalc.response.torsion.transient_peaks import Envelope
from vibecalc.response.torsion.transient_start import static_state


def emit_supply(scene: Scene, setup: Setup, run: TransientRun, found: Envelope) -> None:
    """The torque of the acceleration where it is largest, its source, and peaks without it."""
    system, shaft = run.system, setup.shaft
    time = np.union1d(run.borders.time, found.time)
    # a value at a border belongs to the stretch behind it: a little before it counts too
    time = np.union1d(time, np.maximum(time - 1e-9 * time[-1], 0.0))
    rate = acceleration_at(run.stretches, run.borders, time)
    place = int(np.argmax(np.abs(rate)))
    top = float(rate[place])
    axes = {"section": shaft.section_names}
    scene.emit(f"{TRANSIENT}acceleration", top, 8.0 * EPSILON * abs(top))
    inertia = system.inertia
    whole = top * float(inertia.sum())
    scene.emit(f"{TRANSIENT}acceleration_torque", whole, 1e-14 * abs(whole))
    pull = -inertia * top
    supplied = float((system.balance @ pull - pull)[shaft.load_freedom])
    # the mean torques of cylinders and loads at that moment, and what they leave to the station
    number = int(np.clip(np.searchsorted(run.borders.time, time[place], side="right") - 1, 0,
                         len(run.stretches) - 1))  # fmt: skip
    part = run.stretches[number]
    since = float(time[place] - run.borders.time[number])
    speeds = run.borders.speed[number : number + 2]
    speed = float(speed_at(run.stretches, run.borders, time[place : place + 1])[0])
    mean = mean_torque(part, speeds, speed, since)
    supplied += float((system.balance @ mean - mean)[shaft.load_freedom])
    own = float(shaft.station_ratio[shaft.load_station])
    size = abs(whole) + float(np.abs(mean).sum())
    scene.emit(f"{TRANSIENT}acceleration_supplied", supplied / own, 1e-12 * size / abs(own))
    scene.emit(f"{TRANSIENT}acceleration_supplied_at", shaft.load_station + 1, 0.0)
    carried = system.torque @ static_state(system, system.balance @ pull)
    doubt = 1e-12 * np.max(np.abs(carried), initial=0.0)
    ratio = shaft.section_ratio
    scene.emit(f"{TRANSIENT}acceleration_part", carried / ratio, doubt / np.abs(ratio), axes)
    middle = 0.5 * (found.time[:-1] + found.time[1:])
    ends = acceleration_at(run.stretches, run.borders, found.time)
    now = acceleration_at(run.stretches, run.borders, middle)
    off = np.maximum(np.abs(ends[:-1] - now), np.abs(ends[1:] - now)) / abs(top)
    own_part = np.outer(now / top, carried)
    slack = found.error + np.outer(off, np.abs(carried)) + doubt
    left = np.maximum(np.abs(found.high - own_part), np.abs(found.low - own_part))
    row, column = left.argmax(axis=0), np.arange(left.shape[1])
    error = np.maximum(slack[row, column], (left + slack).max(axis=0) - left[row, column])
    values = left[row, column] / np.abs(ratio)
    scene.emit(f"{TRANSIENT}peak_without_acceleration", values, error / np.abs(ratio), axes)
