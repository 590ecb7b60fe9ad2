"""Adapter: motions in m and forces in N of a primary of one or several modes with an absorber."""

from collections.abc import Callable

import numpy as np

from vibecalc.absorber.adapters.band import problem_of
from vibecalc.absorber.adapters.response import moved_by_ratios
from vibecalc.absorber.asked_tables import AMPLITUDES, AbsorberResponse
from vibecalc.absorber.modal import Fitted, Modes, bare, fitted, highest, magnitude
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
    if case.response is None or case.response.absorber is None or case.machine.primary is None:
        raise ValueError("the case has no [response.absorber]")
    parts, options = build_absorber(case), case.response.absorber
    tuned = scene.handed_on.get("tuned")
    one = parts.absorber if tuned is None else tuned
    if parts.scale is None or one is None or (tuned is None and not parts.is_complete):
        raise NumericalFailure("the absorber has no spring or no damper, and no tuning finds it")
    modes = modes_of(case.machine.primary, parts.scale)
    m, k, z = (float(np.asarray(part)) for part in one[1:])
    system = fitted(modes, m, k, z)
    uncertainty = scene.handed_on.get("tuned_uncertainty")
    excitation, unit = driven(options, parts.scale)
    x = drawn(options, parts, modes)
    natural = parts.scale.frequency / _TURN
    axes = {"excitation_frequency": x * natural}
    names = TORSION if parts.scale.torsion else TRANSLATION
    band = None
    if is_banded(case) and case.tuning is not None:
        problem = problem_of(case.tuning, parts, case.machine)
        band = problem.low, problem.high

    def moved_at(read: Callable[[Fitted], np.ndarray]) -> FloatArray:
        errors = np.zeros(2) if uncertainty is None else np.array(uncertainty)
        return moved_by_ratios(lambda both: read(fitted(modes, m, *both)), np.array([k, z]), errors)

    def emit_largest(
        one: Fitted, what: str, roots: tuple[str, str], ends: tuple[float, float], moves: bool
    ) -> None:
        """The largest between two frequency ratios, and where that is."""
        name, size = names[what][0], unit * _factor(what, scale)

        def top(system: Fitted) -> np.ndarray:
            return np.array(highest(system, excitation, what, *ends))[:, 0]

        (peak, error, where), moved = top(one), moved_at(top) if moves else np.zeros(3)
        off = size * (error + moved[0] + 8.0 * EPSILON * float(_finite(peak)))
        scene.emit(f"{roots[0]}/{name}", size * peak, off)
        place = natural * (moved[2] + 1e-12 * float(ends[1]))
        scene.emit(f"{roots[1]}/{name}", natural * where, place)

    scale, whole = parts.scale, (float(x[0]), float(x[-1]))
    for response in motions_of(case):
        size = unit * _factor(response, scale)

        def curve(one: Fitted, what: str = response) -> np.ndarray:
            return np.asarray(magnitude(one, x, excitation, what)[0][0])

        for root, one in ((MOTION_ROOT, system), (WITHOUT_ROOT, bare(modes))):
            moves = root == MOTION_ROOT
            if not moves and response in OF_ABSORBER:
                continue
            value, error = _curve(one, x, excitation, response)
            value = _scaled(size, value)
            off = size * (np.max(error) + (np.max(moved_at(curve)) if moves else 0.0))
            rounding = 8.0 * EPSILON * np.max(_finite(value))
            scene.emit(f"{root}/{names[response][0]}", value, off + rounding, axes)
            emit_largest(one, response, (f"{root}/largest", f"{root}/largest_at"), whole, moves)
        if band is not None:
            emit_largest(system, response, (IN_BAND_ROOT, f"{IN_BAND_ROOT}/at"), band, True)
    scene.cite(
        "response of modal masses with an absorber, each frequency by itself; peaks by Newton's "
        "method between seeds about all poles",
        "motions and forces in units",
        "docs/theory_absorber_band.md",
    )


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


def drawn(options: AbsorberResponse, parts: AbsorberParts, modes: Modes) -> FloatArray:
    """Frequencies of the curves over the first natural frequency; default: to twice the highest."""
    asked = options.frequencies
    if asked is not None and parts.scale is not None:
        return np.linspace(asked.start, asked.stop, asked.points) / parts.scale.frequency
    ratios = options.frequency_ratios
    if ratios is not None:
        return np.linspace(ratios.start, ratios.stop, ratios.points)
    return np.linspace(0.0, 2.0 * float(np.max(modes.frequency)), 401)


def _curve(
    system: Fitted, x: FloatArray, excitation: str, response: str
) -> tuple[np.ndarray, FloatArray]:
    """H (points,) and its error; infinite at an undamped natural frequency of the bare primary."""
    modes = system.modes
    sharp = modes.frequency[0][modes.damping[0] == 0.0] if system.mass[0] == 0.0 else np.zeros(0)
    on = np.any(np.abs(x[:, None] - sharp) <= 4.0 * EPSILON * x[:, None], axis=1) & (x > 0.0)
    value, error = np.full(len(x), np.inf + 0j), np.zeros(len(x))
    found, slack = magnitude(system, x[~on], excitation, response)
    value[~on], error[~on] = found[0], slack[0]
    return value, error
