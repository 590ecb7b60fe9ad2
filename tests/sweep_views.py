"""Sweeps for the tests of their report: results that are written down as formulas of the keys."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from sample_results import result_of

from vibecalc.core.report.sweep.view import StackedResult, SweepView
from vibecalc.core.results.layout import DONE, FAILED, REFUSED, TIMED_OUT
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.core.results.sweep_file import SweepHead, SweptAxis, SweptKey

STIFFNESS = ("machine.mounts.each.stiffness", "N/m", "N/mm")
DAMPING = ("machine.mounts.each.damping", "N*s/m", "N*s/m")
SPEED = ("machine.speed", "rad/s", "rpm")
MOUNTS = Axis(name="mount", values=np.array(["1", "2"], dtype=object))
MASS, FORCE, OMEGA = 25.0, 2000.0, 500.0
PEAK, SAG, BOTH = "isolation/force/peak", "isolation/sag", "isolation/force/by_mount"
UNITS = {PEAK: "N", SAG: "m", BOTH: "N"}


def key(name: str, unit: str, written: str, names: tuple[str, ...] = ()) -> SweptKey:
    label = name.rsplit(".", 1)[-1]
    return SweptKey(key=name, label=label, unit=unit, written_unit=written, choices=names)


def axis_of(keys: Sequence[SweptKey], values: np.ndarray) -> SweptAxis:
    """An axis with the values (n, keys) of its keys."""
    return SweptAxis(name="axis", keys=tuple(keys), columns=tuple(np.asarray(values, float).T))


def force(stiffness: Any, damping: Any) -> Any:
    """Force through one mount of a mass that a force of OMEGA shakes."""
    elastic = stiffness + 1j * OMEGA * damping
    return np.abs(FORCE * elastic / (elastic - MASS * OMEGA**2))


def results(stiffness: np.ndarray, damping: np.ndarray) -> dict[str, np.ndarray]:
    """By path, (points, own axes)."""
    through = force(stiffness, damping)
    return {
        SAG: MASS * 9.81 / stiffness,
        PEAK: through,
        BOTH: np.stack([0.5 * through, 0.6 * through], axis=1),
    }


def view(
    axes: Sequence[SweptAxis] | np.ndarray,
    keys: Sequence[SweptKey],
    values: Mapping[str, np.ndarray],
    *,
    limits: Sequence[Mapping[str, Any]] = (),
    own: Mapping[str, tuple[Axis, ...]] | None = None,
    failed: Mapping[int, tuple[int, str]] | None = None,
    spread: Mapping[str, np.ndarray] | None = None,
    sampling: str = "grid",
    indices: bool = False,
    units: Mapping[str, str] = UNITS,
    case: Mapping[str, Any] | None = None,
    errors: float = 1e-12,
) -> SweepView:
    """A sweep with these results; `axes` are those of a grid, or the samples (points, keys)."""
    count = len(next(iter(values.values())))
    failed = {point: why for point, why in (failed or {}).items() if point < count}
    status = np.full(count, DONE, dtype=np.int8)
    for point, (what, _) in failed.items():
        status[point] = what
    kept = {
        path: Quantity(
            path=path, values=np.empty(0, array.dtype), unit=units.get(path, ""),
            long_name=path, axes=(own or {}).get(path, ()),
        )
        for path, array in values.items()
    }  # fmt: skip

    def read(path: str) -> StackedResult:
        array = np.where((status == DONE).reshape(-1, *[1] * (values[path].ndim - 1)),
                         values[path], np.nan)  # fmt: skip
        scale = errors * np.max(np.abs(array[np.isfinite(array)]), initial=0.0)
        return StackedResult(array, np.full(count, scale), (spread or {}).get(path))

    sampled = isinstance(axes, np.ndarray)
    parts = [[one] for one in keys] if sampled else [list(axis.keys) for axis in axes]
    whole = {"title": "Machine on mounts", "limit": list(limits), **(case or {})}
    head = SweepHead(
        result=replace(result_of(), name="mounts", case=whole),
        axes=(axis_of(keys, axes),) if isinstance(axes, np.ndarray) else tuple(axes),
        sampling=sampling,
        design={"axes": [[one.key for one in some] for some in parts], "indices": indices},
        stored=tuple(values),
        identity="",
    )
    reasons = {point: words for point, (_, words) in failed.items()}
    return SweepView(head=head, status=status, reasons=reasons, quantities=kept, read=read)


LIMITS = (
    {"quantity": SAG, "max": "30 mm", "source": "room under the machine"},
    {"quantity": PEAK, "max": "12 N", "source": "assignment"},
    {"quantity": BOTH, "max": "400 N", "where": {"mount": "2"}},
)
FAILED_POINTS = {
    3: (REFUSED, "machine.mounts: the body tips over"),
    40: (FAILED, "order 2 meets mode 1 at 31.5 rad/s"),
    41: (FAILED, "order 2 meets mode 1 at 33.1 rad/s"),
    90: (TIMED_OUT, "no result after 10 s"),
}
CASE = {
    "machine": {"mounts": {"each": {"stiffness": 2e4, "damping": 20.0}}, "speed": 300.0},
    "optimisation": {"objective": {"quantity": SAG}},
}


def mounts(stiffnesses: int = 21, dampings: int = 15, **more: Any) -> SweepView:
    """Stiffness (logarithmic) by damping."""
    keys = (key(*STIFFNESS), key(*DAMPING))
    axes = [
        axis_of((keys[0],), np.geomspace(5e3, 5e4, stiffnesses)[:, None]),
        axis_of((keys[1],), np.linspace(0.0, 20.0, dampings)[:, None]),
    ]
    k, c = (a.ravel() for a in np.meshgrid(axes[0].table, axes[1].table, indexing="ij"))
    settings: dict[str, Any] = {"limits": LIMITS, "own": {BOTH: (MOUNTS,)}, "case": CASE}
    return view(axes, keys, results(k, c), **(settings | more))


def along_speed(**more: Any) -> SweepView:
    """One axis, with a resonance that is passed."""
    keys = (key(*SPEED),)
    speed = np.linspace(50.0, 420.0, 75)
    energy = 1e-3 * (speed / 100.0) ** 2 / np.abs(1.0 - (speed / 90.0) ** 2 + 0.05j)
    modes = Axis(name="mode", values=np.array([1, 2]))
    values = {
        "response/kinetic_energy/mean": energy,
        "response/modes/natural_frequency": np.tile([90.0, 140.0], (75, 1)),
    }
    settings: dict[str, Any] = {
        "own": {"response/modes/natural_frequency": (modes,)},
        "units": {"response/kinetic_energy/mean": "J", "response/modes/natural_frequency": "rad/s"},
        "limits": [{"quantity": "response/kinetic_energy/mean", "max": "20 mJ"}],
    }
    return view([axis_of(keys, speed[:, None])], keys, values, **(settings | more))


def sampled(points: int = 64, indices: bool = True, **more: Any) -> SweepView:
    """Samples of stiffness and damping, in the order of Saltelli's design if with indices."""
    keys = (key(*STIFFNESS), key(*DAMPING))
    random = np.random.default_rng(1)
    shares = random.random((points, 4))
    runs = [shares[:, :2], shares[:, 2:]]
    if indices:
        for j in range(2):
            mixed = shares[:, :2].copy()
            mixed[:, j] = shares[:, 2 + j]
            runs.append(mixed)
        drawn = np.stack(runs, axis=1).reshape(-1, 2)
    else:
        drawn = shares[:, :2]
    drawn = np.array([5e3, 0.0]) + drawn * np.array([4.5e4, 20.0])
    settings: dict[str, Any] = {
        "limits": LIMITS, "own": {BOTH: (MOUNTS,)}, "case": CASE, "sampling": "monte_carlo",
        "indices": indices,
    }  # fmt: skip
    return view(drawn, keys, results(drawn[:, 0], drawn[:, 1]), **(settings | more))
