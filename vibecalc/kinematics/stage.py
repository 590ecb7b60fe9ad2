"""The stage of the motion of the pistons."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from vibecalc.core.run.stage import (
    Entries,
    Harmonics,
    Leading,
    Stage,
    Subject,
    Unit,
    below,
    first_orders,
)
from vibecalc.kinds import has_crank_train, has_speed
from vibecalc.parts.array_keys import BODY_KEYS, INERTIA_PRODUCTS, MOVING_KEYS, PLACING_KEYS
from vibecalc.parts.firing import shakes_with_torque

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_kinematics(case: "Case") -> Iterator[Stage]:
    asked = case.kinematics is not None
    if not (asked or needs_excitation(case)):
        return
    curves = () if asked else ("/position", "/velocity", "/acceleration")
    none = () if case.machine.crank_train.has_slave_rods else ("/cylinder/",)
    paths = tuple(
        path for path in below("kinematics/", none) if not path.endswith(curves or ("//",))
    )
    yield Stage(
        name="kinematics",
        adapter="vibecalc.kinematics.adapter:run_kinematics",
        why="[kinematics] is in the case" if asked else "the excitation needs the piston motion",
        parts=("crank_train",),
        orders=orders_words(case),
        cost="one pass over the orders" + (", 361 crank angles" if asked else ""),
        quantities=paths,
        harmonics=orders_of_motion,
        work=lambda case, orders: ((1, "motion"),),
        topics=("vibecalc.kinematics.accuracy:kinematics_topics",),
        leading=_leading(case),
    )


def _leading(case: "Case") -> Leading:
    """Of a machine whose crank turns steadily; its body has to weigh more than what moves in it."""
    body = case.machine.body
    keys = MOVING_KEYS | PLACING_KEYS | BODY_KEYS | {"machine.speed"}
    if body is not None and body.inertia is not None:
        keys |= INERTIA_PRODUCTS
    slave_rods = case.machine.crank_train.has_slave_rods
    return Leading(keys=keys, why_not="slave rods are followed point by point" * slave_rods)


def needs_excitation(case: "Case") -> bool:
    if not has_speed(case.machine):  # [excitation] then says at most which cylinders work
        return False
    if not has_crank_train(case.machine):
        return False
    if case.machine.kind == "engine" and (case.machine.body is None or case.machine.mounts is None):
        # a shaft line has an excitation of its own
        return case.excitation is not None or case.balance is not None
    asking = (case.excitation, case.balance, case.response, case.isolation)
    return any(table is not None for table in asking)


def orders_words(case: "Case") -> str:
    if case.excitation and case.excitation.orders:
        return f"1 to {case.excitation.orders}, as the case asks"
    if case.kinematics and case.kinematics.series == "truncated":
        last = (4 if shakes_with_torque(case) else 2) * (case.kinematics.terms or 1)
        return f"1 to {last}, all of the truncated series"
    return f"until the rest is below rtol = {case.accuracy.rtol:g}"


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------


def orders_of_motion(case: "Case") -> Harmonics:
    """Orders of the piston motion, and so of all forces that come from it."""
    train, options = case.machine.crank_train, case.excitation
    if options is not None and options.orders is not None:
        return first_orders(options.orders, "[excitation] orders")
    if case.kinematics is not None and case.kinematics.series == "truncated":
        terms = case.kinematics.terms or 1
        enough = (4 if shakes_with_torque(case) else 2) * terms
        rule = "all of the truncated series"
    else:
        from vibecalc.kinematics.harmonics import order_for_tolerance

        ratio = train.crank_radius / train.rod_length
        offset = (train.wrist_pin_offset or 0.0) / train.crank_radius
        if train.has_slave_rods:
            from vibecalc.parts.articulated import steepest_ratio

            ratio = steepest_ratio(train)
        enough = int(order_for_tolerance(ratio, case.accuracy.rtol, offset))
        rule = f"R/L = {ratio:.4g}, the rest below rtol = {case.accuracy.rtol:g}"
    ratios = [shaft.speed_ratio for shaft in train.balance_shafts]
    ratios += [shaft.speed_ratio for shaft in case.balance.shafts] if case.balance else []
    turning = max(map(abs, ratios), default=1)
    if turning > enough:
        return first_orders(turning, "the fastest balance shaft")
    return first_orders(max(enough, 1), rule)


def orders_given(case: "Case", axis: str, first: int = 1) -> Entries | None:
    """Orders of the crank train that the case or its tolerance keeps."""
    if axis != "order":
        return None
    kept = orders_of_motion(case)
    return Entries.up_to(int(kept.highest), f"orders that are kept: {kept.rule}", first)


SUBJECT = Subject(
    stages=(plan_kinematics,),
    concerns=lambda case: has_crank_train(case.machine),
    units={"motion": Unit(1.0e-3, "passes over the motion of the pistons")},
    entries=lambda case, path, axis: orders_given(case, axis, 0),
    sections=("vibecalc.kinematics.report:kinematics",),
    pictures={
        "pistons_on_slave_rods": "vibecalc.kinematics.pictures:SLAVE_RODS",
        "piston_motion": "vibecalc.kinematics.pictures:PISTON_MOTION",
        "piston_acceleration": "vibecalc.kinematics.pictures:PISTON_ACCELERATION",
    },
    assumes=(
        "Crank, rods and pistons are rigid; the motion of the slider-crank without play "
        "is exact unless a truncated series is asked for.",
    ),
)
