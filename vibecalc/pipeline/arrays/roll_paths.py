"""Which results of a roll machine array calls give; apart, since what solves it loads slowly."""

from vibecalc.roll.results import FORCES, ROLL, VARIABLES

PATHS = (
    *(f"{ROLL}/{name}" for name in ("speed", "mean_slip", "shell_drift", "largest_multiplier")),
    *(
        path
        for name in (*VARIABLES, *FORCES)
        for path in (f"{ROLL}/{name}", f"{ROLL}/level/{name}", f"{ROLL}/phase_lag/{name}")
    ),
)
