"""Adapter: motions in m and forces in N of a primary of one or several modes with absorbers."""

from collections.abc import Callable
from typing import Any

import numpy as np

from vibecalc.absorber.adapters.band import problem_of
from vibecalc.absorber.adapters.response import frequency_ratios, moved_by_ratios
from vibecalc.absorber.asked_tables import AMPLITUDES, AbsorberResponse
from vibecalc.absorber.modal import Fitted, bare, fitted, highest, magnitude
from vibecalc.absorber.model import AbsorberParts, Scale, build_absorber, modes_of
from vibecalc.absorber.motion_results import (
    IN_BAND_ROOT,
    MOTION_ROOT,
    TORSION,
    TRANSLATION,
    WITHOUT_ROOT,
)
from vibecalc.absorber.readings import OF_ABSORBER
from vibecalc.absorber.stage import is_banded, motions_of
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray

_TURN = 2.0 * np.pi


def run_motion(scene: Scene) -> None:
    """Emit every motion and force over the frequencies drawn, and the largest of each."""
    case = scene.case
    assert (
        case.response is not None
        and case.response.absorber is not None
        and case.machine.primary is not None
    )
    parts, options = build_absorber(case), case.response.absorber
    scale, several = parts.scale, parts.branches
    assert scale is not None
    modes = modes_of(case.machine.primary, scale, several)
    masses, given, errors = absorbers_of(scene, parts)
    if not np.all(np.isfinite(given)):
        raise NumericalFailure(
            "the tuning fastens an absorber rigidly to what carries it, and a motion in units is "
            "that of springs and dampers: leave this absorber out, or bound its stiffness_ratio"
        )
    carrier = tuple(branch.carrier for branch in several)

    def made(ratios: FloatArray) -> Fitted:
        stiffness, damping = np.split(ratios, 2)
        return fitted(modes, masses, stiffness, damping, carrier)

    excitation, unit = driven(options, scale)
    x = frequency_ratios(options, parts, float(np.max(modes.frequency)))
    natural = scale.frequency / _TURN
    names = TORSION if scale.torsion else TRANSLATION
    curves = {"excitation_frequency": x * natural}
    each = {"absorber": tuple(branch.name for branch in several)}
    ranges = [((float(x[0]), float(x[-1])), f"{MOTION_ROOT}/largest", f"{MOTION_ROOT}/largest_at")]
    if is_banded(case) and case.tuning is not None:
        problem = problem_of(case.tuning, parts, case.machine)
        ranges.append(((problem.low, problem.high), IN_BAND_ROOT, f"{IN_BAND_ROOT}/at"))
    bare_range = (ranges[0][0], f"{WITHOUT_ROOT}/largest", f"{WITHOUT_ROOT}/largest_at")

    def emit(what: str, root: str, absorbers: range, ranges: list[Any], moves: bool) -> None:
        """A curve and its largest in each range, of the absorbers named or of the primary."""
        own = what in OF_ABSORBER and bool(several)
        path, axes = ("each/" if own else "") + names[what][0], each if own else {}
        size = unit * _factor(what, scale)

        def stacked(rows: list[np.ndarray]) -> np.ndarray:
            return np.stack(rows) if own else rows[0]

        def moved(read: Callable[[Fitted], np.ndarray]) -> FloatArray:
            if not moves:
                return np.zeros(3)
            return moved_by_ratios(lambda ratios: read(made(ratios)), given, errors)

        system = made(given) if moves else bare(modes)
        values, off = [], 0.0
        for place in absorbers:

            def curve(one: Fitted, place: int = place) -> np.ndarray:
                return np.asarray(magnitude(one, x, excitation, what, place)[0][0])

            value, error = _curve(system, x, excitation, what, place)
            values.append(_scaled(size, value))
            spread = float(np.max(moved(curve)))
            off = max(off, size * (float(np.max(error)) + spread)
                      + 8.0 * EPSILON * float(np.max(_finite(values[-1]))))  # fmt: skip
        scene.emit(f"{root}/{path}", stacked(values), off, axes | curves)
        for ends, heights, places in ranges:
            tops = []
            for place in absorbers:

                def top(one: Fitted, place: int = place, ends: Any = ends) -> np.ndarray:
                    return np.array(highest(one, excitation, what, ends[0], ends[1], place))[:, 0]

                (peak, error, where), shift = top(system), moved(top)
                slack = error + shift[0] + 8.0 * EPSILON * float(_finite(peak))
                apart = natural * (shift[2] + 1e-12 * float(ends[1]))
                tops.append(np.array([size * peak, size * slack, natural * where, apart]))
            found = stacked(tops).T
            scene.emit(f"{heights}/{path}", found[0], found[1], axes)
            scene.emit(f"{places}/{path}", found[2], found[3], axes)

    for what in motions_of(case):
        own = what in OF_ABSORBER
        emit(what, MOTION_ROOT, range(len(masses) if own else 1), ranges, True)
        if not own:
            emit(what, WITHOUT_ROOT, range(1), [bare_range], False)
    scene.cite(
        "response of modal masses with absorbers, each frequency by itself; peaks by Newton's "
        "method between seeds about all poles",
        "motions and forces in units",
        "docs/theory_absorber_parts.md",
    )


