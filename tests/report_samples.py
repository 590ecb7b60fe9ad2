"""Results for the tests of the report: the three-cylinder generator, written down by hand."""

from typing import Any

import numpy as np

from vibecalc.core.results.record import Axis, Method, Quantity, Record, Result

MASS, LEVER, STIFFNESS, DAMPING = 100.0, 0.4, 1e4, 50.0
INERTIA = MASS / 12.0 * (0.35**2 + 0.8**2)
SPEED = 4900.0 * 2.0 * np.pi / 60.0
NATURAL = float(np.sqrt(4.0 * LEVER**2 * STIFFNESS / INERTIA))
RATIO = 4.0 * LEVER**2 * DAMPING / (2.0 * NATURAL * INERTIA)
ORDERS = Axis(name="order", values=np.array([1, 2]), long_name="multiple of crank speed")
DIRECTIONS = Axis(name="direction", values=np.array(["x", "y", "z"], dtype=object))
CYLINDERS = Axis(name="cylinder", values=np.array(["1", "2", "3"], dtype=object))
MOUNTS = Axis(name="mount", values=np.array(["1", "2", "3", "4"], dtype=object))


def transmissibility(frequency: Any) -> Any:
    """Of the pitch model, at an excitation frequency in rad/s."""
    r = np.asarray(frequency) / NATURAL
    return (1.0 + 2j * RATIO * r) / (1.0 - r**2 + 2j * RATIO * r)


def couple(speed: Any) -> np.ndarray:
    """Couple of orders 1 and 2 about y, in N*m, complex, shape (..., 2)."""
    first = 0.3 * np.sqrt(3.0) * 0.4 * 0.06 * np.asarray(speed) ** 2
    return np.stack([-1j * first, 1j * 0.3 * first], axis=-1)


def peak(harmonics: np.ndarray) -> Any:
    """Largest magnitude over a sampled cycle of orders 1 and 2."""
    angle = np.linspace(0.0, 2.0 * np.pi, 7201)
    waves = np.exp(1j * np.outer([1, 2], angle))
    return np.max(np.abs((harmonics @ waves).real), axis=-1)


def quantity(
    path: str, values: Any, unit: str, *axes: Axis, error: float | None = None, **more: Any
) -> Quantity:
    """A quantity with an error estimate of 1e-14 of its largest entry, unless given."""
    array = np.asarray(values)
    if error is None:
        finite = array[np.isfinite(array)] if array.dtype.kind in "fc" else np.array([])
        error = 1e-14 * float(np.max(np.abs(finite), initial=0.0))
    return Quantity(
        path=path,
        values=array,
        unit=unit,
        long_name=path.rsplit("/", 1)[-1].replace("_", " "),
        axes=axes,
        error_estimate=error,
        **more,
    )


def generator_case(**more: Any) -> dict[str, Any]:
    """The resolved case of the generator, with whatever tables are added."""
    phases = (2.0 * np.pi / 3.0, 0.0, 4.0 * np.pi / 3.0)
    cylinders = [
        {"name": name, "position": position, "crank_phase": phase}
        for name, position, phase in zip("123", (-0.3, 0.0, 0.3), phases, strict=True)
    ]
    return {
        "schema": 1,
        "title": "Three-cylinder generator set on four mounts",
        "source": "Gibson 2008",
        "machine": {
            "kind": "generator",
            "speed": SPEED,
            "crank_train": {"crank_radius": 0.06, "rod_length": 0.2, "cylinders": cylinders},
        },
        "isolation": {"model": "pitch", "run_up": {"from": 0.0, "to": SPEED}},
        "accuracy": {"rtol": 1e-9},
        **more,
    }


def result_of(record: Record, case: dict[str, Any], **more: Any) -> Result:
    """A finished run around a record."""
    plan = ({"stage": "excitation", "why": "[isolation] needs it", "orders": "1 to 2"},)
    fixed: dict[str, Any] = {
        "name": "generator",
        "case": case,
        "case_toml": "schema = 1\n",
        "case_toml_resolved": "schema = 1\n",
        "case_sha256": "ab" * 32,
        "record": record,
        "version": "0.1.0",
        "plan": plan,
        "provenance": {"command": "vibecalc run cases/generator.toml", "host": "here"},
        "timings": {"excitation": 0.0012, "isolation": 0.0101},
    }
    return Result(**{**fixed, **more})


def generator(**tables: Any) -> Result:
    """The generator as the source publishes it, with references and limits of its own."""
    record = Record()
    for item in (*_train(), *_pitch(), *_mounts()):
        record.add(item)
    record.methods.append(
        Method(name="phasor sum", purpose="steady response", citation="Den Hartog 1956, sec. 2.12")
    )
    return result_of(record, generator_case(**{**judged_tables(), **tables}))


