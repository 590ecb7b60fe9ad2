"""The crank angles from which a machine at rest starts at all, for the start-up stage."""

import numpy as np

from vibecalc.case.roll_tables import StartUp
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.entries.start_up import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.start_up_angles import start_angles
from vibecalc.response.roll.start_up_states import Load

#: rad, within which every border is enclosed
WIDTH = 1e-5
#: of one step of these marches, which moves the borders by less
TOLERANCE = 1e-6


def emit_start_angles(
    scene: Scene, options: StartUp, machine: RollMachine, drive: RollDrive
) -> None:
    """Emit the intervals of angles, under the largest load of the case from the start on."""
    assert options.angles is not None
    largest = 1.0 if options.load is None else max(options.load.factor)
    found = start_angles(
        machine,
        drive,
        duration=options.start_within or options.duration,
        angles=options.angles,
        load=Load(np.zeros(1), np.array([largest])),
        width=WIDTH,
        tolerance=TOLERANCE,
    )
    stem = f"{ROOT}/start_angles"
    starts = np.asarray(found.starts, dtype=np.int64)
    scene.emit(f"{stem}/starts", starts, 0.0, {"start_angle": found.angle})
    axes = {"start_interval": np.arange(1, len(found.interval) + 1)}
    for column, name in enumerate(("lower", "upper")):
        scene.emit(f"{stem}/{name}", found.interval[:, column], found.error + TOLERANCE, axes)
    moved = 2 * len(found.interval) * TOLERANCE / (2.0 * np.pi)
    error = found.fraction_error + moved + 8.0 * EPSILON
    scene.emit(f"{stem}/fraction", found.fraction, error)
    if found.islands:
        scene.warn(
            "start angles: between two that start and do not, more than one border was found; "
            "there are probably more, which more angles may show"
        )
    dry = machine.friction_torque > 0.0 or machine.piston_friction > 0.0
    if 0.0 < found.fraction < 1.0 and not dry:
        scene.warn(
            "start angles: without dry friction a machine that rocks may get over at a later "
            "swing, so that its start angles depend on the time allowed, "
            f"{options.start_within or options.duration:.6g} s"
        )
