"""The stages of a machine of kind "absorber": tuning, response, parts to buy, pendulums."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import Harmonics, Leading, Stage, Subject, Unit, Work, below

if TYPE_CHECKING:
    from vibecalc.absorber.asked_tables import AbsorberResponse, Tuning, Vary
    from vibecalc.schema import Case, Machine

_NO_ORDERS = "none (frequency domain)"
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
        yield from _hardware(case)
    if machine.friction_damper is not None:
        yield _friction(case)
    if machine.pendulum is not None:
        yield _pendulum(case)


def asked_of(case: "Case") -> tuple[str, str]:
    """Excitation and response to draw: those said, else those of [tuning], else the usual ones."""
    from vibecalc.absorber.asked_tables import excitation_and_response

    response = None if case.response is None else case.response.absorber
    tables = ({} if table is None else vars(table) for table in (response, case.tuning))
    return excitation_and_response(*tables)


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
    from vibecalc.absorber.motion_results import TRANSLATION
    from vibecalc.absorber.readings import drifts

    excitation, primary = excited_by(case), case.machine.primary
    modal = primary is not None and bool(primary.modes)
    there = {"deflection": excitation.startswith("base"), "transmitted_force": not modal}
    return tuple(
        name for name in TRANSLATION if there.get(name, True) and not drifts(excitation, name)
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
    several, one = bool(machine.secondaries), not machine.secondaries
    least_squares, banded, white = options.norm == "h2", is_banded(case), white_ground(case)
    units = has_units(machine)
    turning = units and machine.primary is not None and machine.primary.inertia is not None
    moving = units and not turning
    free, sprung = options.kind == "free", options.kind in ("free", "undamped_spring")
    seen, swings = options.compare and not white, options.frequency is not None
    bounded = options.bounds is not None and one and not banded
    quantities = _paths(
        "tuning/",
        (several, "each/"),
        (several and turning, "each/torsional_"),
        (several and moving, "each/linear_"),
        (several and units, "each/frequency"),
        (one, "mass_ratio stiffness_ratio damping_over_primary_critical"),
        (not white, "peak peak_alone"),
        (one and not white, "travel"),
        (one and free, "absorber_damping_ratio"),
        ((banded or one) and not swings, "helps"),
        (swings, "optimum/"),
        (one and free and not banded, "without_spring"),
        (one and not least_squares and not banded, "threshold"),
        (banded, "band/"),
        (banded and not swings, "band/residual"),
        (not least_squares, "active/ evaluations"),
        (not (least_squares or swings), "active/weight"),
        (options.tolerances is not None, "tolerances/"),
        (options.tolerances is not None and one, "tolerances/exact/stiffness_ratio"),
        (options.tolerances is not None and one, "tolerances/exact/damping_over_primary_critical"),
        (least_squares, "mean_square"),
        (one and is_over_one(options) and not banded, "peak_less_one"),
        (free and not least_squares and not banded, "certificate"),
        (one and turning and sprung, "torsional_stiffness"),
        (one and turning, "torsional_damping"),
        (one and moving and sprung, "linear_stiffness"),
        (one and moving, "linear_damping"),
        (one and units and sprung, "secondary_frequency"),
        (bool(options.compare), "method/"),
        (bool(seen), "method/peak method/promised"),
        (bool(options.mistuning), "mistuning/"),
        (bool(options.mistuning) and (banded or one), "mistuning/worst"),
        (options.sensitivity, "sensitivity/"),
        (bounded, "unbounded/ bounds/"),
        (options.chart is not None, "chart/"),
        (one and free and not (least_squares or banded), "map/"),
    )
    chart, cost = options.chart, "Newton's method, tens of peak evaluations"
    points = 0 if chart is None else len(chart.primary_damping) * chart.mass_ratio.points
    searches = 1.0 + 0.8 * len(options.compare) + len(options.mistuning) / 3.0
    searches += options.sensitivity + (options.bounds is not None)
    work: Work = (round(searches, 1), "peak_search"), (points, "chart_point")
    if several:
        cost = "multi-start descent, then Newton's method"
        work = (1, "several"), (len(options.mistuning) / 3.0, "peak_search")
    elif points:
        cost += f"; the same for {points} points of the chart at once"
    if banded:
        searches = 1.0 + 2.0 * (options.tolerances is not None)
        work = ((searches * max(1, len(machine.secondaries)) ** 2, "band_search"),)
    place = "band:run_band" if banded or several else "tuning:run_absorber"
    topics = () if banded or white else ("vibecalc.absorber.accuracy:tuning_topics",)
    return Stage(
        name="tuning",
        adapter=f"vibecalc.absorber.adapters.{place}_tuning",
        why=f'[tuning] is in the case, norm = "{options.norm}"',
        parts=("primary", "secondaries" if several else "secondary"),
        orders=_NO_ORDERS,
        cost=cost,
        quantities=quantities,
        work=lambda case, orders: work,
        topics=topics,
        leading=Leading(
            keys=TUNED_KEYS,
            only=TOGETHER,
            why_not=_one_by_one(case),
            adapter="vibecalc.absorber.arrays:tunings",
        ),
    )


#: numbers over which tunings are found together, and the results of it
TUNED_KEYS = frozenset(["machine.secondary.mass_ratio", "machine.primary.damping_ratio"])
_TOGETHER = (
    "primary_damping mass_ratio stiffness_ratio damping_over_primary_critical "
    "absorber_damping_ratio peak"
)
TOGETHER = tuple(f"tuning/{name}" for name in _TOGETHER.split())


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
    several, units = bool(case.machine.secondaries), has_units(case.machine)
    options = case.response and case.response.absorber
    assert options
    vary = options.vary
    curves = 1 if vary is None else 1 + max(len(values) for _, values in vary)
    work = (curves * _points(options), "curve_point"), (1 + options.limits, "peaks")
    alone = (
        "relative_curve largest_travel antiresonance locked_frequency_ratio "
        "natural_frequency_ratio pole"
    )
    kind = "several:run_several_response" if several else "response:run_absorber"
    return Stage(
        name="absorber",
        adapter=f"vibecalc.absorber.adapters.{kind}",
        why="[response.absorber] is in the case",
        parts=("primary", "secondaries" if several else "secondary"),
        orders=_NO_ORDERS,
        cost="one pass over the frequencies for each curve; peaks from a polynomial",
        quantities=_paths(
            "response/absorber/",
            (units, "frequency primary_frequency"),
            (has_fixed_points(case), "fixed_point/"),
            (several, "each/"),
            (not several, alone),
            (False, "motion/"),
        ),
        is_last=True,
        work=lambda case, orders: work,
        topics=("vibecalc.absorber.accuracy:absorber_topics",),
        leading=None
        if several
        else Leading(
            keys=RATIO_KEYS,
            only=PEAKS,
            why_not="the response at a tuning is computed point by point" * bool(case.tuning),
        ),
    )


def _points(options: "AbsorberResponse") -> int:
    """Frequencies of a curve."""
    swept = options.frequency_ratios or options.frequencies
    return 400 if swept is None else swept.points


#: numbers of primary and secondary over which the peaks of one absorber are found together
_OF_BOTH = "inertia stiffness damping mass linear_stiffness linear_damping"
_OF_SECONDARY = "mass_ratio stiffness_ratio damping_over_primary_critical absorber_damping_ratio"
RATIO_KEYS = frozenset(
    f"machine.{system}.{key}"
    for system, own in (
        ("primary", "damping_ratio natural_frequency"),
        ("secondary", _OF_SECONDARY),
    )
    for key in f"{own} {_OF_BOTH}".split()
)
#: the results of it
PEAKS = tuple(
    f"response/absorber/{name}"
    for name in ("peak/magnitude", "peak/frequency_ratio", "largest", "largest_frequency_ratio",
                 "largest_travel")
)  # fmt: skip
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
    assert case.response is not None and case.response.absorber is not None
    motions, points = len(motions_of(case)), _points(case.response.absorber)
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
        work=lambda case, orders: ((motions * points, "motion_point"),),
    )


def _hardware(case: "Case") -> Iterator[Stage]:
    """What the parts of a case give, if it has any."""
    machine, tuning = case.machine, case.tuning
    springs, gap, wheel = machine.springs, machine.gap, machine.flywheel
    sprung = springs is not None and (springs.rate is not None or springs.wire_diameter is not None)
    oiled = gap is not None and machine.oil is not None
    oils = gap is not None and bool(machine.stock_oils or machine.oil_catalogue)
    rates = springs is not None and bool(machine.stock_springs or machine.spring_catalogue)
    viscous = tuning is not None and tuning.kind in VISCOUS
    built = oiled and (sprung or viscous)
    rod = machine.rod is not None and machine.rod.length is not None
    by_peak = tuning is not None and tuning.norm == "h_infinity"
    pairs = by_peak and oils and (rates or viscous)
    moving = machine.primary is not None and machine.primary.mass is not None
    dampers = bool(machine.stock_dampers)
    damper_pairs = by_peak and moving and (dampers or rates)
    warms = tuning is not None and tuning.temperatures is not None and (pairs or built)
    quantities = _paths(
        "hardware/",
        (rod, "rod_stiffness"),
        (machine.ring is not None, "ring"),
        (rod or springs is not None or gap is not None or dampers, "primary_frequency"),
        (sprung, "built/stiffness_ratio built/spring_rate"),
        (oiled, "built/damping_over_primary_critical"),
        (built, "built/peak"),
        (springs is not None and tuning is not None and not viscous, "spring_rate"),
        (gap is not None, "clearance gap/"),
        (gap is not None and tuning is not None, "dynamic_viscosity"),
        (rates, "spring/"),
        (oils, "oil/"),
        (oils and tuning is not None, "oil/right_temperature"),
        (pairs, "pair/"),
        (pairs or damper_pairs, "buy/"),
        (dampers, "damper/"),
        (damper_pairs, "damper_pair/"),
        (warms, "warming/"),
        (warms and not viscous, "warming/best"),
        (wheel is not None, "bending/"),
        (wheel is not None and bool(wheel.spin), "bending/forward bending/backward"),
    )
    work = ((1 + rates if oils else 0, "parts"),)
    if quantities:
        yield Stage(
            name="hardware",
            adapter="vibecalc.absorber.adapters.hardware:run_absorber_parts",
            why="the case has parts: rod, springs, ring, gap, oils or stock",
            parts=("rod", "springs", "ring", "gap", "oil", "stock"),
            orders=_NO_ORDERS,
            cost="closed forms, and the peaks of every pair of stock parts",
            quantities=quantities,
            is_last=True,
            work=lambda case, orders: work,
        )


def _friction(case: "Case") -> Stage:
    given, primary = case.machine.friction_damper, case.machine.primary
    assert given is not None
    torsion = primary is not None and primary.inertia is not None
    forced = given.torque is not None or given.force is not None
    return Stage(
        name="friction damper",
        adapter="vibecalc.absorber.adapters.friction_damper:run_friction_damper",
        why="[machine.friction_damper] is in the case",
        parts=("primary", "friction_damper"),
        orders=_NO_ORDERS,
        cost="the amplitude at each frequency by bisection; the best friction by a search",
        quantities=_paths(
            "friction_damper/",
            (forced and torsion, "friction_torque largest_angle"),
            (forced and not torsion, "friction_force largest_displacement"),
        ),
        is_last=True,
        work=lambda case, orders: ((1, "friction"),),
    )


def _pendulum(case: "Case") -> Stage:
    given = case.machine.pendulum
    assert given is not None
    driven, held = given.torque is not None, given.rotor_stiffness != 0.0
    order = Harmonics(1, given.order, given.order, "of the speed of the rotor")
    swings = 1 if given.swings is None else given.swings.points
    return Stage(
        name="pendulum",
        adapter="vibecalc.absorber.adapters.pendulum:run_absorber_pendulum",
        why="[machine.pendulum] is in the case",
        parts=("pendulum",),
        orders=f"{given.order:g} of the speed of the rotor",
        cost="closed forms; quadrature and Newton's method for each swing",
        quantities=_paths(
            "pendulum/",
            (given.swings is not None, "order_of_swing"),
            (driven, "small/ response/"),
            (given.swings is not None and not held, "steady/"),
            (given.path == "circular" and not held, "jump/"),
        ),
        is_last=True,
        harmonics=lambda case: order,
        work=lambda case, orders: ((swings, "swing"),),
        topics=("vibecalc.absorber.accuracy:pendulum_topics",),
    )


def _paths(root: str, *rules: tuple[bool, str]) -> tuple[str, ...]:
    """Paths below `root` but those that a rule leaves out.

    Of the beginnings that fit a path the longest decides.
    """
    there = {f"{root}{start}": given for given, starts in rules for start in starts.split()}
    paths = []
    for path in below(root):
        fitting = [start for start in there if path.startswith(start)]
        if not fitting or there[max(fitting, key=len)]:
            paths.append(path)
    return tuple(paths)


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


def names_of(case: "Case", _: str = "") -> dict[str, tuple[str, ...]]:
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
        "peak_search": Unit(1.0e-1, "peak searches", "scipy.optimize"),
        "chart_point": Unit(3.0e-4, "points of the chart"),
        "several": Unit(3.0e-1, "searches over several absorbers", "scipy.optimize"),
        "band_search": Unit(1.0, "searches within a band", "scipy.optimize"),
        "motion_point": Unit(1.2e-4, "points of motions"),
        "curve_point": Unit(1.5e-6, "points of the curves"),
        "peaks": Unit(2.5e-2, "sets of peaks, poles and limits"),
        "parts": Unit(1.0e-1, "sets of stock parts compared with the tuning"),
        "friction": Unit(1.0, "searches for the best friction", "scipy.optimize"),
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
        "vibecalc.absorber.report.tuning:friction_damper",
        "vibecalc.absorber.report.tuning:pendulum",
    ),
    pictures={
        "absorber_curves": "vibecalc.absorber.pictures:ABSORBER_CURVES",
        "absorber_motion": "vibecalc.absorber.motion_pictures:ABSORBER_MOTION",
        "absorber_surface": "vibecalc.absorber.pictures:draw_absorber_surface",
        "absorber_map": "vibecalc.absorber.pictures:draw_absorber_map",
        "absorber_chart": "vibecalc.absorber.pictures:draw_absorber_chart",
        "absorber_warming": "vibecalc.absorber.pictures:ABSORBER_WARMING",
        "pendulum": "vibecalc.absorber.pictures:SWINGING",
    },
    assumes=(
        "The primary is linear and has one mode, or the modes given; absorbers are linear, "
        "pendulums swing by large angles. The excitation is steady: harmonic or white noise.",
    ),
)
