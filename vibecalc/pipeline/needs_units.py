"""What a piece of work costs: seconds of one thread of a common machine, counted once by running.

The figures come from runs of the shipped cases on a 2.1 GHz server core with BLAS on one thread;
on another machine all of them change together. They are meant to be right within a factor of 3,
which `benchmarks/needs.py` measures.
"""

from typing import NamedTuple


class Unit(NamedTuple):
    """Seconds of one piece of work, its name when there are many, the heavy library it takes."""

    seconds: float
    words: str
    library: str = ""


UNITS: dict[str, Unit] = {
    "stage": Unit(1.5e-3, "stages set up"),
    "motion": Unit(1.0e-3, "passes over the motion of the pistons"),
    "order": Unit(1.0e-4, "orders summed"),
    "body_solve": Unit(2.5e-5, "solves of 6 x 6"),
    "pitch_solve": Unit(1.0e-5, "solves of the pitch model"),
    "modes": Unit(3.0e-3, "sets of modes"),
    "ways": Unit(3.0e-3, "ways of running, each a range over the angle of the weights"),
    "way_order": Unit(2.5e-5, "orders combined"),
    "turn_of_change": Unit(9.0e-3, "turns during the change"),
    "contact_step": Unit(1.0e-3, "batched steps from contact to contact"),
    "line": Unit(4.0e-2, "shaft lines set up with their modes"),
    "line_order": Unit(6.0e-4, "orders of a shaft line summed"),
    "line_solve": Unit(4.8e-7, "solves times freedoms"),
    "limit": Unit(1.0e-1, "limits followed over the range"),
    "time_step": Unit(6.0e-4, "steps in time", "scipy.sparse"),
    "variable_solve": Unit(1.5e-2, "solves of all orders at once", "scipy.linalg"),
    "damper_map": Unit(1.0, "maps of dampers with descents"),
    "damper_solve": Unit(1.0e-4, "solves times freedoms of the map"),
    "closed_forms": Unit(1.2e-2, "sets of closed forms"),
    "periodic": Unit(5.0e-2, "periodic problems"),
    "periodic_motor": Unit(
        2.5e-1, "periodic problems with a motor's currents", "scipy.interpolate"
    ),
    "march": Unit(1.0e-1, "marches until the turns repeat"),
    "turn_of_start": Unit(8.0e-2, "turns followed"),
    "start_angle": Unit(1.0e-1, "starts from other angles"),
    "loop": Unit(1.0e-3, "loops closed"),
    "tuning_loops": Unit(2.0e-1, "searches over loops", "scipy.optimize"),
    "least_squares": Unit(1.0e-2, "harmonics by least squares"),
    "level_motions": Unit(1.5e-2, "harmonics by all motions that levels allow"),
    "peak_search": Unit(1.0e-1, "searches for the lowest peak", "scipy.optimize"),
    "chart_point": Unit(3.0e-4, "points of the chart"),
    "several": Unit(3.0e-1, "searches over several absorbers", "scipy.optimize"),
    "curve_point": Unit(1.5e-6, "points of the curves"),
    "peaks": Unit(2.5e-2, "sets of peaks, poles and limits"),
    "parts": Unit(1.0e-1, "sets of stock parts held against the tuning"),
    "swing": Unit(4.5e-2, "swings of a pendulum"),
}

#: library -> (seconds of its import, MB that it holds); shared parts are loaded once
LIBRARIES: dict[str, tuple[float, float]] = {
    "scipy.integrate": (0.37, 50.0),
    "scipy.interpolate": (0.32, 50.0),
    "scipy.optimize": (0.29, 47.0),
    "scipy.sparse": (0.20, 31.0),
    "scipy.special": (0.17, 23.0),
    "scipy.linalg": (0.16, 26.0),
    "matplotlib": (0.46, 40.0),
}
#: seconds of a stage before it computes: its imports, its arrays
SETTING_UP = 1.0e-2
#: seconds and MB of a command before its first stage and after its last: interpreter, arrays,
#: the case with its checks, the result file, the report
COMMAND = (0.45, 65.0)
#: what a further run in a search costs: a share of the work of the stages that bring what is wanted
#: (parts that others need are left out, stages that nothing has changed are kept), and seconds
FURTHER_RUN = (0.33, 3.0e-3)