def absorbers_of(scene: Scene, parts: AbsorberParts) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass ratios (a,), then stiffness and damping ratios (2 a,) with their errors: tuned, or as
    given."""
    if parts.branches:
        mass: Any = [branch.mass_ratio for branch in parts.branches]
        given = [(branch.stiffness_ratio, branch.secondary_damping) for branch in parts.branches]
        tuned = scene.handed_on.get("several")
        if tuned is None and any(value is None for row in given for value in row):
            raise NumericalFailure("an absorber has no spring or no damper, and no tuning finds it")
        stiffness, damping = tuned or zip(*given, strict=True)
        uncertainty = scene.handed_on.get("several_uncertainty")
    else:
        tuned = scene.handed_on.get("tuned")
        if tuned is None and not parts.is_complete:
            raise NumericalFailure(
                "the absorber has no spring or no damper, and no tuning finds it"
            )
        mass, stiffness, damping = (tuned or parts.absorber)[1:]  # type: ignore[index]
        uncertainty = scene.handed_on.get("tuned_uncertainty")
    masses = np.atleast_1d(np.asarray(mass, float))
    ratios = np.concatenate([np.atleast_1d(stiffness), np.atleast_1d(damping)]).astype(float)
    if uncertainty is None:
        return masses, ratios, np.zeros(len(ratios))
    return masses, ratios, np.concatenate([np.atleast_1d(part) for part in uncertainty])


def _scaled(size: float, values: np.ndarray) -> np.ndarray:
    """Complex values times a number; infinite ones keep no phase."""
    finite = np.isfinite(np.abs(values))
    return np.where(finite, size * np.where(finite, values, 0.0), np.inf)


def _finite(values: object) -> FloatArray:
    size = np.abs(np.asarray(values))
    return np.where(np.isfinite(size), size, 0.0)


def driven(options: AbsorberResponse, scale: Scale) -> tuple[str, float]:
    """The excitation, and the displacement that |H| = 1 stands for, in m or rad."""
    key = next(key for key in AMPLITUDES if getattr(options, key) is not None)
    size = float(getattr(options, key))
    per = {
        "force": 1.0 / scale.stiffness,
        "torque": 1.0 / scale.stiffness,
        "unbalance": 1.0 / scale.inertia,
        "base_displacement": 1.0,
        "base_acceleration": scale.inertia / scale.stiffness,
    }
    return AMPLITUDES[key], size * per[key]


def _factor(response: str, scale: Scale) -> float:
    if response in ("velocity", "acceleration"):
        return scale.frequency ** (1 + (response == "acceleration"))
    return scale.stiffness if response.endswith("force") else 1.0


def _curve(
    system: Fitted, x: FloatArray, excitation: str, response: str, absorber: int
) -> tuple[np.ndarray, FloatArray]:
    """H (points,) and its error; infinite at an undamped natural frequency of the bare primary."""
    modes = system.modes
    sharp = modes.frequency[0][(modes.damping[0] == 0.0) & (system.mass[0, 0] == 0.0)]
    on = np.any(np.abs(x[:, None] - sharp) <= 4.0 * EPSILON * x[:, None], axis=1) & (x > 0.0)
    value, error = np.full(len(x), np.inf + 0j), np.zeros(len(x))
    found, slack = magnitude(system, x[~on], excitation, response, absorber)
    value[~on], error[~on] = found[0], slack[0]
    return value, error