def judged_tables() -> dict[str, Any]:
    """Limits and references of the source."""
    lever, support = "isolation/lever_force/", "isolation/support_force/"
    slip = "the source takes sqrt(2) times the speed for the second order and adds magnitudes"
    return {
        "limit": [
            {"quantity": support + "steady_peak", "max": "100 N", "source": "sec. 1"},
            {"quantity": support + "run_up_peak", "max": "0.4 kN", "source": "sec. 1"},
        ],
        "reference": [
            _reference(lever + "rigid_harmonics", "8209 N", "sec. 2.2", where={"order": 1}),
            _reference(lever + "rigid_harmonics", "2463 N", "sec. 2.2", where={"order": 2}),
            _reference(lever + "rigid_peak", "9329 N", "Graph 1"),
            _reference("isolation/pitch/natural_frequency", "31.74 rad/s", "sec. 2.3"),
            _reference("isolation/pitch/damping_ratio", 0.079, "sec. 2.3"),
            _reference(lever + "steady_peak", "93 N", "Graph 2", known_difference=slip),
            _reference(lever + "steady_peak", "98 N", "bench", kind="measured"),
        ],
    }


def _reference(quantity: str, value: Any, source: str, **more: Any) -> dict[str, Any]:
    return {"quantity": quantity, "value": value, "source": source, **more}


def _train() -> list[Quantity]:
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    turn = Axis(name="crank_angle", values=angle, unit="rad")
    root = np.sqrt(0.2**2 - (0.06 * np.sin(angle)) ** 2)
    slope = -0.06 * np.sin(angle) * (1.0 + 0.06 * np.cos(angle) / root)
    forces = np.zeros((2, 3), complex)
    couples = np.zeros((2, 3), complex)
    couples[:, 1] = couple(SPEED)
    phase = np.array([2.0 * np.pi / 3.0, 0.0, 4.0 * np.pi / 3.0])
    z = np.array([-0.3, 0.0, 0.3])
    sine = np.sin(np.outer([1, 2], phase))
    cosine = np.cos(np.outer([1, 2], phase))
    table = {
        "sine": sine, "cosine": cosine, "position_sine": z * sine, "position_cosine": z * cosine
    }  # fmt: skip
    found = [
        quantity("kinematics/position", 0.06 * np.cos(angle) + root, "m", turn),
        quantity("kinematics/velocity", SPEED * slope, "m/s", turn),
        quantity("kinematics/acceleration", np.gradient(SPEED**2 * slope, angle), "m/s^2", turn),
        quantity("kinematics/position_harmonics", [0.06 + 0j, 0.0045 + 0j], "m", ORDERS),
        quantity("kinematics/dropped_acceleration", 12.5, "m/s^2"),
        quantity("excitation/force", forces, "N", ORDERS, DIRECTIONS, error=1e-11),
        quantity("excitation/couple", couples, "N*m", ORDERS, DIRECTIONS, amplitude="0-pk"),
        quantity("excitation/couple_peak", [0.0, LEVER * 9329.33, 0.0], "N*m", DIRECTIONS),
    ]
    for name, values in table.items():
        path = f"excitation/balance/{name}"
        found.append(quantity(path, values, "", ORDERS, CYLINDERS, error=3e-16))
        total = f"excitation/balance/total_{name}"
        found.append(quantity(total, values.sum(axis=1), "", ORDERS, error=1e-15))
    return found


def _pitch() -> list[Quantity]:
    base = "isolation/pitch/"
    lever = "isolation/lever_force/"
    rigid = couple(SPEED) / LEVER
    through = transmissibility(SPEED * np.array([1, 2]))
    ratio = Axis(name="frequency_ratio", values=np.geomspace(0.1, 50.0, 400))
    return [
        quantity(base + "inertia", INERTIA, "kg*m^2"),
        quantity(base + "stiffness", 4.0 * LEVER**2 * STIFFNESS, "N*m/rad"),
        quantity(base + "damping", 4.0 * LEVER**2 * DAMPING, "N*m*s/rad"),
        quantity(base + "natural_frequency", NATURAL, "rad/s"),
        quantity(base + "damping_ratio", RATIO, ""),
        quantity(base + "transmissibility", through, "", ORDERS),
        quantity(
            base + "transmissibility_curve", transmissibility(ratio.values * NATURAL), "", ratio
        ),
        quantity(lever + "rigid_harmonics", rigid, "N", ORDERS, amplitude="0-pk"),
        quantity(lever + "rigid_peak", peak(rigid), "N"),
        quantity(lever + "steady_harmonics", rigid * through, "N", ORDERS, amplitude="0-pk"),
        quantity(lever + "steady_peak", peak(rigid * through), "N"),
    ]


