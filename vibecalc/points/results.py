"""Results of vibration at points: by order, peak and r.m.s., over the run-up, and its severity."""

from vibecalc.core.results.record import ORDERS, PEAK, RESONANCE, RMS, Headline, entry

ROOT, RUN_UP = "points", "points/run_up"
SEVERITY, ZONE, BOUNDARY = (f"{ROOT}/{name}" for name in ("severity", "zone", "zone_boundary"))
#: the unit of each, in SI and as people read it
UNITS = {
    "displacement": ("m", "um"),
    "velocity": ("m/s", "mm/s"),
    "acceleration": ("m/s^2", "m/s^2"),
}
AXES = {
    "sensor": ("", "sensor"),
    "zone_limit": ("", "between zones, from the best on"),
}
ENTRIES = (
    *(
        entry(f"{ROOT}/{name}", "sensor order", si, f"{name} at a point, by order", PEAK)
        for name, (si, _) in UNITS.items()
    ),
    *(
        entry(
            f"{ROOT}/{name}_peak",
            "sensor",
            si,
            f"largest {name} over the cycle, all orders",
            PEAK,
            name=f"{name} at a point, peak",
        )
        for name, (si, _) in UNITS.items()
    ),
    *(
        entry(
            f"{ROOT}/{name}_rms",
            "sensor",
            si,
            f"{name} of the orders in the band",
            RMS,
            name=f"{name} at a point, r.m.s.",
            headline=Headline(
                "velocity at a point, r.m.s.", read, words="vibecalc.points.report:zone_words"
            )
            if name == "velocity"
            else None,
        )
        for name, (si, read) in UNITS.items()
    ),
    *(
        entry(
            f"{RUN_UP}/{name}_{kind}",
            "sensor speed",
            si,
            f"{'largest ' * (kind == 'peak')}{name} at each speed",
            amplitude,
            name=f"{name} in the run-up, {words}",
        )
        for name, (si, _) in UNITS.items()
        for kind, amplitude, words in (("peak", PEAK, "peak"), ("rms", RMS, "r.m.s."))
    ),
    *(
        one
        for name, (si, read) in UNITS.items()
        for kind, amplitude, words in (("peak", PEAK, "peak"), ("rms", RMS, "r.m.s."))
        for one in (
            entry(
                f"{RUN_UP}/{name}_{kind}_largest",
                "sensor",
                si,
                f"largest of the run-up of {name}, {words}",
                amplitude,
                name=f"{name} in the run-up, {words}, largest",
                headline=Headline(
                    "velocity in the run-up, r.m.s.",
                    read,
                    at=f"{RUN_UP}/{name}_{kind}_largest_speed",
                )
                if (name, kind) == ("velocity", "rms")
                else None,
            ),
            entry(
                f"{RUN_UP}/{name}_{kind}_largest_speed", "sensor", "rad/s",
                "crank speed of the largest",
            ),
        )
    ),
    entry(
        SEVERITY,
        "sensor",
        "m/s",
        "velocity whose grade displacement, velocity and acceleration all keep (10 and 250 Hz)",
        RMS,
        name="severity",
    ),
    entry(f"{RUN_UP}/severity", "sensor speed", "m/s", "severity at each speed", RMS),
    entry(
        f"{RUN_UP}/severity_largest",
        "sensor",
        "m/s",
        "largest severity of the run-up",
        RMS,
        name="severity in the run-up, largest",
    ),
    entry(
        f"{RUN_UP}/severity_largest_speed", "sensor", "rad/s", "crank speed of the largest"
    ),
    entry(
        ZONE, "sensor", "", "boundaries of zones exceeded by one of the three: 0 in the best zone"
    ),
    *(
        entry(f"{BOUNDARY}/{name}", "zone_limit", si, f"{name} between two zones", RMS)
        for name, (si, _) in UNITS.items()
    ),
)  # fmt: skip
HELPS = {f"{ROOT}/": (ORDERS, RESONANCE)}
