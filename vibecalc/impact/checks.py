"""Physical checks of joints with play: their gaps, their contacts, and the work they ask for."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from vibecalc.errors import KeyPath, Problem
from vibecalc.kinds import TRAIN, has_crank_train
from vibecalc.parts.crank_train import build_crank_train, rod_share
from vibecalc.parts.motor_tables import Play
from vibecalc.schema import Case, Machine

# ----------------------------------------------------------------------------
# The gaps of a cylinder with play in its joints, and the masses on their sides.
# ----------------------------------------------------------------------------

JOINTS: KeyPath = ("machine", "joints")


class Gap(NamedTuple):
    """A joint with play: its place in the case and the inverse of the mass that it moves, 1/kg."""

    path: KeyPath
    play: Play
    mobility: float


class Masses(NamedTuple):
    """All that moves with the piston of `cylinder`, kg, and the rod's share of it."""

    cylinder: str
    whole: float
    rod: float


def moving_masses(machine: Machine, working: Sequence[str] | None) -> Masses:
    """Those of the cylinder that [machine.joints] names, or of the first that works.

    `working` names the cylinders that work, None all.
    """
    case_train, joints = machine.crank_train, machine.joints
    train = build_crank_train(case_train)
    name = None if joints is None else joints.cylinder
    if name not in train.names:
        works = (each for each in train.names if working is None or each in working)
        name = next(works, train.names[0])
    rod = 0.0 if case_train.rod is None else float(case_train.rod.mass * rod_share(case_train))
    return Masses(name, float(train.reciprocating_mass[train.names.index(name)]), rod)


def _masses(case: Case) -> Masses:
    working = None if case.excitation is None else case.excitation.working
    return moving_masses(case.machine, working)


def plays(case: Case) -> Iterator[tuple[KeyPath, Play]]:
    """Every joint with play, with its place in the case."""
    joints = case.machine.joints
    for name in ("wrist_pin", "crank_pin", "bore"):
        play = getattr(joints, name)
        if play is not None:
            yield (*JOINTS, name), play


def gaps(case: Case) -> list[Gap]:
    """The gaps with the masses they move; none where a mass is missing."""
    joints, (_, whole, rod) = case.machine.joints, _masses(case)
    play_at_crank = joints is not None and joints.crank_pin is not None
    if whole <= rod or (play_at_crank and rod <= 0.0):
        return []
    of_rod, of_piston = 1.0 / rod if rod else 0.0, 1.0 / (whole - rod)
    across = {
        "wrist_pin": of_piston + of_rod * play_at_crank,
        "crank_pin": of_rod,
        "bore": of_piston,
    }
    return [Gap(path, play, across[str(path[-1])]) for path, play in plays(case)]


def _without_mass(case: Case) -> Iterator[Problem]:
    joints, (name, whole, rod) = case.machine.joints, _masses(case)
    if joints is not None and joints.crank_pin is not None and rod <= 0.0:
        yield Problem(
            path=(*JOINTS, "crank_pin"),
            message="clearance in the crank pin needs a rod, a mass between two clearances",
            found=f"{rod:.6g} kg of rod that moves with the piston",
            allowed="rod = { mass = ..., crank_pin_to_mass_centre = ... } in the crank train",
        )
    elif whole <= rod:
        yield Problem(
            path=(*JOINTS, "wrist_pin"),
            message=f"there is no mass on the piston's side of the wrist pin of {name!r}",
            found=f"{whole:.6g} kg that move with the piston, {rod:.6g} kg of them rod",
            allowed="a mass above zero of piston and pin",
            also=TRAIN,
        )


# ----------------------------------------------------------------------------
# What it costs to follow the impacts of a study from contact to contact.
# ----------------------------------------------------------------------------

IMPACT: KeyPath = ("response", "impact")
TURN = 2.0 * math.pi
#: Steps of one batch that a study may take, each about a millisecond: some 40 minutes.
MOST_WORK = 2e6
#: Runs that take as long as the step itself.
RUNS_OF_A_STEP = 150.0
#: A step of a fixed-step method, in steps from contact to contact.
FIXED_STEP = 0.25


class Work(NamedTuple):
    """What event-exact runs cost, as an estimate: about twice too much where contacts are few.

    `steps` of one run in a revolution, of a bound on the rates of the contacts; `total` steps of
    the batch over all revolutions, those of many runs counted as more, with those of a fixed-step
    method, which runs next to the event-exact one.
    """

    steps: float
    total: float


