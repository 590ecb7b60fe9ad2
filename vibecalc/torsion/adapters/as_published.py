"""The modal route of the source, one mode at a time, named for what it is."""

from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import ComplexArray, FloatArray
from vibecalc.torsion.adapters.setup import Setup, build_setup, line_speeds, placed
from vibecalc.torsion.as_published import (
    caughey_series,
    modal_excitation,
    modal_twist,
    series_damping,
    twist_on_criticals,
)
from vibecalc.torsion.asked import has_holzer
from vibecalc.torsion.holzer import relative_residual
from vibecalc.torsion.study_results import PUBLISHED
from vibecalc.torsion.tables import AsPublished

# ----------------------------------------------------------------------------
# Adapter: the modal route of the source, one mode at a time, named for what it is.
# ----------------------------------------------------------------------------

#: frequencies of the residual of Holzer's table, and the last over the highest natural one
_FREQUENCIES, _BEYOND = 800, 1.05
#: a first freedom that moves less than this share of the largest is a node of the mode
_NODE = 1e-9


def run_torsion_as_published(scene: Scene) -> None:
    """Emit everything for [response.torsion.as_published]."""
    setup = build_setup(scene.case)
    options = setup.torsion.as_published
    if options is None:
        raise ValueError("the case has no [response.torsion.as_published]")
    place, shape = _shapes(setup, options)
    frequency = Bounded(setup.modes.frequency[place], setup.modes.frequency_error[place])
    every, order = setup.modes.frequency, setup.drive.order
    empirical, undamped = (options.magnifier == one for one in ("empirical", "undamped"))
    ratio = 0.0 if empirical or undamped else options.damping_ratio
    zeta = np.full(len(place), ratio)
    speeds = line_speeds(setup.torsion.speeds) if setup.torsion.speeds is not None else None

    def kernel(
        lowest: FloatArray, shape: FloatArray, natural: FloatArray, torque: ComplexArray
    ) -> dict[str, Any]:
        """By the names of the results."""
        series = caughey_series(lowest, np.full(len(lowest), options.damping_ratio))
        inertia, stiffness = np.append(series.alpha, 0.0)[:2]
        excitation = modal_excitation(shape, natural, setup.model.line.inertia, torque)
        found = {
            "rayleigh_inertia": inertia,
            "rayleigh_stiffness": stiffness,
            "rayleigh_damping_ratio": series_damping(series, natural),
            "intensity": excitation.vector_sum,
            "static_twist": excitation.deflection,
        }
        if speeds is not None:
            twist = modal_twist(excitation, natural, order, speeds, zeta)
            found |= {"twist": twist.real, "twist_magnitude": np.abs(twist)}
        if not undamped:
            met = twist_on_criticals(excitation, order, None if empirical else zeta)[..., -1]
            best = np.argmax(np.abs(met), axis=1)[:, None]
            largest = np.take_along_axis(np.abs(met), best, axis=1)[:, 0]
            found |= {"twist_at_critical": met, "largest_twist": largest}
        return found

    torque = _torque(setup)
    found = with_errors(kernel, every[every > 0.0][:2], shape, frequency, torque)
    axes = {"elastic_mode": place + 1, "order": order, "speed": speeds}
    if has_holzer(scene.case):
        line = setup.model.line
        driven = np.linspace(0.0, _BEYOND * every.max(), _FREQUENCIES + 1)[1:]
        axes["frequency"] = driven / (2.0 * np.pi)

        def closing(inertia: FloatArray, stiffness: FloatArray) -> FloatArray:
            moved = line._replace(inertia=inertia, stiffness=stiffness)
            return relative_residual(moved, driven)

        found["residual"] = with_errors(closing, line.inertia, line.stiffness)
    for name, value in {"natural_frequency": frequency, **found}.items():
        scene.emit(f"{PUBLISHED}{name}", value, axes=axes)
    for name, of in (("intensity", "intensity"), ("twist", "twist_at_critical")):
        if of in found:
            best = order[np.argmax(np.abs(found[of].value), axis=1)]
            scene.emit(f"{PUBLISHED}largest_{name}_order", best, 0.0, axes)
    scene.cite(
        "modal method of the source: modal twist at crank angle zero, shape 1 at the first "
        "station; not the twist of a shaft",
        "numbers as published",
        "Baca Vasquez (2007), equations 4.17 to 4.20 and 4.27 to 4.29; docs/theory_torsion.md",
    )


def _shapes(setup: Setup, options: AsPublished) -> tuple[np.ndarray, Bounded]:
    """Places of the elastic modes asked for, shapes with 1 at the first freedom."""
    modes, shaft = setup.modes, setup.shaft
    elastic = np.flatnonzero(modes.frequency > 0.0)[: options.modes]
    if elastic.size == 0:
        raise NumericalFailure("the shaft line has no elastic mode")
    # a ring that hangs on the first station stands in front of it
    first = int(shaft.freedom[0])
    first = next((one.ring for one in shaft.dampers if one.carrier == first), first)
    angle = Bounded(modes.shape[elastic], modes.shape_error[elastic, None])
    base = angle[:, first]
    node = np.abs(base.value) < _NODE
    if np.any(node):
        raise NumericalFailure(
            f"as published, mode {elastic[node][0] + 1} is to have the angle 1 at the first "
            "freedom of the line, which stands still in it"
        )
    return elastic, angle / base[:, None]


def _torque(setup: Setup) -> Bounded:
    """Torque (m, n) of the operating speed on all freedoms, referred."""
    drive = setup.drive
    on = placed(drive.freedom, setup.model.line.inertia.size)
    return drive.torque(np.array([setup.speed]))[0] @ on