def _mounts() -> list[Quantity]:
    speed = np.unique(np.concatenate([np.linspace(0.0, SPEED, 400), np.linspace(14.0, 36.0, 200)]))
    axis = Axis(name="speed", values=speed, unit="rad/s")
    through = transmissibility(np.multiply.outer(speed, [1.0, 2.0]))
    envelope = peak(couple(speed) / LEVER * through)
    top = int(np.argmax(envelope))
    force, move = "isolation/support_force/", "isolation/support_displacement/"
    steady = peak(couple(SPEED) / LEVER * transmissibility(SPEED * np.array([1, 2]))) / 4.0
    four = np.ones(4)
    return [
        quantity("isolation/lever_force/run_up", envelope, "N", axis),
        quantity("isolation/lever_force/run_up_peak", envelope[top], "N"),
        quantity("isolation/lever_force/run_up_peak_speed", speed[top], "rad/s"),
        quantity(force + "static", 245.16625 * four, "N", MOUNTS),
        quantity(force + "steady_peak", steady * four, "N", MOUNTS),
        quantity(force + "run_up", np.outer(four, envelope / 4.0), "N", MOUNTS, axis),
        quantity(force + "run_up_peak", envelope[top] / 4.0 * four, "N", MOUNTS),
        quantity(force + "run_up_peak_speed", speed[top] * four, "rad/s", MOUNTS),
        quantity(move + "sag", 0.024516625 * four, "m", MOUNTS),
        quantity(move + "excursion", 0.0260 * four, "m", MOUNTS),
    ]


def rigid_body() -> Result:
    """A body with six modes and one mount, without references or limits."""
    modes = Axis(name="mode", values=np.arange(1, 7))
    names = np.array(["x", "y", "z", "rx", "ry", "rz"], dtype=object)
    coordinates = Axis(name="coordinate", values=names)
    fraction = np.eye(6)
    fraction[:2, :2] = [[0.8, 0.2], [0.2, 0.8]]
    fraction[4:, 4:] = [[0.97, 0.03], [0.03, 0.97]]
    record = Record()
    natural = [12.0, 18.0, 20.0, 31.7, 44.0, 51.0]
    record.add(quantity("isolation/modes/natural_frequency", natural, "rad/s", modes))
    record.add(quantity("isolation/modes/damping_ratio", 0.01 * np.arange(1, 7), "", modes))
    record.add(quantity("isolation/modes/energy_fraction", fraction, "", modes, coordinates))
    record.warnings.append("mode 3 is at order 2, its modal force is zero")
    return result_of(record, generator_case(title="A rigid body"), name="body")


def optimised() -> Result:
    """The generator after a search over mount stiffness and damping, limits held at both ends."""
    found = generator()
    record = found.record
    key = "machine.mounts.each."
    force, move = "isolation/support_force/", "isolation/support_displacement/excursion"
    for path, values, unit in (
        (f"optimisation/variable/{key}stiffness", 14321.0, "N/m"),
        (f"optimisation/variable/{key}damping", 205.0, "N*s/m"),
    ):
        record.add(quantity(path, values, unit))
    for path, value, unit in (
        (f"optimisation/start/{force}steady_peak", 31.0, "N"),
        (f"optimisation/start/{force}run_up_peak", 512.0, "N"),
        (f"optimisation/start/{move}", 0.031, "m"),
    ):
        record.add(quantity(path, value * np.ones(4), unit, MOUNTS))
    record.add(quantity("optimisation/start/isolation/pitch/natural_frequency", 28.1, "rad/s"))
    bounds = np.array([force + "steady_peak max 100 N", "run_up_peak max 0.4 kN"], dtype=object)
    limits = Axis(name="limit", values=bounds)
    search = Axis(name="search", values=np.array([1, 2, 3]))
    record.add(quantity("optimisation/margin", [1e-15, 0.44], "", limits, error=1e-12))
    record.add(quantity("optimisation/multiplier", [0.0125, 0.0], "m", limits))
    record.add(quantity("optimisation/history/objective", [0.026, np.inf, 0.03], "m", search))
    record.add(quantity("optimisation/history/feasible", [1, 0, 1], "", search))
    record.add(quantity("optimisation/history/evaluations", [40, 1, 60], "", search))
    record.add(quantity(f"optimisation/active_bound/{key}damping", 1, ""))
    record.add(quantity("optimisation/evaluations", 214, ""))
    asked = {
        "variables": [
            {"key": key + "stiffness", "lower": "1000 N/m", "upper": "50 kN/m"},
            {"key": key + "damping", "lower": 0.0, "upper": "1000 N*s/m"},
        ],
        "objective": {"quantity": move, "sense": "min"},
    }
    mounts = {"each": {"stiffness": 1e4, "damping": 50.0}}
    machine = {**generator_case()["machine"], "mounts": mounts}
    case = generator_case(machine=machine, optimisation=asked, limit=judged_tables()["limit"])
    return result_of(record, case, name="mount_design")
