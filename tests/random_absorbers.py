"""Seeded random primaries with one or more absorbers, as case tables, given or tuned."""

import numpy as np
from random_machines import Table, spread

RTOLS = (1e-3, 1e-6, 1e-9, 1e-12)
PAIRS = (
    ("force", "displacement"), ("force", "velocity"), ("force", "acceleration"),
    ("force", "transmitted_force"), ("base", "displacement"), ("unbalance", "displacement"),
)  # fmt: skip
#: mean squares that exist
SQUARES = (("force", "displacement"), ("force", "velocity"), ("base", "transmitted_force"))


def random_absorber(seed: int) -> Table:
    """A whole case for `validate`; one absorber, of every third seed several."""
    random = np.random.default_rng([seed, 11])
    several = seed % 3 == 2
    z1 = 0.0 if random.random() < 0.25 else spread(random, 1e-4, 0.4)
    table: Table = {
        "schema": 1,
        "title": f"random absorber {seed}",
        "machine": {"kind": "absorber", "primary": {"damping_ratio": z1}},
        "accuracy": {"rtol": float(random.choice(RTOLS))},
    }
    if random.random() < 0.4:
        table["machine"]["primary"] |= {
            "inertia": spread(random, 0.01, 100.0), "stiffness": spread(random, 1.0, 1e7),
        }  # fmt: skip
    (_several if several else _one)(random, table, z1, tuned=random.random() < 0.65)
    _response(random, table, several)
    return table


def _one(random: np.random.Generator, table: Table, z1: float, *, tuned: bool) -> None:
    m = spread(random, 0.005, 1.0)
    secondary: Table = {"mass_ratio": m}
    table["machine"]["secondary"] = secondary
    if not tuned:
        secondary["stiffness_ratio"] = 0.0 if random.random() < 0.15 else m * spread(random, 0.2, 5)
        secondary["damping_over_primary_critical"] = (
            0.0 if random.random() < 0.15 else m * spread(random, 0.01, 2)
        )
        return
    tuning = _tuning(random)
    table["tuning"] = tuning
    kinds = ["free", "free", "free", "viscous", "undamped_spring", "lanchester"]
    kind = str(random.choice(kinds))
    if random.random() < 0.2:
        tuning["norm"] = "h2"
        tuning["excitation"], tuning["response"] = SQUARES[int(random.integers(len(SQUARES)))]
        if tuning["excitation"] == "base":
            table["machine"]["primary"]["damping_ratio"] = 0.0
    elif kind == "lanchester" or (kind == "undamped_spring" and z1 == 0.0):
        table["machine"]["primary"]["damping_ratio"] = 0.0
        tuning |= {"kind": "lanchester", "excitation": "force", "response": "displacement"}
    else:
        tuning["kind"] = kind
    if tuning.get("kind", "free") != "free":
        return
    if random.random() < 0.4:
        names = ["den_hartog", "nishihara_asami", "numerical"]
        tuning["compare"] = names[2:] if "norm" in tuning else names
    if random.random() < 0.4:
        tuning["mistuning"] = [0.02, 0.1]
    if random.random() < 0.3 and "norm" not in tuning:
        tuning["sensitivity"] = True
    if random.random() < 0.2 and "norm" not in tuning:
        tuning["chart"] = {
            "primary_damping": [0.0, z1] if z1 else [0.0],
            "mass_ratio": {"from": 0.5 * m, "to": 2.0 * m, "points": 3},
        }


def _tuning(random: np.random.Generator) -> Table:
    excitation, response = PAIRS[int(random.integers(len(PAIRS)))]
    return {"excitation": excitation, "response": response}


def _several(random: np.random.Generator, table: Table, z1: float, *, tuned: bool) -> None:
    count = 2 if tuned else int(random.integers(2, 4))
    rows = []
    for number in range(count):
        m = spread(random, 0.01, 0.2)
        row: Table = {"name": f"a{number}", "mass_ratio": m}
        if number and random.random() < 0.3:
            row["on"] = f"a{int(random.integers(number))}"
        if not tuned:
            row["stiffness_ratio"] = m * spread(random, 0.3, 3.0)
            row["damping_over_primary_critical"] = m * spread(random, 0.01, 1.0)
        rows.append(row)
    table["machine"]["secondaries"] = rows
    if tuned:
        table["tuning"] = {"norm": "h_infinity"}
        if random.random() < 0.5:
            table["tuning"]["mistuning"] = [0.05]


def _response(random: np.random.Generator, table: Table, several: bool) -> None:
    options: Table = {"limits": bool(random.random() < 0.3)}
    if random.random() < 0.3:
        options["vary"] = {"primary_damping": [spread(random, 1e-3, 0.3), 0.05]}
        if not several and random.random() < 0.5:
            options["vary"] = {"mass_ratio": [0.02, 0.3]}
    if "tuning" not in table:
        options["excitation"], options["response"] = PAIRS[int(random.integers(len(PAIRS)))]
    primary = table["machine"]["primary"]
    if "inertia" in primary and random.random() < 0.5:
        own = float(np.sqrt(primary["stiffness"] / primary["inertia"]))
        options["frequencies"] = {"from": 0.0, "to": 2.0 * own, "points": 41}
    else:
        options["frequency_ratios"] = {"from": 0.0, "to": 2.0, "points": 41}
    table["response"] = {"absorber": options}
