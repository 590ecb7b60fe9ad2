"""Results of vibration at points: by order, peak and r.m.s., over the run-up, and its severity."""

from collections.abc import Iterator

from vibecalc.core.results.record import ORDERS, PEAK, RESONANCE, RMS, Entry, Headline, entry

ROOT, RUN_UP, BOUNDARY = "points", "points/run_up", "points/zone_boundary"
#: the unit of each, in SI and as people read it
UNITS = {
    "displacement": ("m", "um"),
    "velocity": ("m/s", "mm/s"),
    "acceleration": ("m/s^2", "m/s^2"),
}
#: what is read of each over the cycle, in words and as a kind of amplitude
KINDS = {"peak": ("peak", PEAK), "rms": ("r.m.s.", RMS)}
_OVER_CYCLE = {
    "peak": "largest {} over the cycle, all orders",
    "rms": "{} of the orders in the band",
}


def _at_speed() -> Iterator[Entry]:
    """At the operating speed."""
    for name, (unit, _) in UNITS.items():
        words = f"{name} at a point, by order"
        yield entry(f"{ROOT}/{name}", "sensor order", unit, words, PEAK)
    for kind, (said, amplitude) in KINDS.items():
        for name, (unit, read) in UNITS.items():
            words, called = _OVER_CYCLE[kind].format(name), f"{name} at a point, {said}"
            head = Headline(called, read, words="vibecalc.points.report:zone_words")
            yield entry(
                f"{ROOT}/{name}_{kind}", "sensor", unit, words, amplitude,
                name=called, headline=head if (name, kind) == ("velocity", "rms") else None,
            )  # fmt: skip
    words = "velocity of the grade met by displacement, velocity and acceleration (10, 250 Hz)"
    yield entry(f"{ROOT}/severity", "sensor", "m/s", words, RMS, name="severity")
    words = "zone by the worst of displacement, velocity and acceleration, 0: best"
    yield entry(f"{ROOT}/zone", "sensor", "", words)
    for name, (unit, _) in UNITS.items():
        yield entry(f"{BOUNDARY}/{name}", "zone_limit", unit, f"{name} between two zones", RMS)


def _over_speed() -> Iterator[Entry]:
    """In the run-up."""
    for name, (unit, read) in UNITS.items():
        for kind, (words, amplitude) in KINDS.items():
            path, said = f"{RUN_UP}/{name}_{kind}", f"{name} in the run-up, {words}"
            each = f"{'largest ' * (kind == 'peak')}{name} at each speed"
            head = Headline("velocity in the run-up, r.m.s.", read, at=f"{path}_largest_speed")
            yield entry(path, "sensor speed", unit, each, amplitude, name=said)
            yield entry(
                f"{path}_largest", "sensor", unit, f"maximum in the run-up of {name}, {words}",
                amplitude, name=f"{said}, largest",
                headline=head if (name, kind) == ("velocity", "rms") else None,
            )  # fmt: skip
            yield entry(f"{path}_largest_speed", "sensor", "rad/s", "crank speed at the maximum")
    path, largest = f"{RUN_UP}/severity", "severity in the run-up, largest"
    yield entry(path, "sensor speed", "m/s", "severity at each speed", RMS)
    words = "maximum severity in the run-up"
    yield entry(f"{path}_largest", "sensor", "m/s", words, RMS, name=largest)
    yield entry(f"{path}_largest_speed", "sensor", "rad/s", "crank speed at the maximum")


AXES = {
    "sensor": ("", "sensor"),
    "zone_limit": ("", "zone boundary, from the best zone"),
}
ENTRIES = (*_at_speed(), *_over_speed())
HELPS = {f"{ROOT}/": (ORDERS, RESONANCE)}
