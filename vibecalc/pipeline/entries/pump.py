"""Results of the cylinders of a pump: valves, volumes, work, torque."""

from vibecalc.pipeline.entries.entry import PEAK, entry

ROOT = "excitation/pump"

ENTRIES = (
    entry(
        f"{ROOT}/suction_opens", "", "rad",
        "crank angle from top dead centre at which the suction valve opens",
    ),
    entry(
        f"{ROOT}/discharge_opens", "", "rad",
        "crank angle from bottom dead centre at which the discharge valve opens",
    ),
    entry(f"{ROOT}/swept_volume", "", "m^3", "of one cylinder"),
    entry(
        f"{ROOT}/volumetric_efficiency", "", "",
        "volume drawn, at the suction pressure, over the swept volume",
    ),
    entry(f"{ROOT}/flow", "", "m^3/s", "mean flow of all cylinders, at the suction pressure"),
    entry(f"{ROOT}/work", "", "J", "work of one cylinder on its liquid in a turn"),
    entry(f"{ROOT}/power", "", "W", "of all cylinders on the liquid"),
    entry(
        f"{ROOT}/mean_torque", "", "N*m",
        "mean torque of the liquid on the crankshaft, all cylinders, with its sign",
    ),
    entry(
        f"{ROOT}/torque", "order", "N*m",
        "torque of the liquid on the crankshaft, all cylinders, complex", PEAK,
    ),
    entry(f"{ROOT}/pressure", "crank_angle", "Pa", "absolute, on one plunger over its own turn"),
)  # fmt: skip
