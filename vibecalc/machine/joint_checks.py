"""Can there be impacts in these joints, and can their contacts be followed?"""

import math
from collections.abc import Iterator

from vibecalc.case.kinds import has_crank_train
from vibecalc.case.schema import Case
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.joint_cost import cost_problems
from vibecalc.machine.joint_gaps import JOINTS, Gap, gaps, plays

IMPACT: KeyPath = ("response", "impact")
TURN = 2.0 * math.pi
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
    joints = case.machine.joints
    if not has_crank_train(case.machine):
        return []
    names = [cylinder.name for cylinder in case.machine.crank_train.cylinders]
    if joints is None or (joints.cylinder is not None and joints.cylinder not in names):
        return []
    problems = [*_clearances(case), *_stands(case)]
    found = gaps(case, problems)
    for gap in found:
        problems += [*_contact(case, gap), *_damping(case, gap)]
    # a contact that cannot be followed has no cost
    costs = [] if problems else [*cost_problems(case, found)]
    return [*problems, *costs, *_orders(case), *_steps(case, found)]


def _clearances(case: Case) -> Iterator[Problem]:
    stroke = 2.0 * case.machine.crank_train.crank_radius
    study = None if case.response is None else case.response.impact
    several = () if study is None else study.clearances
    rows = [((*path, "clearance"), play.clearance) for path, play in plays(case)]
    rows += [((*IMPACT, "clearances", place), size) for place, size in enumerate(several)]
    for path, size in rows:
        if size <= 0.0 or size >= stroke:
            yield Problem(
                path=path,
                message="a clearance has to be above zero"
                if size <= 0.0
                else "a clearance as large as the stroke is no joint",
                found=f"{size:.6g} m",
                allowed=f"> 0 m and < {stroke:.6g} m, the stroke",
                hint="lengths are in m unless they carry a unit, as in '0.04 mm'",
            )
    for place, size in enumerate(several):
        if size in several[:place]:
            yield Problem(
                path=(*IMPACT, "clearances", place),
                message="a clearance stands twice",
                found=f"{size:.6g} m",
                allowed="each clearance once",
                also=(*IMPACT, "clearances", several.index(size)),
            )
    smallest = min(several or (rows[0][1],))
    if study is not None and 0.0 < smallest <= study.perturbation:
        yield Problem(
            path=(*IMPACT, "perturbation"),
            message="neighbours that start further apart than the clearance have parted already",
            found=f"{study.perturbation:.6g} m, with a clearance of {smallest:.6g} m",
            allowed=f"< {smallest:.6g} m, better a millionth of it",
        )


def _stands(case: Case) -> Iterator[Problem]:
    excitation, joints = case.excitation, case.machine.joints
    if excitation is None or excitation.working is None or excitation.idle != "stopped":
        return
    name = None if joints is None else joints.cylinder
    if name is not None and name not in excitation.working:
        yield Problem(
            path=(*JOINTS, "cylinder"),
            message="the cylinder with play in its joints stands still",
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
            message="the contact is too stiff to be followed",
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
    too_fast = "it brings the parts to rest too fast to be followed"
    bounds = {
        "contact_damping": min((ratio, "the damper bears the contact alone"), (rate, too_fast)),
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


def _orders(case: Case) -> Iterator[Problem]:
    study = None if case.response is None else case.response.impact
    if study is not None and study.method != "event_exact" and study.steps <= 2 * study.orders:
        yield Problem(
            path=(*IMPACT, "steps"),
            message="response.impact.steps hold only the orders below half their number, fewer "
            "than response.impact.orders",
            found=f"{study.steps} steps per revolution for {study.orders} orders",
            allowed=f"> {2 * study.orders} steps, or < {study.steps / 2:g} orders",
            also=(*IMPACT, "orders"),
        )


def _steps(case: Case, found: list[Gap]) -> Iterator[Problem]:
    study = None if case.response is None else case.response.impact
    if study is None or study.method == "event_exact" or not found:
        return
    gap = max(found, key=lambda each: each.play.stiffness * each.mobility)
    needed = math.sqrt(gap.play.stiffness * gap.mobility) * TURN / case.machine.speed
    if needed > LONGEST_STEP * study.steps:
        yield Problem(
            path=(*IMPACT, "steps"),
            message="fixed steps this long run away in a contact as stiff as this",
            found=f"{study.steps} steps per revolution",
            allowed=f">= {math.ceil(needed / LONGEST_STEP)}, or method = 'event_exact'",
            also=(*gap.path, "stiffness"),
        )