def _costs(case: Case) -> Iterator[Problem]:
    """A problem where the runs of a study would take too long, or not end."""
    work = impact_work(case)
    if work is None:
        return
    from vibecalc.impact.setup import MOST_STEPS  # only a study loads what follows it

    if work.steps > MOST_STEPS:
        yield Problem(
            path=("machine", "speed"),
            message="at this speed the contacts are too stiff or too strongly damped to be "
            "resolved over a whole revolution",
            found=f"{case.machine.speed:.6g} rad/s: about {work.steps:.2g} steps per revolution",
            allowed=f"<= {MOST_STEPS:.6g} steps per revolution",
            also=JOINTS,
            hint="steps per revolution rise with sqrt(stiffness / mass) and damping / mass, and "
            "fall with the speed",
        )
    elif work.total > MOST_WORK:
        yield Problem(
            path=IMPACT,
            message="the study would take too long",
            found=f"about {work.steps:.2g} steps per revolution of each run, about "
            f"{work.total / 1e3:.2g} s in total",
            allowed=f"<= {MOST_WORK / 1e3:.2g} s, as estimated",
            hint="fewer members, revolutions, clearances or fixed steps; steps per revolution rise "
            "with sqrt(stiffness / mass) and damping / mass, and fall with the speed",
        )


def impact_work(case: Case) -> Work | None:
    """What the impacts of a case cost; None without a study or joints that can be followed."""
    study = None if case.response is None else case.response.impact
    if study is None or case.machine.joints is None:
        return None
    in_contact = gaps(case)
    if not in_contact:
        return None
    from vibecalc.impact.setup import REACH

    turn = TURN / case.machine.speed
    rings = [math.sqrt(gap.play.stiffness * gap.mobility) for gap in in_contact]
    rates = [
        max(ring + gap.play.contact_damping * gap.mobility, gap.play.film_damping * gap.mobility)
        for ring, gap in zip(rings, in_contact, strict=True)
    ]
    gas = case.machine.crank_train.gas_pressure
    nodes = 0 if gas is None else len(gas.crank_angle)
    # steps also end at the nodes of the gas, and follow the highest order of the spectrum
    steps = max(rates) * turn / REACH + nodes + study.orders
    runs = (study.members + min(study.members, 16)) * max(len(study.clearances), 1)
    turns = study.discard + study.revolutions
    each = steps + (0.0 if study.method == "event_exact" else FIXED_STEP * study.steps)
    return Work(steps, turns * each * (1.0 + runs / RUNS_OF_A_STEP))


# ----------------------------------------------------------------------------
# Can there be impacts in these joints, and can their contacts be followed?
# ----------------------------------------------------------------------------

#: Share of a revolution: a shorter contact has no digits left in a time of many revolutions.
SHORTEST_CONTACT = 1e-7
#: Share of a revolution in which damping may bring a part to rest; faster is no longer motion.
FASTEST_DAMPING = 5e-6
#: Damping ratio of a contact: above, the damper and not the spring keeps the parts apart.
LARGEST_RATIO = 50.0
#: Angle of the contact's own vibration in one fixed step, beyond which Euler's kind runs away.
LONGEST_STEP = 2.0


def joint_problems(case: Case) -> list[Problem]:
    """Problems of joints with play, and of the study of impacts in them."""
    if not has_crank_train(case.machine) or case.machine.joints is None:
        return []
    problems = [*_clearances(case), *_stands(case), *_without_mass(case)]
    found = gaps(case)
    for gap in found:
        problems += [*_contact(case, gap), *_damping(case, gap)]
    # a contact that cannot be followed has no cost
    costs = [] if problems else [*_costs(case)]
    return [*problems, *costs, *_fixed_steps(case, found)]


def _clearances(case: Case) -> Iterator[Problem]:
    stroke = 2.0 * case.machine.crank_train.crank_radius
    study = None if case.response is None else case.response.impact
    several = () if study is None else study.clearances
    rows = [((*path, "clearance"), play.clearance) for path, play in plays(case)]
    rows += [((*IMPACT, "clearances", place), size) for place, size in enumerate(several)]
    for path, size in rows:
        if size >= stroke:
            yield Problem(
                path=path,
                message="the clearance is as large as the stroke",
                found=f"{size:.6g} m",
                allowed=f"< {stroke:.6g} m, the stroke",
                hint="lengths are in m unless they carry a unit, as in '0.04 mm'",
            )
    smallest = min(several or (rows[0][1],))
    if study is not None and 0.0 < smallest <= study.perturbation:
        yield Problem(
            path=(*IMPACT, "perturbation"),
            message="the perturbation exceeds the clearance",
            found=f"{study.perturbation:.6g} m, with a clearance of {smallest:.6g} m",
            allowed=f"< {smallest:.6g} m, recommended: a millionth of it",
        )


