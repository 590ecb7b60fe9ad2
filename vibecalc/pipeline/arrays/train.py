"""A crank train at many points: as `machine.crank_train`, each number with a leading axis."""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.crank_forces import Turning
from vibecalc.numerics.typing import FloatArray
from vibecalc.parts.body import Frame, build_frame
from vibecalc.pipeline.arrays.columns import Columns, together

TRAIN = ("machine", "crank_train")


class Train(NamedTuple):
    """Arrays (points or 1,) and (points or 1, cylinders) of what `CrankTrain` holds.

    `whole_rotating_mass` counts the throws that do not turn, too; `runs` (cylinders,) is 1 for
    cylinders that move. `rod_share` is the share of the rod's mass that moves with the piston.
    """

    crank_radius: FloatArray
    rod_length: FloatArray
    wrist_pin_offset: FloatArray
    position: FloatArray
    crank_phase: FloatArray
    bank_angle: FloatArray
    reciprocating_mass: FloatArray
    rotating_mass: FloatArray
    whole_reciprocating_mass: FloatArray
    whole_rotating_mass: FloatArray
    runs: FloatArray
    rod_share: FloatArray
    origin: FloatArray
    frame: Frame

    @property
    def axis(self) -> FloatArray:
        return self.frame.axis

    @property
    def stroke(self) -> FloatArray:
        return self.frame.stroke

    @property
    def across(self) -> FloatArray:
        return self.frame.across


def build_train(columns: Columns) -> Train:
    """The crank train at all points."""
    train = columns.case.machine.crank_train
    options = columns.case.excitation
    stopped = options is not None and options.working is not None and options.idle != "unloaded"
    working = (options.working or ()) if options else ()
    runs = np.array([not stopped or c.name in working for c in train.cylinders], dtype=float)
    share = _rod_share(columns)
    rod = columns.number(*TRAIN, "rod", "mass") if train.rod is not None else np.zeros(1)
    common = columns.optional(*TRAIN, "reciprocating_mass")
    if common is None:
        pieces = columns.number(*TRAIN, "piston_mass") + columns.number(*TRAIN, "pin_mass")
        common = pieces + rod * share
    pins = columns.number(*TRAIN, "rotating_mass")
    reciprocating, rotating = [], []
    for place in range(len(train.cylinders)):
        path = (*TRAIN, "cylinders", place)
        own, pin = (
            columns.optional(*path, f"{kind}_mass") for kind in ("reciprocating", "rotating")
        )
        reciprocating.append(common if own is None else own)
        rotating.append((pins if pin is None else pin) + rod * (1.0 - share))
    moving, turning = together(reciprocating), together(rotating)
    position, phase, bank = (
        together([columns.number(*TRAIN, "cylinders", i, name) for i in range(len(runs))])
        for name in ("position", "crank_phase", "bank_angle")
    )
    return Train(
        crank_radius=columns.number(*TRAIN, "crank_radius"),
        rod_length=columns.number(*TRAIN, "rod_length"),
        wrist_pin_offset=columns.number(*TRAIN, "wrist_pin_offset"),
        position=position,
        crank_phase=phase,
        bank_angle=bank,
        reciprocating_mass=runs * moving,
        rotating_mass=runs * turning,
        whole_reciprocating_mass=moving,
        whole_rotating_mass=turning,
        runs=runs,
        rod_share=share,
        origin=columns.vector(*TRAIN, "origin"),
        frame=build_frame(train.axis, train.stroke),
    )


def turning_masses(columns: Columns, train: Train) -> Turning:
    """Throws, weights that cancel throws, counterweights and balance shafts at all points.

    `unbalance` (points or 1, m), `position` (points or 1, m, 3).
    """
    written, options = columns.case.machine.crank_train, columns.case.excitation
    radius = train.crank_radius[:, None]
    unbalance = [train.rotating_mass * radius]
    phase, along = [train.crank_phase], [train.position]
    balanced = (options.balanced_for or ()) if options else ()
    named = [i for i, c in enumerate(written.cylinders) if c.name in balanced]
    unbalance.append(train.whole_rotating_mass[:, named] * radius)
    phase.append(train.crank_phase[:, named] + np.pi)
    along.append(train.position[:, named])
    for pieces, name in ((unbalance, "unbalance"), (phase, "phase"), (along, "position")):
        paths = [(*TRAIN, "counterweights", i, name) for i in range(len(written.counterweights))]
        pieces.append(together([columns.number(*path) for path in paths]))
    on_shaft = [part[..., None] * train.frame.axis for part in along]
    shafts = range(len(written.balance_shafts))
    for pieces, name in ((unbalance, "unbalance"), (phase, "phase")):
        paths = [(*TRAIN, "balance_shafts", i, name) for i in shafts]
        pieces.append(together([columns.number(*path) for path in paths]))
    for i in shafts:
        on_shaft.append(columns.vector(*TRAIN, "balance_shafts", i, "position")[:, None, :])
    crank = sum(part.shape[1] for part in along)
    ratios = [1] * crank + [shaft.speed_ratio for shaft in written.balance_shafts]
    return Turning(
        _side_by_side(unbalance), np.array(ratios, dtype=np.int64), _side_by_side(phase),
        _side_by_side(on_shaft),
    )  # fmt: skip


def _rod_share(columns: Columns) -> FloatArray:
    rod = (*TRAIN, "rod")
    if columns.written(*rod) is None:
        return np.zeros(1)
    given = columns.optional(*rod, "reciprocating_fraction")
    if given is not None:
        return given
    return columns.number(*rod, "crank_pin_to_mass_centre") / columns.number(*TRAIN, "rod_length")


def _side_by_side(parts: list[FloatArray]) -> FloatArray:
    """Arrays (points or 1, any, ...) along their second axis."""
    points = max(part.shape[0] for part in parts)
    wide = [np.broadcast_to(part, (points, *part.shape[1:])) for part in parts]
    return np.concatenate(wide, axis=1)
