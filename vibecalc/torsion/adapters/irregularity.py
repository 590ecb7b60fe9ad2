"""How evenly named stations of a shaft line turn, at one speed and over a range."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.adapters.motion import Motion, Reading
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import Setup, line_speeds
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.results import IRREGULARITY

# ----------------------------------------------------------------------------
# Adapter: degree of unevenness, (highest - lowest) / mean of the angular speed over the cycle.
#
# A station with the speed ratio r turns at r W and vibrates with r phi_q; of its angular speed
# i q W r phi_q the mean r W cancels: the half range of the sum of i q phi_q, referred, is half the
# degree of unevenness. What the line does as a rigid body is in phi_q.
# ----------------------------------------------------------------------------


def degrees(setup: Setup) -> dict[str, Reading]:
    """Degrees of unevenness of the stations that the case names, and electrical angles."""
    asked = setup.torsion.irregularity
    names = tuple(one.on for one in asked)
    place = np.array([setup.shaft.station_names.index(one) for one in names])
    pairs = np.array([one.pole_pairs or 0 for one in asked])
    some = np.flatnonzero(pairs)
    found = {"degree": Reading("unevenness", place, "half_range", "station", names)}
    if len(some):

        def scale(speed: FloatArray) -> FloatArray:
            return np.broadcast_to(pairs[some].astype(float), (len(speed), len(some)))

        own = tuple(names[k] for k in some)
        found["electrical_angle"] = Reading(
            "angle", place[some], "half_range", "station", own, scale
        )
    return found


def run_torsion_irregularity(scene: Scene) -> None:
    """Emit degrees of unevenness and electrical angles of the stations of the case."""
    setup = setup_of(scene)
    known, motion = degrees(setup), Motion(setup, np.array([setup.speed]), bounded=True)

    def put(stem: str, name: str, value: Bounded, speed: FloatArray | None = None) -> None:
        axes = {"station": known[name].names, **({} if speed is None else {"speed": speed})}
        scene.emit(f"{IRREGULARITY}{stem}/{name}", value, axes=axes)

    for name, reading in known.items():
        put("", name, reading.of(motion)[0])
    if setup.torsion.speeds is not None:
        speed = line_speeds(setup.torsion.speeds)
        search = Search([setup], speed, [known], ["degree"])
        for name in known:
            put("/speeds", name, search.bounded_curves(name).T, speed)
        top = search.top("degree").of(0)
        put("/largest", "degree", top.value)
        scene.emit(
            f"{IRREGULARITY}/largest/speed", top.speed, axes={"station": known["degree"].names}
        )
    scene.cite(
        "twice the half range of the sum of order times angle",
        "cyclic irregularity",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958",
    )
