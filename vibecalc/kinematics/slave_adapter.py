"""Adapter of slave rods: strokes, dead centres and harmonics of each piston of such a train."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.kinematics.articulated_rod import (
    SlaveRods,
    dead_centres,
    harmonics_of_turn,
    slave_motion,
)
from vibecalc.kinematics.results import OfCylinders
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.articulated import Slaves, build_slaves
from vibecalc.parts.crank_train import CrankTrain

Paths = tuple[FloatArray, FloatArray, FloatArray]


def slave_rods(train: CrankTrain, slaves: Slaves) -> SlaveRods:
    """Lengths and angles of slave rods, one a line."""
    at, on = slaves.cylinder, slaves.master
    return SlaveRods(
        float(train.crank_radius),
        float(train.rod_length),
        float(train.wrist_pin_offset),
        train.crank_phase[at][:, None],
        train.bank_angle[on][:, None],
        train.bank_angle[at][:, None],
        slaves.knuckle_radius[:, None],
        slaves.knuckle_angle[:, None],
        slaves.rod_length[:, None],
    )


def emit_cylinders(scene: Scene, highest: int) -> None:
    """Emit what each piston does, of slaves and of the others, over the angle of the crank."""
    train, speed = scene.parts.crank_train, scene.case.machine.speed
    slaves = build_slaves(scene.case.machine.crank_train)
    rods = slave_rods(train, slaves)
    turned = (train.crank_phase - train.bank_angle)[:, None]

    def paths(angle: FloatArray) -> Paths:
        """Position, velocity and acceleration (cylinders, n) at angles (n,) or (cylinders, n)."""
        lengths = (train.crank_radius, train.rod_length, train.wrist_pin_offset)
        found = piston_path(angle + turned, *lengths)
        position, velocity, acceleration = (np.array(part) for part in found[:3])
        of_slaves = angle[slaves.cylinder] if angle.ndim == 2 else angle
        moved = slave_motion(rods, of_slaves)
        position[slaves.cylinder] = moved.position
        velocity[slaves.cylinder] = moved.velocity
        acceleration[slaves.cylinder] = moved.acceleration
        return position, velocity, acceleration

    top, bottom, stroke = dead_centres(paths)
    found = OfCylinders(
        stroke=stroke,
        top_dead_centre=top,
        bottom_dead_centre=bottom,
        position_harmonics=lambda: harmonics_of_turn(lambda angle: paths(angle)[0], highest),
        acceleration_harmonics=lambda: (
            speed**2 * harmonics_of_turn(lambda angle: paths(angle)[2], highest)
        ),
    )
    scene.emit_all(found, {"cylinder": train.names, "order": np.arange(highest + 1)})
    scene.cite(
        "slave rods on a master rod", "piston motion",
        "exact motion, docs/theory.md; cf. Biezeno and Grammel (1953), ch. XI",
    )  # fmt: skip