def _stands(case: Case) -> Iterator[Problem]:
    excitation, joints = case.excitation, case.machine.joints
    if excitation is None or excitation.working is None or excitation.idle != "stopped":
        return
    name = None if joints is None else joints.cylinder
    if name is not None and name not in excitation.working:
        yield Problem(
            path=(*JOINTS, "cylinder"),
            message="the cylinder with clearance in its joints is stopped",
            found=f"cylinder {name!r} is not in [excitation] working, and idle = 'stopped'",
            allowed="a cylinder that works",
            also=("excitation", "working"),
        )


def _contact(case: Case, gap: Gap) -> Iterator[Problem]:
    speed, stiffness = case.machine.speed, gap.play.stiffness
    lasts = math.pi / math.sqrt(stiffness * gap.mobility) * speed / TURN
    if lasts < SHORTEST_CONTACT:
        most = (math.pi * speed / (TURN * SHORTEST_CONTACT)) ** 2 / gap.mobility
        yield Problem(
            path=(*gap.path, "stiffness"),
            message="the contact is too stiff to be resolved in time",
            found=f"{stiffness:.6g} N/m: a contact lasts {lasts:.2g} of a revolution",
            allowed=f"<= {most:.3g} N/m with this mass and speed",
        )
    # inertia force m R w^2 over the stiffness, against the stroke 2 R
    least = 0.5 * speed**2 / gap.mobility
    if stiffness < least:
        yield Problem(
            path=(*gap.path, "stiffness"),
            message="the contact is so soft that the piston's inertia pushes it in by more than "
            "the stroke",
            found=f"{stiffness:.6g} N/m",
            allowed=f">= {least:.3g} N/m with this mass and speed",
            hint="stiffness is in N/m unless it carries a unit, as in '175 kN/mm'",
        )


def _damping(case: Case, gap: Gap) -> Iterator[Problem]:
    ratio = 2.0 * LARGEST_RATIO * math.sqrt(gap.play.stiffness / gap.mobility)
    rate = case.machine.speed / (TURN * FASTEST_DAMPING) / gap.mobility
    too_fast = "it stops the parts too fast to be resolved in time"
    bounds = {
        "contact_damping": min(
            (ratio, "the damper carries the whole contact force"), (rate, too_fast)
        ),
        "film_damping": (rate, too_fast),
    }
    for key, (most, why) in bounds.items():
        size = getattr(gap.play, key)
        if size > most:
            yield Problem(
                path=(*gap.path, key),
                message=f"{key} is so large that {why}",
                found=f"{size:.6g} N*s/m",
                allowed=f"<= {most:.3g} N*s/m with this mass, stiffness and speed",
                hint="damping is in N*s/m unless it carries a unit, as in '0.1 lbf*s/in'",
            )


def _fixed_steps(case: Case, in_contact: list[Gap]) -> Iterator[Problem]:
    study = None if case.response is None else case.response.impact
    if study is None or study.method == "event_exact":
        return
    path = (*IMPACT, "steps")
    if study.steps <= 2 * study.orders:
        yield Problem(
            path=path,
            message="response.impact.steps resolve only orders below half their number, fewer "
            "than response.impact.orders",
            found=f"{study.steps} steps per revolution for {study.orders} orders",
            allowed=f"> {2 * study.orders} steps, or < {study.steps / 2:g} orders",
            also=(*IMPACT, "orders"),
        )
    rates = [math.sqrt(gap.play.stiffness * gap.mobility) for gap in in_contact]
    needed = max(rates, default=0.0) * TURN / case.machine.speed
    if needed > LONGEST_STEP * study.steps:
        yield Problem(
            path=path,
            message="fixed steps this long are unstable in a contact this stiff",
            found=f"{study.steps} steps per revolution",
            allowed=f">= {math.ceil(needed / LONGEST_STEP)}, or method = 'event_exact'",
            also=(*in_contact[rates.index(max(rates))].path, "stiffness"),
        )
