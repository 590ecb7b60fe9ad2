"""Results of the weights sought for the least force and couple."""

from vibecalc.core.results.record import CHECK, PEAK, SEARCHED, TURN, Headline, entry

ROOT = "balance"
AXES = {
    "weight": ("", "weight on the crankshaft or on a balance shaft"),
    "balance_radius": ("", "weight of which the radius is given"),
    "balance_bound": ("", "weight of which the largest unbalance is given"),
    "balanced_order": ("", "order at which weights turn"),
}
_WEIGHT = f"{ROOT}/weight"

ENTRIES = (
    entry(
        f"{_WEIGHT}/unbalance",
        "weight",
        "kg*m",
        "mass times radius of a weight",
        headline=Headline(
            "balance weight", "g*mm", pick="each",
            words="vibecalc.balance.report:angle_of",
        ),
    ),
    entry(
        f"{_WEIGHT}/phase",
        "weight",
        "rad",
        "angle by which it leads the stroke at crank angle zero",
        circle=TURN,
    ),
    entry(
        f"{_WEIGHT}/position",
        "weight direction",
        "m",
        "of a weight, from the train's origin",
        exempt=SEARCHED,
    ),
    entry(f"{_WEIGHT}/speed_ratio", "weight", "", "of its shaft over the crank speed"),
    entry(f"{_WEIGHT}/mass", "balance_radius", "kg", "of a weight at its radius"),
    entry(f"{_WEIGHT}/use", "balance_bound", "", "unbalance over the largest of the weight"),
    entry(f"{ROOT}/force", "order direction", "N", "force that the weights leave", PEAK),
    entry(f"{ROOT}/couple", "order direction", "N*m", "couple that the weights leave", PEAK),
    *(
        entry(f"{ROOT}/{when}/{name}", "order", unit, f"{what}, {words}", PEAK)
        for when, words in (("before", "without the weights"), ("after", "with the weights"))
        for name, unit, what in (
            ("force", "N", "largest force over a turn"),
            ("couple", "N*m", "largest couple across the crankshaft over a turn"),
            ("roll_couple", "N*m", "couple about the crankshaft"),
            ("residual", "N", "weighted residual of the order"),
        )
    ),
    *(
        entry(
            f"{ROOT}/{when}/{name}",
            "",
            unit,
            f"{what}, {words}",
            kind,
            headline=Headline(f"{head} {words}{', peak' if kind == PEAK else ''}", unit),
        )
        for when, words in (("before", "without the weights"), ("after", "with the weights"))
        for name, unit, what, head, kind in (
            ("all_orders", "N", "weighted residual of all orders", "weighted residual", None),
            ("force_peak", "N", "largest force over a turn, all orders", "force", PEAK),
            ("couple_peak", "N*m", "largest couple over a turn, all orders", "couple", PEAK),
        )
    ),
    entry(
        f"{ROOT}/residual_before",
        "",
        "N",
        "weighted residual of the orders that count, without the weights",
        PEAK,
    ),
    entry(
        f"{ROOT}/residual",
        "",
        "N",
        "least weighted residual of the orders that count",
        PEAK,
    ),
    entry(
        f"{ROOT}/gap",
        "",
        "N",
        "what no other weights within their bounds could leave less by",
        exempt=CHECK,
    ),
    entry(
        f"{ROOT}/free_directions",
        "balanced_order",
        "",
        "directions in which weights change and the residual does not",
    ),
)  # fmt: skip
