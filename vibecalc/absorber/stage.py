"""The stages of a machine of kind "absorber": tuning, response, parts to buy, pendulums."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Harmonics, Leading, Stage, Subject, Unit, Work, below

if TYPE_CHECKING:
    from vibecalc.absorber.asked_tables import Tuning, Vary
    from vibecalc.schema import Case, Machine

_NO_ORDERS = "none: over the frequency"
#: responses to excitations that are 1 at rest, or at high frequency, whatever the absorber
_OVER_ONE = (
    ("force", "displacement"), ("force", "acceleration"), ("force", "transmitted_force"),
    ("base", "displacement"), ("unbalance", "displacement"),
)  # fmt: skip


def plan_absorber(case: "Case") -> Iterator[Stage]:
    """Tuning, the response with it or as given, its parts, pendulums; each where asked for."""
    machine = case.machine
    if machine.primary is not None:
        if case.tuning is not None:
            yield _tuning(case)
        if case.response is not None and case.response.absorber is not None:
            if in_ratios(case):
                yield _response(case)
            if excited_by(case):
                yield _motion(case)
        quantities = _hardware_quantities(case)
        if quantities:
            yield _hardware(quantities)
    if machine.pendulum is not None:
        yield _pendulum(case)


def asked_of(case: "Case") -> tuple[str, str]:
    """Excitation and response to draw: those said, else those of [tuning], else the usual ones."""
    response = None if case.response is None else case.response.absorber
    tuning = case.tuning
    excitation = None if response is None else response.excitation or excited_by(case)
    what = None if response is None else response.response
    return (
        excitation or (tuning.excitation if tuning is not None else "force"),
        what or (tuning.response if tuning is not None else "displacement"),
    )


def excited_by(case: "Case") -> str:
    """The excitation of which [response.absorber] gives the amplitude; empty without one."""
    response = None if case.response is None else case.response.absorber
    if response is None:
        return ""
    from vibecalc.absorber.asked_tables import AMPLITUDES

    said = [kind for key, kind in AMPLITUDES.items() if getattr(response, key) is not None]
    return said[0] if said else ""


def in_ratios(case: "Case") -> bool:
    """Whether curves in ratios are drawn: of a single mode, and not against the ground."""
    primary = case.machine.primary
    pair = asked_of(case)
    return not (primary and primary.modes) and not (
        pair[0] == "base_acceleration" or pair[1] == "deflection"
    )


def motions_of(case: "Case") -> tuple[str, ...]:
    """What is read in units: all that the excitation and the modes of a case give."""
    from vibecalc.absorber.readings import drifts

    excitation, machine = excited_by(case), case.machine
    modal = machine.primary is not None and bool(machine.primary.modes)
    return tuple(
        name
        for name, there in (
            ("displacement", True),
            ("velocity", True),
            ("acceleration", True),
            ("deflection", excitation.startswith("base")),
            ("transmitted_force", not modal),
            ("travel", True),
            ("spring_force", True),
            ("damper_force", True),
        )
        if there and not drifts(excitation, name)
    )


def is_banded(case: "Case") -> bool:
    """Whether a tuning counts within a band only."""
    options = case.tuning
    return options is not None and (options.band is not None or options.band_ratios is not None)


def white_ground(case: "Case") -> bool:
    """Whether a tuning is for the mean square under a white acceleration of the ground."""
    options = case.tuning
    return (
        options is not None
        and options.norm == "h2"
        and options.excitation == "base_acceleration"
        and not is_banded(case)
    )


def is_over_one(options: "Tuning") -> bool:
    """Whether the peak of a tuning has 1 as its floor: the response at rest, or far above."""
    pair = options.excitation, options.response
    return options.kind == "free" and options.norm == "h_infinity" and pair in _OVER_ONE


def has_fixed_points(case: "Case") -> bool:
    """Whether all curves of one absorber pass through points that its damping does not move."""
    pair = asked_of(case)
    of_primary = pair[1] in ("displacement", "velocity", "acceleration", "transmitted_force")
    through = of_primary and pair != ("base", "transmitted_force")
    return through and is_undamped(case.machine) and not case.machine.secondaries


def is_undamped(machine: "Machine") -> bool:
    """Whether the primary has no damping."""
    primary = machine.primary
    return primary is not None and not any(
        (
            *(primary.damping_ratio, primary.damping, primary.linear_damping),
            *(mode.damping_ratio for mode in primary.modes),
        )
    )


def has_units(machine: "Machine") -> bool:
    """Whether the primary has an inertia or a mass."""
    primary = machine.primary
    return primary is not None and (
        primary.inertia is not None or primary.mass is not None or bool(primary.modes)
    )


def _tuning(case: "Case") -> Stage:
    options, machine = case.tuning, case.machine
    assert options is not None
    several = bool(machine.secondaries)
    least_squares, banded = options.norm == "h2", is_banded(case)
    units = has_units(machine)
    turning = units and machine.primary is not None and machine.primary.inertia is not None
    sprung = options.kind in ("free", "undamped_spring")
    there = {
        "tuning/each/": several,
        "tuning/each/torsional_": several and turning,
        "tuning/each/linear_": several and units and not turning,
        "tuning/each/frequency": several and units,
        "tuning/travel": not several,
        "tuning/mass_ratio": not several,
        "tuning/stiffness_ratio": not several,
        "tuning/secondary_damping": not several,
        "tuning/own_damping": not several and options.kind == "free",
        "tuning/helps": (banded or not several) and options.frequency is None,
        "tuning/optimum/": options.frequency is not None,
        "tuning/without_spring": not (several or banded) and options.kind == "free",
        "tuning/threshold": not several and not least_squares and not banded,
        "tuning/band/": banded,
        "tuning/band/residual": banded and options.frequency is None,
        "tuning/active/weight": not least_squares and options.frequency is None,
        "tuning/tolerances/": options.tolerances is not None,
        "tuning/tolerances/exact/stiffness_ratio": options.tolerances is not None and not several,
        "tuning/tolerances/exact/secondary_damping": options.tolerances is not None and not several,
        "tuning/evaluations": not least_squares,
        "tuning/mean_square": least_squares,
        "tuning/active/": not least_squares,
        "tuning/peak_less_one": not several and is_over_one(options) and not banded,
        "tuning/certificate": not least_squares and options.kind == "free" and not banded,
        "tuning/torsional_stiffness": not several and turning and sprung,
        "tuning/torsional_damping": not several and turning,
        "tuning/linear_stiffness": not several and units and not turning and sprung,
        "tuning/linear_damping": not several and units and not turning,
        "tuning/secondary_frequency": not several and units and sprung,
        "tuning/method/": bool(options.compare),
        "tuning/mistuning/": bool(options.mistuning),
        "tuning/mistuning/worst": bool(options.mistuning) and (banded or not several),
        "tuning/sensitivity/": options.sensitivity,
        "tuning/unbounded/": options.bounds is not None and not several and not banded,
        "tuning/bounds/": options.bounds is not None and not several and not banded,
        "tuning/chart/": options.chart is not None,
        "tuning/map/": not (several or least_squares or banded) and options.kind == "free",
    }
    if white_ground(case):
        there |= dict.fromkeys(
            ("tuning/travel", "tuning/peak", "tuning/peak_alone", "tuning/peak_less_one",
             "tuning/method/peak", "tuning/method/promised"), False,
        )  # fmt: skip
    cost = "Newton's method, some tens of evaluations of a peak"
    if several:
        cost = "descents from many starts, then Newton's method"
    elif options.chart is not None:
        points = len(options.chart.primary_damping) * options.chart.mass_ratio.points
        cost += f"; the same for {points} points of the chart at once"
    return Stage(
        name="tuning",
        adapter="vibecalc.absorber.adapters.band:run_band_tuning"
        if banded or several
        else "vibecalc.absorber.adapters.tuning:run_absorber_tuning",
        why=f'[tuning] is in the case, norm = "{options.norm}"',
        parts=("primary", "secondaries" if several else "secondary"),
        orders=_NO_ORDERS,
        cost=cost,
        quantities=_paths_of("tuning/", there),
        work=_work_of_tuning,
        topics=()
        if banded or white_ground(case)
        else ("vibecalc.absorber.accuracy:tuning_topics",),
        leading=Leading(
            keys=TUNED_KEYS,
            only=TOGETHER,
            why_not=_one_by_one(case),
            adapter="vibecalc.absorber.arrays:tunings",
        ),
    )


#: numbers over which tunings are found together, and the results of it
TUNED_KEYS = frozenset(["machine.secondary.mass_ratio", "machine.primary.damping_ratio"])
TOGETHER = tuple(
    f"tuning/{name}"
    for name in (
        *("primary_damping", "mass_ratio", "stiffness_ratio", "secondary_damping"),
        *("own_damping", "peak"),
    )
)


def _one_by_one(case: "Case") -> str:
    """Why tunings of this case are not found together."""
    options, machine = case.tuning, case.machine
    if options is None or options.norm != "h_infinity" or options.kind != "free" or is_banded(case):
        return "only tunings of spring and damper for the largest amplitude are found together"
    if machine.secondary is None or machine.springs or machine.gap or machine.flywheel:
        return "several absorbers and their parts are computed point by point"
    if options.bounds is not None or options.compare or options.mistuning or options.sensitivity:
        return "what [tuning] asks for besides the optimum is computed point by point"
    return ""


def _response(case: "Case") -> Stage:
    several = bool(case.machine.secondaries)
    response = case.response
    assert response is not None and response.absorber is not None
    there = {
        "response/absorber/frequency": has_units(case.machine),
        "response/absorber/fixed_point/": has_fixed_points(case),
        "response/absorber/each/": several,
        "response/absorber/relative_curve": not several,
        "response/absorber/largest_travel": not several,
        "response/absorber/antiresonance": not several,
        "response/absorber/locked_frequency_ratio": not several,
        "response/absorber/natural_frequency_ratio": not several,
        "response/absorber/pole": not several,
        "response/absorber/primary_frequency": has_units(case.machine),
    }
    return Stage(
        name="absorber",
        adapter="vibecalc.absorber.adapters.several:run_several_response"
        if case.machine.secondaries
        else "vibecalc.absorber.adapters.response:run_absorber",
        why="[response.absorber] is in the case",
        parts=("primary", "secondaries" if several else "secondary"),
        orders=_NO_ORDERS,
        cost="one pass over the frequencies for each curve; peaks from a polynomial",
        quantities=_paths_of("response/absorber/", there | {"response/absorber/motion/": False}),
        is_last=True,
        work=_work_of_absorber,
        topics=("vibecalc.absorber.accuracy:absorber_topics",),
        leading=None
        if several
        else Leading(
            keys=RATIO_KEYS,
            only=PEAKS,
            why_not="the response at a tuning is computed point by point" * bool(case.tuning),
        ),
    )


#: numbers of primary and secondary over which the peaks of one absorber are found together
RATIO_KEYS = frozenset(
    [
        *(f"machine.primary.{one}" for one in ("damping_ratio", "natural_frequency")),
        "machine.secondary.mass_ratio",
        *(f"machine.secondary.{one}_ratio" for one in ("stiffness", "damping", "own_damping")),
        *(
            f"machine.{system}.{one}"
            for system in ("primary", "secondary")
            for one in (
                *("inertia", "stiffness", "damping", "mass", "linear_stiffness"),
                "linear_damping",
            )
        ),
    ]
)
#: the results of it
PEAKS = tuple(
    f"response/absorber/{name}"
    for name in (
        *("peak/magnitude", "peak/frequency_ratio", "largest", "largest_frequency_ratio"),
        "largest_travel",
    )
)
#: all others of one absorber
SHOWN = tuple(path for path in below("response/absorber/") if path not in PEAKS)


def _motion(case: "Case") -> Stage:
    from vibecalc.absorber.motion_results import (
        IN_BAND_ROOT,
        MOTION_ROOT,
        TORSION,
        TRANSLATION,
        WITHOUT_ROOT,
    )
    from vibecalc.absorber.readings import OF_ABSORBER

    primary = case.machine.primary
    torsion = primary is not None and primary.inertia is not None
    names = TORSION if torsion else TRANSLATION
    several = bool(case.machine.secondaries)
    curves = ("", "largest/", "largest_at/")
    banded = [f"{IN_BAND_ROOT}/", f"{IN_BAND_ROOT}/at/"] if is_banded(case) else []
    return Stage(
        name="absorber motion",
        adapter="vibecalc.absorber.adapters.motion:run_motion",
        why="[response.absorber] has an amplitude",
        parts=("primary", "secondaries" if several else "secondary"),
        orders=_NO_ORDERS,
        cost="a small solve for each frequency; peaks between seeds about all poles",
        quantities=tuple(
            f"{root}{'each/' * (several and one in OF_ABSORBER)}{names[one][0]}"
            for one in motions_of(case)
            for root in (
                *(f"{MOTION_ROOT}/{table}" for table in curves),
                *(f"{WITHOUT_ROOT}/{table}" for table in curves if one not in OF_ABSORBER),
                *banded,
            )
        ),
        is_last=True,
        work=_work_of_motion,
    )


def _hardware_quantities(case: "Case") -> tuple[str, ...]:
    machine = case.machine
    tuned = case.tuning is not None
    springs, gap = machine.springs, machine.gap
    sprung = springs is not None and (springs.rate is not None or springs.wire_diameter is not None)
    oiled = gap is not None and machine.oil is not None
    oils = gap is not None and bool(machine.stock_oils or machine.oil_catalogue)
    rates = springs is not None and bool(machine.stock_springs or machine.spring_catalogue)
    viscous = case.tuning is not None and case.tuning.kind in ("viscous", "lanchester")
    built = oiled and (sprung or viscous)
    rod = machine.rod is not None and machine.rod.length is not None
    bends = machine.flywheel is not None
    by_peak = case.tuning is not None and case.tuning.norm == "h_infinity"
    pairs = by_peak and oils and (rates or viscous)
    moving = machine.primary is not None and machine.primary.mass is not None
    dampers = bool(machine.stock_dampers)
    damper_pairs = by_peak and moving and (dampers or rates)
    warms = case.tuning is not None and case.tuning.temperatures is not None and (pairs or built)
    there = {
        "hardware/rod_stiffness": rod,
        "hardware/ring": machine.ring is not None,
        "hardware/primary_frequency": rod or springs is not None or gap is not None or dampers,
        "hardware/built/stiffness_ratio": sprung,
        "hardware/built/spring_rate": sprung,
        "hardware/built/secondary_damping": oiled,
        "hardware/built/peak": built,
        "hardware/spring_rate": springs is not None and tuned and not viscous,
        "hardware/clearance": gap is not None,
        "hardware/gap/": gap is not None,
        "hardware/dynamic_viscosity": gap is not None and tuned,
        "hardware/spring/": rates,
        "hardware/oil/": oils,
        "hardware/oil/right_temperature": oils and tuned,
        "hardware/pair/": pairs,
        "hardware/buy/": pairs or damper_pairs,
        "hardware/damper/": dampers,
        "hardware/damper_pair/": damper_pairs,
        "hardware/warming/": warms,
        "hardware/warming/best": warms and not viscous,
        "hardware/bending/": bends,
        "hardware/bending/forward": bends and bool(machine.flywheel and machine.flywheel.spin),
        "hardware/bending/backward": bends and bool(machine.flywheel and machine.flywheel.spin),
    }
    return _paths_of("hardware/", there)


def _hardware(quantities: tuple[str, ...]) -> Stage:
    return Stage(
        name="hardware",
        adapter="vibecalc.absorber.adapters.hardware:run_absorber_parts",
        why="the case has parts: rod, springs, ring, gap, oils or stock",
        parts=("rod", "springs", "ring", "gap", "oil", "stock"),
        orders=_NO_ORDERS,
        cost="closed forms, and the peaks of every pair of stock parts",
        quantities=quantities,
        is_last=True,
        work=_work_of_hardware,
    )


def _pendulum(case: "Case") -> Stage:
    given = case.machine.pendulum
    assert given is not None
    driven = given.torque is not None
    there = {
        "pendulum/order_of_swing": given.swings is not None,
        "pendulum/small/": driven,
        "pendulum/response/": driven,
        "pendulum/steady/": given.swings is not None and given.rotor_stiffness == 0.0,
        "pendulum/jump/": given.path == "circular" and given.rotor_stiffness == 0.0,
    }
    return Stage(
        name="pendulum",
        adapter="vibecalc.absorber.adapters.pendulum:run_absorber_pendulum",
        why="[machine.pendulum] is in the case",
        parts=("pendulum",),
        orders=f"{given.order:g} of the speed of the rotor",
        cost="closed forms; quadrature and Newton's method for each swing",
        quantities=_paths_of("pendulum/", there),
        is_last=True,
        harmonics=_orders_of_pendulum,
        work=_work_of_pendulum,
        topics=("vibecalc.absorber.accuracy:pendulum_topics",),
    )


def _paths_of(root: str, there: dict[str, bool]) -> tuple[str, ...]:
    """Paths below `root`; of the beginnings that fit a path the longest decides."""
    paths = []
    for path in below(root):
        fitting = [start for start in there if path.startswith(start)]
        if not fitting or there[max(fitting, key=len)]:
            paths.append(path)
    return tuple(paths)


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------


def _orders_of_pendulum(case: "Case") -> Harmonics:
    assert case.machine.pendulum is not None
    order = case.machine.pendulum.order
    return Harmonics(1, order, order, "of the speed of the rotor")


def _work_of_tuning(case: "Case", orders: int) -> Work:
    options = case.tuning
    assert options is not None
    several = len(case.machine.secondaries)
    if is_banded(case):
        searches = 1.0 + 2.0 * (options.tolerances is not None)
        return ((searches * max(1, several) ** 2, "band_search"),)
    if several:
        return ((1, "several"), (len(options.mistuning) / 3.0, "peak_search"))
    chart = options.chart
    points = 0 if chart is None else len(chart.primary_damping) * chart.mass_ratio.points
    searches = 1.0 + 0.8 * len(options.compare) + len(options.mistuning) / 3.0
    searches += bool(options.sensitivity) + (options.bounds is not None)
    return ((round(searches, 1), "peak_search"), (points, "chart_point"))


def _work_of_absorber(case: "Case", orders: int) -> Work:
    assert case.response is not None and case.response.absorber is not None
    options = case.response.absorber
    swept = options.frequency_ratios or options.frequencies
    vary = options.vary
    curves = 1 if vary is None else 1 + max(len(values) for _, values in vary)
    points = 400 if swept is None else swept.points
    return ((curves * points, "curve_point"), (1 + options.limits, "peaks"))


def _work_of_motion(case: "Case", orders: int) -> Work:
    assert case.response is not None and case.response.absorber is not None
    options = case.response.absorber
    swept = options.frequency_ratios or options.frequencies
    return ((len(motions_of(case)) * (400 if swept is None else swept.points), "motion_point"),)


def _work_of_hardware(case: "Case", orders: int) -> Work:
    machine = case.machine
    springs = bool(machine.stock_springs or machine.spring_catalogue)
    oils = bool(machine.stock_oils or machine.oil_catalogue)
    return ((1 + springs if oils else 0, "parts"),)


def _work_of_pendulum(case: "Case", orders: int) -> Work:
    given = case.machine.pendulum
    assert given is not None
    return ((1 if given.swings is None else given.swings.points, "swing"),)


#: curves of the primary with all masses fastened rigidly, and with none
LIMITS = ("locked", "free")
#: parts where nothing is wanted, and where the stock has nothing, so that the tuning's own stays
NO_SPRING, AS_TUNED = "none", "as tuned"
VISCOUS = ("viscous", "lanchester")


def curve_names(case: "Case") -> tuple[str, ...]:
    """The absorbers whose curves [response.absorber] draws: as given or tuned, limits, family."""
    options = case.response and case.response.absorber
    if not options:
        return ()
    names = ["as given" if case.tuning is None else "tuned", *(LIMITS if options.limits else ())]
    if options.vary is not None:
        from vibecalc.absorber.asked_tables import VARIED

        key = varied_key(options.vary)
        names += [f"{VARIED[key]} {value:g}" for value in getattr(options.vary, key)]
    return tuple(names)


def varied_key(vary: "Vary") -> str:
    """The ratio that varies."""
    from vibecalc.absorber.asked_tables import VARIED

    return next(key for key in VARIED if getattr(vary, key))


def names_of(case: "Case") -> dict[str, tuple[str, ...]]:
    """Entries of the axes that the case names."""
    machine, tuning = case.machine, case.tuning
    if machine.primary is None:
        return {}
    from vibecalc.absorber.model import stock

    known, kind = stock(machine), "" if tuning is None else tuning.kind
    spring = NO_SPRING if kind in VISCOUS else AS_TUNED
    damper = NO_SPRING if kind == "undamped_spring" else AS_TUNED
    named = {
        "absorber": tuple(one.name for one in machine.secondaries),
        "curve": curve_names(case),
        "method": () if tuning is None else tuning.compare,
        "stock_oil": tuple(oil.name for oil in known.oils),
    }
    # which mixtures are worth showing is not known before the run
    if len(known.spring_names) == known.plain_springs:
        named["stock_spring"] = known.spring_names or (spring,)
    if len(known.damper_names) == known.plain_dampers:
        named["stock_damper"] = known.damper_names or (damper,)
    return named


SUBJECT = Subject(
    stages=(plan_absorber,),
    names=names_of,
    concerns=lambda case: case.machine.kind == "absorber",
    units={
        "peak_search": Unit(1.0e-1, "searches for the lowest peak", "scipy.optimize"),
        "chart_point": Unit(3.0e-4, "points of the chart"),
        "several": Unit(3.0e-1, "searches over several absorbers", "scipy.optimize"),
        "band_search": Unit(1.0, "searches within a band", "scipy.optimize"),
        "motion_point": Unit(1.2e-4, "points of motions"),
        "curve_point": Unit(1.5e-6, "points of the curves"),
        "peaks": Unit(2.5e-2, "sets of peaks, poles and limits"),
        "parts": Unit(1.0e-1, "sets of stock parts held against the tuning"),
        "swing": Unit(4.5e-2, "swings of a pendulum"),
    },
    checks=(
        "vibecalc.absorber.checks:absorber_problems",
        "vibecalc.absorber.checks:absorber_part_problems",
        "vibecalc.absorber.checks:pendulum_problems",
    ),
    suspects={
        "vibecalc.absorber.checks:absorber_problems": "vibecalc.absorber.checks:absorber_suspects"
    },
    sections=(
        "vibecalc.absorber.report.tuning:absorber_tuning",
        "vibecalc.absorber.report.tuning:absorber",
        "vibecalc.absorber.report.motion:absorber_motion",
        "vibecalc.absorber.report.hardware:absorber_parts",
        "vibecalc.absorber.report.tuning:pendulum",
    ),
    pictures={
        "absorber_curves": "vibecalc.absorber.pictures:draw_absorber_curves",
        "absorber_motion": "vibecalc.absorber.motion_pictures:ABSORBER_MOTION",
        "absorber_surface": "vibecalc.absorber.pictures:draw_absorber_surface",
        "absorber_map": "vibecalc.absorber.pictures:draw_absorber_map",
        "absorber_chart": "vibecalc.absorber.pictures:draw_absorber_chart",
        "absorber_warming": "vibecalc.absorber.pictures:ABSORBER_WARMING",
        "pendulum": "vibecalc.absorber.pictures:SWINGING",
    },
)
