"""Adapter: curves, peaks, fixed points and poles of a primary system with one absorber."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from vibecalc.absorber.asked_tables import AbsorberResponse, Vary
from vibecalc.absorber.modal import Fitted, magnitude, on_one_mode
from vibecalc.absorber.model import AbsorberParts, build_absorber
from vibecalc.absorber.peaks import Peaks, peaks
from vibecalc.absorber.results import NAMES, RESPONSE_ROOT
from vibecalc.absorber.stage import SHOWN, asked_of, curve_names, has_fixed_points, varied_key
from vibecalc.absorber.transfer import (
    Absorber,
    damping_from_own_ratio,
    fixed_points,
    landmarks,
    poles,
    transfer_of,
)
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# The absorbers whose curves a case asks for: the one given or tuned, its limits, a family.
# ----------------------------------------------------------------------------


class Curves(NamedTuple):
    """Names (n,) and ratios (..., n) of each; the first is the absorber given or tuned."""

    names: tuple[str, ...]
    absorber: Absorber


def family(
    case: Case, options: AbsorberResponse, parts: AbsorberParts, tuned: Absorber | None
) -> Curves:
    """The curves that a case asks for, in the order in which they are listed there."""
    absorber = parts.absorber if tuned is None else tuned
    if absorber is None or (tuned is None and not parts.is_complete):
        raise NumericalFailure("the absorber has no spring or no damper, and no tuning finds it")
    rows = [absorber]
    if options.limits:
        locked = absorber._replace(stiffness_ratio=np.inf)
        rows += [locked, absorber._replace(stiffness_ratio=0.0, secondary_damping=0.0)]
    secondary = case.machine.secondary
    ratio = None if secondary is None else secondary.absorber_damping_ratio
    if options.vary is not None:
        rows += _varied(options.vary, absorber, ratio)
    lead = np.broadcast_shapes(*(np.shape(part) for part in absorber))
    columns = (
        np.stack([np.broadcast_to(np.asarray(part, dtype=float), lead) for part in column], axis=-1)
        for column in zip(*rows, strict=True)
    )
    return Curves(curve_names(case), Absorber(*columns))


def _varied(vary: Vary, given: Absorber, ratio: float | None) -> list[Absorber]:
    key, rows = varied_key(vary), []
    for value in getattr(vary, key):
        each = given
        if key == "absorber_damping_ratio":
            ratio = value
        elif key == "damping_over_primary_critical":
            each = given._replace(secondary_damping=value)
        else:
            each = given._replace(**{key: value})
        # a damper given on the absorber's own frequency follows its spring and its mass
        if ratio is not None and key != "damping_over_primary_critical":
            damping = damping_from_own_ratio(ratio, each.mass_ratio, each.stiffness_ratio)
            each = each._replace(secondary_damping=damping)
        rows.append(each)
    return rows


# ----------------------------------------------------------------------------
# Adapter, continued: what the error of a tuning does to everything that is read at it.
#
# A tuning is known to some last digits, and a sharp peak moves with them by many more. How much is
# examined: each ratio is moved by a millionth, and what that does is scaled to the error.
# ----------------------------------------------------------------------------

#: relative change of a ratio
_STEP = 1e-6


class TuningError(NamedTuple):
    """Absolute errors of stiffness and damping ratio: numbers, or (n,) of several absorbers."""

    stiffness: FloatArray
    damping: FloatArray


def tuning_error(stiffness: object, damping: object) -> TuningError:
    """Errors as arrays; an unknown one (of a tuning that is one of many) counts as none."""
    both = (np.asarray(part, dtype=float) for part in (stiffness, damping))
    return TuningError(*(np.where(np.isfinite(part), part, 0.0) for part in both))


def moved(
    read: Callable[[Absorber], np.ndarray], tuned: Absorber, uncertainty: TuningError
) -> FloatArray:
    """What the errors of one tuned absorber do to a reading of it, absolute."""
    ratios = np.array([float(np.asarray(part)) for part in tuned[2:]])

    def at(both: FloatArray) -> np.ndarray:
        stiffness, damping = both.tolist()
        return read(tuned._replace(stiffness_ratio=stiffness, secondary_damping=damping))

    return moved_by_ratios(at, ratios, np.array(uncertainty))


def moved_by_ratios(
    read: Callable[[FloatArray], np.ndarray], ratios: FloatArray, errors: FloatArray
) -> FloatArray:
    """What absolute errors (n,) of ratios (n,) do to a reading of them, absolute.

    Infinite errors and readings, and those of which there are fewer or more, count as none.
    """
    here = np.asarray(read(ratios))
    total = np.zeros(here.shape)
    for place, (size, error) in enumerate(zip(ratios.tolist(), errors.tolist(), strict=True)):
        if error == 0.0 or size == 0.0 or not np.isfinite(size + error):
            continue
        off = ratios.copy()
        off[place] *= 1.0 + _STEP
        there = np.asarray(read(off))
        if there.shape != here.shape:
            continue
        with np.errstate(invalid="ignore"):
            change = np.abs(there - here)
        total += np.where(np.isfinite(change), change, 0.0) * (error / (_STEP * size))
    return total


# ----------------------------------------------------------------------------
# Adapter: curves, peaks, fixed points, frequencies and poles of a primary with absorber.
# ----------------------------------------------------------------------------

TRAVEL = "relative_displacement"
#: names of what is read of an absorber, as a case has them and as the modes do
OWN = {TRAVEL: "travel"}
_Reading = Callable[[Callable[[Absorber], np.ndarray]], np.ndarray]
#: maxima that a two-mass system can have
_MOST = 4


def run_absorber(scene: Scene) -> None:
    """Emit everything for [response.absorber], one absorber; at the optimum of [tuning], if any.

    Peaks of many absorbers at once where the case has numbers (points,).
    """
    case = scene.case
    assert case.response is not None and case.response.absorber is not None
    parts = build_absorber(case)
    options, pair = case.response.absorber, asked_of(case)
    whole = family(case, options, parts, scene.handed_on.get("tuned"))
    travels = [TRAVEL] if scene.wants(f"{RESPONSE_ROOT}/largest_travel") else []
    curves, both = _reported(scene, whole, pair, travels)
    tops, *travel = (Peaks(*(part[place] for part in both)) for place in range(1 + len(travels)))
    _emit_peaks(scene, curves, tops, pair)
    for one in travel:
        _emit_largest(scene, "largest_travel", curves, one, (pair[0], TRAVEL))
    if not scene.wants(*SHOWN):
        return
    ratios = frequency_ratios(options, parts)
    axes = {"curve": curves.names, "frequency_ratio": ratios}
    emit_frequencies(scene, parts, ratios)
    systems = on_modes(curves.absorber)
    for name, what in (("curve", pair[1]), ("relative_curve", TRAVEL)):
        value, error = courses(systems, ratios, pair[0], what)
        error[0] += _moved(scene, curves, partial(_shown, ratios, pair[0], what))
        scene.emit(f"{RESPONSE_ROOT}/{name}", value, error, axes)
    _emit_landmarks(scene, curves, pair)
    _cite(scene)


def _moved(scene: Scene, curves: Curves, read: Callable[[Absorber], np.ndarray]) -> np.ndarray:
    """What the error of a tuning does to a reading of the first curve; zero of one given."""
    first = Absorber(*(float(np.asarray(part).flat[0]) for part in curves.absorber))
    uncertainty = scene.handed_on.get("tuned_uncertainty")
    return np.zeros(()) if uncertainty is None else moved(read, first, uncertainty)


def on_modes(absorbers: Absorber) -> list[Fitted]:
    """Each of absorbers (n,) on its primary."""
    rows = zip(*(np.asarray(part) for part in absorbers), strict=True)
    return [on_one_mode(Absorber(*row)) for row in rows]


def _shown(ratios: FloatArray, excitation: str, what: str, one: Absorber) -> np.ndarray:
    return np.asarray(courses([on_one_mode(one)], ratios, excitation, what)[0][0])


def courses(
    systems: Sequence[Fitted], ratios: FloatArray, excitation: str, what: str, absorber: int = 0
) -> tuple[np.ndarray, FloatArray]:
    """One response of all systems (n, points) over the frequency, with errors."""
    read = OWN.get(what, what)
    each = [magnitude(one, ratios, excitation, read, absorber) for one in systems]
    values, errors = (np.concatenate(part) for part in zip(*each, strict=True))
    return values, errors


def _passed(first: int, one: Absorber) -> np.ndarray:
    """Frequencies (0) or heights (2) of the fixed points."""
    return np.array(fixed_points(one.mass_ratio, one.stiffness_ratio)[first : first + 2])


def _reported(
    scene: Scene, curves: Curves, pair: tuple[str, str], others: list[str]
) -> tuple[Curves, Peaks]:
    """The curves whose peaks double precision can tell, the first in any case, and these peaks.

    Of the response of the pair and of `others`, by a leading axis.
    """
    asked = [pair[1], *others]
    try:
        return curves, peaks(curves.absorber, pair[0], asked)
    except NumericalFailure:
        if scene.wanted is not None:
            raise
    shown = [0]
    for place, name in enumerate(curves.names[1:], start=1):
        try:
            peaks(Absorber(*(np.asarray(part)[place] for part in curves.absorber)), *pair)
            shown.append(place)
        except NumericalFailure as failure:
            scene.warn(f"curve {name!r} left out: {failure}")
    names = tuple(curves.names[place] for place in shown)
    left = Absorber(*(np.asarray(part)[shown] for part in curves.absorber))
    return Curves(names, left), peaks(left, pair[0], asked)


def frequency_ratios(
    options: AbsorberResponse, parts: AbsorberParts, highest: float = 1.0
) -> FloatArray:
    """Frequencies of the curves over the primary's own one; default: to twice the highest mode."""
    if options.frequencies is not None and parts.scale is not None:
        asked = options.frequencies
        return np.linspace(asked.start, asked.stop, asked.points) / parts.scale.frequency
    ratios = options.frequency_ratios
    if ratios is None:
        return np.linspace(0.0, 2.0 * highest, 401)
    return np.linspace(ratios.start, ratios.stop, ratios.points)


