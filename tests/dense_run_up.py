"""Results over a range of speeds, and energies, from the dense model."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from dense_machine import Moved, OnMounts, longest, peak
from dense_results import QUANTITIES, Dense, Expected, severity
from dense_train import Train
from scipy.optimize import minimize_scalar


def _some(count: int, values: Any) -> np.ndarray:
    """Places of a curve: its highest, its ends and two between."""
    return np.unique([0, count // 3, int(np.argmax(values)), (2 * count) // 3, count - 1])


# ----------------------------------------------------------------------------
# Motion and energies of the body on rigid ground.
# ----------------------------------------------------------------------------


def _on_ground(dense: Dense, train: Train, speed: float) -> Moved:
    return dense.rigid.moved(train.order * speed, train.loads(speed))


def response_results(dense: Dense) -> Iterator[Expected]:
    on, order = dense.rigid, dense.order
    assert np.array_equal(order, dense.axis("response/translation_harmonics", 0))
    yield from dense._modes("response")
    weights = {"kinetic": on.matrices()[0], "potential": on.matrices()[1]}
    for train, whole in [(dense.train, False), (dense.more, True)][: 1 + dense.deep]:
        moved, count = _on_ground(dense, train, dense.speed), train.order
        for name, value, parts in (
            ("", moved.body, ("translation", "rotation")),
            ("ground", moved.ground, ("ground_force", "ground_couple")),
        ):
            for part, half in zip(parts, (slice(0, 3), slice(3, 6)), strict=True):
                path = f"response/{part}"
                if not whole:
                    yield Expected(path if name else f"{path}_harmonics", value[:, half])
                top = peak(value[:, half].T, count)
                yield Expected(f"{path}_peak", top, whole=whole)
        for name, weight in weights.items():
            rate = count[:, None] * dense.speed if name == "kinetic" else 1.0
            state = 1j * rate * moved.body if name == "kinetic" else moved.body
            half_of = np.linalg.cholesky(weight)
            signal = state @ half_of
            mean = 0.25 * np.sum(np.abs(signal) ** 2, axis=1)
            root = f"response/{name}_energy"
            if not whole:
                yield Expected(f"{root}/mean_by_order", mean)
                swing = 0.25 * np.abs(np.sum(signal**2, axis=1))
                yield Expected(f"{root}/peak_by_order", mean + swing)
            yield Expected(f"{root}/mean", mean.sum(), whole=whole)
            top = longest(signal.T, count) ** 2 / 2.0
            yield Expected(f"{root}/peak", top, whole=whole)
    speeds = dense.axis("response/run_up/kinetic_energy", 0)
    chosen = _some(len(speeds), dense.record["response/run_up/kinetic_energy"].values)
    for name, weight in weights.items():
        value = []
        for speed in speeds[chosen]:
            body = _on_ground(dense, dense.train, speed).body
            rate = order[:, None] * speed if name == "kinetic" else np.ones((len(order), 1))
            value.append(0.25 * np.sum(((rate * body).conj() @ weight * (rate * body)).real))
        size = float(np.max(dense.record[f"response/run_up/{name}_energy"].values))
        yield Expected(f"response/run_up/{name}_energy", value, size=size, at=chosen)


# ----------------------------------------------------------------------------
# Over a run-up.
# ----------------------------------------------------------------------------


def _of_run_up(dense: Dense) -> OnMounts:
    return dense.mounted if dense.foundation in ("body", "mass") else dense.rigid


def at_speeds(dense: Dense, speeds: np.ndarray) -> Moved:
    """Motion at speeds (s,), each part (s, m, ...)."""
    rate = np.outer(speeds, dense.order)
    load = np.array([dense.train.loads(float(speed)) for speed in speeds])
    found = _of_run_up(dense).moved(rate.ravel(), load.reshape(-1, 6))
    return Moved(*(part.reshape(*rate.shape, *part.shape[1:]) for part in found))


def run_up_results(dense: Dense) -> Iterator[Expected]:
    path = "isolation/support_force/run_up"
    speeds, values = dense.axis(path, 1), np.asarray(dense.record[path].values)
    chosen = _some(len(speeds), values.max(axis=0))
    moved = at_speeds(dense, speeds[chosen])
    yield Expected(path, mount_forces(dense, moved).T, at=(slice(None), chosen))
    top = np.asarray(dense.record[f"{path}_peak"].values)
    where = np.asarray(dense.record[f"{path}_peak_speed"].values)
    yield Expected(f"{path}_peak", np.diag(mount_forces(dense, at_speeds(dense, where))))
    mounts, order = dense.rigid.mounts, dense.order
    if dense.deep:
        maximum = highest(dense, lambda m: np.moveaxis(m.force, 1, -1), int(np.argmax(top)))
        yield Expected(f"{path}_peak", maximum, at=int(np.argmax(top)))
    if mounts.follows_load:
        root = "isolation/mounts/run_up"
        travel = np.asarray(dense.record[f"{root}_travel"].values)
        where = np.asarray(dense.record[f"{root}_travel_speed"].values)
        along = np.einsum("smni,ni->snm", at_speeds(dense, where).deflection, mounts.axis)
        yield Expected(f"{root}_travel", np.diag(peak(along, order)))

        def stretched(m: Moved) -> np.ndarray:
            return np.einsum("smni,ni->snm", m.deflection, mounts.axis)[..., None, :]

        first = int(np.argmax(travel))
        if dense.deep:
            yield Expected(f"{root}_travel", highest(dense, stretched, first), at=first)
        yield from _clearance(dense, travel)
    if "isolation/run_up/maxima/force" in dense.record:
        root = "isolation/run_up/maxima"
        mount = np.asarray(dense.record[f"{root}/mount"].values).astype(int) - 1
        where = np.asarray(dense.record[f"{root}/speed"].values)
        force = mount_forces(dense, at_speeds(dense, where))[range(len(where)), mount]
        yield Expected(f"{root}/force", force)
    if "point" in dense.case:
        yield from _points_in_run_up(dense)


def mount_forces(dense: Dense, moved: Moved) -> np.ndarray:
    """Largest force (speeds, mounts) over the cycle."""
    return longest(np.moveaxis(moved.force, 1, -1), dense.order)


def _clearance(dense: Dense, travel: np.ndarray) -> Iterator[Expected]:
    mounts, given = dense.rigid.mounts, dense.case["isolation"]["run_up"]
    speeds = [given["from"], given["to"]]
    speeds += [one[0] for one in dense.train.gas if speeds[0] < one[0] < speeds[1]]
    left = []
    for speed in speeds:
        moved = dense.rigid.constant(dense.train.mean_couple(speed) * dense.train.axis)[0]
        still = mounts.deflection - np.einsum("ni,ni->n", moved, mounts.axis)
        left.append(mounts.to_stop(still, still))
    path = "isolation/mounts/run_up_clearance"
    value = np.min(left, axis=0) - travel
    yield Expected(path, value, size=float(np.abs(value).max()))


def _points_in_run_up(dense: Dense) -> Iterator[Expected]:
    root, order = "points/run_up", dense.order

    def signals(speeds: np.ndarray) -> list[np.ndarray]:
        """Each (speeds, readings, m)."""
        found = dense.signals(at_speeds(dense, speeds).body, np.outer(speeds, order))
        return [np.moveaxis(one, 0, 1) for one in found]

    def rms(speeds: np.ndarray) -> list[np.ndarray]:
        rate = np.outer(speeds, order)
        low, high = dense.band()
        inside = (rate >= low * (1 - 1e-12)) & (rate <= high * (1 + 1e-12))
        squares = [np.abs(one) ** 2 * inside[:, None] for one in signals(speeds)]
        return [np.sqrt(0.5 * one.sum(axis=-1)) for one in squares]

    for number, name in enumerate(QUANTITIES):
        for kind in ("peak", "rms"):
            path = f"{root}/{name}_{kind}"

            def at(speeds: np.ndarray, n: int = number, k: str = kind) -> np.ndarray:
                return rms(speeds)[n] if k == "rms" else peak(signals(speeds)[n], order)

            speeds, values = dense.axis(path, 1), np.asarray(dense.record[path].values)
            chosen = _some(len(speeds), values.max(axis=0))
            size = float(values.max())
            yield Expected(path, at(speeds[chosen]).T, size=size, at=(slice(None), chosen))
            where = np.asarray(dense.record[f"{path}_largest_speed"].values)
            yield Expected(f"{path}_largest", np.diag(at(where)))
    if "vibration_severity" in dense.case and f"{root}/severity" in dense.record:
        speeds = dense.axis(f"{root}/severity", 1)
        values = np.asarray(dense.record[f"{root}/severity"].values)
        chosen = _some(len(speeds), values.max(axis=0))
        value = severity(rms(speeds[chosen])).T
        at_chosen = (slice(None), chosen)
        size = float(values.max())
        yield Expected(f"{root}/severity", value, size=size, at=at_chosen)
        where = np.asarray(dense.record[f"{root}/severity_largest_speed"].values)
        yield Expected(f"{root}/severity_largest", np.diag(severity(rms(where))))

    def moved(m: Moved) -> np.ndarray:
        place = np.moveaxis(m.body @ dense.rows().T, -1, 1)
        return place[..., None, :]

    path = f"{root}/displacement_peak_largest"
    first = int(np.argmax(dense.record[path].values))
    if dense.deep:
        yield Expected(path, highest(dense, moved, first), at=first)


def highest(dense: Dense, vectors: Callable[[Moved], np.ndarray], place: int) -> float:
    """Largest length over cycle and speeds of one of vectors (s, rows, components, m).

    Samples stand close about each speed at which an order meets a mode; what cannot be the
    largest, by the sum of its orders, is left; the highest are followed between neighbours.
    """
    given = dense.case["isolation"]["run_up"]
    low, high = given["from"], given["to"]
    frequency, _, ratio = _of_run_up(dense).modes()
    away = np.array([0.0, 0.3, 0.7, 1.0, 1.6, 3.0, 6.0])
    near = 1.0 + np.clip(ratio, 1e-6, 0.2)[:, None] * np.concatenate([-away, away])
    met = (frequency[:, None] * near)[..., None] / dense.order
    speeds = np.unique([*np.linspace(low, high, 160), *met[(met > low) & (met < high)]])
    found = np.concatenate(
        [vectors(at_speeds(dense, part))[:, place] for part in np.array_split(speeds, 12)]
    )
    bound = np.sqrt(np.square(np.abs(found).sum(axis=-1)).sum(axis=-1))
    heights = np.zeros(len(speeds))
    for n in np.argsort(-bound, kind="stable"):
        if bound[n] < 0.97 * heights.max():
            break
        heights[n] = float(longest(found[n], dense.order))

    def height(speed: float) -> float:
        return float(longest(vectors(at_speeds(dense, np.array([speed])))[0, place], dense.order))

    best = float(heights.max())
    for n in np.argsort(-heights)[:12]:
        ends = speeds[max(n - 1, 0)], speeds[min(n + 1, len(speeds) - 1)]
        if heights[n] < max(heights[max(n - 1, 0)], heights[min(n + 1, len(speeds) - 1)]):
            continue
        near_by = minimize_scalar(
            lambda s: -height(s), bounds=ends, method="bounded", options={"xatol": 1e-7 * high}
        )
        best = max(best, -float(near_by.fun))
    return best
