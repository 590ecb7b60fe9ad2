"""The stages of forces and couples: of the crank train, of a motor, of the cylinders of a pump."""

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
from vibecalc.kinds import finds_speed, has_crank_train
from vibecalc.kinematics.stage import needs_excitation, orders_given, orders_of_motion, orders_words

if TYPE_CHECKING:
    from vibecalc.schema import Case


def plan_pump(case: "Case") -> Iterator[Stage]:
    """Planned for every machine of kind "pump": its pressures stand in the case."""
    if case.machine.kind != "pump":
        return
    given = None if case.excitation is None else case.excitation.orders
    yield Stage(
        name="pump",
        adapter="vibecalc.excitation.pump_adapter:run_pump",
        why="[machine.crank_train.pump_cycle] is in the case",
        parts=("crank_train",),
        orders=f"1 to {given}, as the case asks" if given else "the usual ones of a torque",
        cost="one fit of the pressure, one quadrature per order",
        quantities=below("excitation/pump/"),
        is_last=True,
        harmonics=_orders_of_pump,
        work=lambda case, orders: ((1, "closed_forms"),),
        topics=("vibecalc.excitation.accuracy:pump_topics",),
    )


def plan_excitation(case: "Case") -> Iterator[Stage]:
    if not needs_excitation(case):
        return
    options = case.excitation
    users = ("isolation", "response", "balance")
    user = next((name for name in users if getattr(case, name) is not None), users[0])
    other = "/balance/total_" if case.machine.crank_train.has_banks else "/balance/banks/"
    balance = below("excitation/balance/", (other,)) if options and options.balance else ()
    residual = ("excitation/residual",) if options and options.residual else ()
    train = case.machine.crank_train
    rotating = len(train.counterweights) + len(train.balance_shafts)
    yield Stage(
        name="excitation",
        adapter="vibecalc.excitation.adapter:run_excitation",
        why="[excitation] is in the case" if options else f"the {user} needs the forces",
        parts=("crank_train", "rotating_masses") if rotating else ("crank_train",),
        orders=orders_words(case),
        cost=f"cylinders and weights summed per order: {len(train.cylinders)} and {rotating}",
        quantities=(
            *below("excitation/", without=_EXCITATION_EXTRAS),
            *_rod(case),
            *((*below("excitation/turning/"), "excitation/mass/knuckle") * train.has_slave_rods),
            *(below("excitation/counterweight/") if train.counterweights else ()),
            *balance,
            *residual,
        ),
        harmonics=orders_of_motion,
        work=lambda case, orders: ((orders, "order"),),
        topics=("vibecalc.excitation.accuracy:excitation_topics",),
        leading=Leading(
            frozenset(
                f"excitation.residual.{name}"
                for name in ("force_weight", "couple_weight", "reference_length")
            )
        ),
    )


_EXCITATION_EXTRAS = (
    *("/balance/", "/residual", "/rod/", "/motor/", "/counterweight/", "/pump/"),
    *("/turning/", "/mass/knuckle"),
)


def _rod(case: "Case") -> tuple[str, ...]:
    """Results of the rod as a body: of its own moment where the case gives it, else a bound."""
    rod = case.machine.crank_train.rod
    if rod is None or rod.crank_pin_to_mass_centre is None:
        return ()
    if rod.inertia is None:
        return ("excitation/rod/split_inertia", "excitation/rod/couple_bound")
    return below("excitation/rod/", without=("bound",))


def plan_motor(case: "Case") -> Iterator[Stage]:
    if case.machine.motor is None or case.excitation is None or finds_speed(case.machine):
        return
    yield Stage(
        name="motor",
        adapter="vibecalc.excitation.adapter:run_motor",
        why="[machine.motor] and [excitation] are in the case",
        parts=("motor",),
        orders=f"the {len(case.machine.motor.torque.order)} of its torque",
        cost="one pass over the orders",
        quantities=below("excitation/motor/"),
        is_last=case.response is None or case.response.impact is None,
        harmonics=_orders_of_motor,
        topics=("vibecalc.excitation.accuracy:motor_topics",),
    )


#: highest order of a torque where the case says none
USUAL_ORDERS = 24


# ----------------------------------------------------------------------------
# Harmonics and counted work of each stage, read from the case: nothing is solved.
# ----------------------------------------------------------------------------


def _orders_of_pump(case: "Case") -> Harmonics:
    """Orders of the torque of a liquid."""
    given = None if case.excitation is None else case.excitation.orders
    return first_orders(given or USUAL_ORDERS, "[excitation] orders" if given else "the usual ones")


def _orders_of_motor(case: "Case") -> Harmonics:
    motor = case.machine.motor
    assert motor is not None
    orders = [order for order in motor.torque.order if order]  # the mean is no harmonic
    return Harmonics(len(orders), min(orders), max(orders), "those of its torque")


def _entries(case: "Case", path: str, axis: str) -> Entries | None:
    options = case.excitation
    if path.startswith("excitation/balance/"):
        table = None if options is None else options.balance
        because = "orders of [excitation.balance] are those tabulated"
        return Entries(table.orders, because) if table and axis == "order" else None
    if path.startswith("excitation/motor/"):
        return None
    return orders_given(case, axis, 0 if path.startswith("excitation/rod/") else 1)


SUBJECT = Subject(
    stages=(plan_excitation, plan_motor, plan_pump),
    concerns=lambda case: has_crank_train(case.machine),
    entries=_entries,
    units={
        "order": Unit(1.0e-4, "orders summed"),
        "closed_forms": Unit(1.2e-2, "sets of closed forms"),
    },
    checks=(
        "vibecalc.excitation.checks:pump_problems",
        "vibecalc.excitation.checks:engine_problems",
    ),
    sections=(
        "vibecalc.excitation.report:rod",
        "vibecalc.excitation.report:excitation",
        "vibecalc.excitation.report:motor",
        "vibecalc.excitation.report:pump",
    ),
    pictures={
        "shaking": "vibecalc.excitation.pictures:draw_shaking",
        "turning_force": "vibecalc.excitation.pictures:TURNING_FORCE",
        "motor_force": "vibecalc.excitation.pictures:MOTOR_FORCE",
    },
    assumes=(
        "Forces and couples are those at constant crank speed unless the inertia of the "
        "rotor is given; the driven machine takes a constant torque.",
    ),
)