def emit_frequencies(scene: Scene, parts: AbsorberParts, ratios: np.ndarray) -> None:
    """The same in rad/s, for a primary with units."""
    if parts.scale is None:
        return
    natural = parts.scale.frequency
    scene.emit(
        f"{RESPONSE_ROOT}/frequency",
        natural * ratios,
        8.0 * EPSILON * natural * np.max(ratios),
        {"frequency_ratio": ratios},
    )
    scene.emit(f"{RESPONSE_ROOT}/primary_frequency", natural, 8.0 * EPSILON * natural)


def _emit_peaks(scene: Scene, curves: Curves, tops: Peaks, pair: tuple[str, str]) -> None:
    axes = {"curve": curves.names}
    places = axes | {"peak": np.arange(1, _MOST + 1)}
    root = f"{RESPONSE_ROOT}/peak"
    spread = np.where(tops.present, 4.0 * EPSILON * tops.frequency, 0.0)
    spread[..., 0, :] += _moved(scene, curves, lambda one: peaks(one, *pair).frequency)
    error = np.where(np.isfinite(tops.error), tops.error, 0.0)
    error[..., 0, :] += _moved(scene, curves, lambda one: peaks(one, *pair).magnitude)
    scene.emit(f"{root}/magnitude", tops.magnitude, error, places)
    scene.emit(f"{root}/frequency_ratio", tops.frequency, spread, places)
    _emit_largest(scene, "largest", curves, tops, pair)
    finite = np.isfinite(tops.where)
    where = np.where(finite, 4.0 * EPSILON * np.where(finite, tops.where, 0.0), 0.0)
    # it is one of the peaks: what these move by
    moved = np.max(spread[..., 0, :], axis=-1)
    where[..., 0] += np.where(finite[..., 0], moved, 0.0)
    scene.emit(f"{RESPONSE_ROOT}/largest_frequency_ratio", tops.where, where, axes)


