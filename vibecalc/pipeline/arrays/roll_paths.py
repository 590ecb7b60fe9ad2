"""Which results of a roll machine array calls give; apart, since what solves it loads slowly."""

from vibecalc.pipeline.entries.roll import FORCES, ROOT, VARIABLES

PATHS = (
    *(f"{ROOT}/{name}" for name in ("speed", "mean_slip", "shell_drift", "largest_multiplier")),
    *(
        path
        for name in (*VARIABLES, *FORCES)
        for path in (f"{ROOT}/{name}", f"{ROOT}/level/{name}", f"{ROOT}/phase_lag/{name}")
    ),
)