def _emit_largest(
    scene: Scene, name: str, curves: Curves, tops: Peaks, pair: tuple[str, str]
) -> None:
    error = np.where(np.isfinite(tops.largest_error), tops.largest_error, 0.0)
    error[..., 0] += _moved(scene, curves, lambda one: peaks(one, *pair).largest)
    scene.emit(f"{RESPONSE_ROOT}/{name}", tops.largest, error, {"curve": curves.names})


def _emit_landmarks(scene: Scene, curves: Curves, pair: tuple[str, str]) -> None:
    """Of the first curve, which is the one given or tuned."""
    z1, m, k, z2 = (float(np.asarray(part).flat[0]) for part in curves.absorber)
    marks = landmarks(m, k)
    both = np.array([marks.lower, marks.upper], dtype=float)
    uncertain = scene.handed_on.get("tuned_uncertainty")
    # a frequency goes with the root of the stiffness, or with less of it
    off = 0.0 if uncertain is None or k == 0.0 else 0.5 * float(uncertain.stiffness) / k
    near = (16.0 * EPSILON + off) * np.max(both[np.isfinite(both)])
    scene.emit(f"{RESPONSE_ROOT}/natural_frequency_ratio", both, near, {"mode": np.arange(1, 3)})
    for name, value, share in (
        ("antiresonance", marks.antiresonance, off), ("locked_frequency_ratio", marks.locked, 0.0),
    ):  # fmt: skip
        scene.emit(f"{RESPONSE_ROOT}/{name}", float(value), (4.0 * EPSILON + share) * float(value))
    roots = poles(Absorber(z1, m, k, z2))
    values, uncertainty = roots.value[roots.present], roots.error[roots.present]
    rank = np.lexsort((values.imag, -values.real))
    axes = {"pole": np.arange(1, len(rank) + 1)}
    far = _moved(scene, curves, lambda one: poles(one).value)
    scene.emit(
        f"{RESPONSE_ROOT}/pole", values[rank], np.max(uncertainty, initial=0.0) + np.max(far), axes
    )
    if has_fixed_points(scene.case):
        _emit_fixed_points(scene, m, k, pair, lambda read: _moved(scene, curves, read))


def _emit_fixed_points(
    scene: Scene, m: float, k: float, pair: tuple[str, str], moved_by: _Reading
) -> None:
    passed = fixed_points(m, k)
    places = np.array([passed.frequency_p, passed.frequency_q], dtype=float)
    heights = np.array([passed.magnitude_p, passed.magnitude_q], dtype=float)
    errors = np.array([passed.error_p, passed.error_q], dtype=float)
    # what a power of x adds to |H| is the same for all dampings
    power = places ** transfer_of(*pair).power
    names = {"fixed_point": NAMES["fixed_point"]}
    read = [moved_by(partial(_passed, i)) for i in (0, 2)]
    scene.emit(
        f"{RESPONSE_ROOT}/fixed_point/frequency_ratio", places, 4.0 * EPSILON + read[0], names
    )
    uncertainty = (errors + 8.0 * EPSILON * heights + read[1]) * power
    scene.emit(f"{RESPONSE_ROOT}/fixed_point/magnitude", heights * power, uncertainty, names)


def _cite(scene: Scene) -> None:
    scene.cite(
        "complex response of the two-mass system, exact peaks from the stationarity polynomial",
        "curves, peaks, travel",
        "Baca Vasquez (2007), equations 2.8 to 2.10 and 3.13; docs/theory_absorber.md",
    )
