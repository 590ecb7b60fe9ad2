"""Adapter: loads of the machine onto machine and foundation, and what a rigid one would get."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.inertia_forces import with_terms
from vibecalc.foundation.model import flexible_foundation, on_body
from vibecalc.foundation.results import COUPLED, BelowMounts, CoupledModes, FoundationMotion
from vibecalc.foundation.systems import Curve, OnTables, on_tables
from vibecalc.isolation.adapters.efficiency import Ground, has_share
from vibecalc.isolation.adapters.steady import Moved, emit_steady, moved_by
from vibecalc.isolation.at_mounts import displacement
from vibecalc.isolation.efficiency import by_order, own_part, rms
from vibecalc.isolation.on_mounts import OnMounts, frequency_grid, of_each
from vibecalc.numerics.bounded import Bounded, bounded, reshaped
from vibecalc.numerics.rounding import ComplexArray
from vibecalc.parts.body import COORDINATES, DIRECTIONS
from vibecalc.parts.mount_needs import foundation_kind
from vibecalc.response.adapters.loads import BodyLoads, steady_motion

_TURN = 2.0 * np.pi
#: share of the loads' r.m.s. that may be at orders beyond the tables of a foundation
_OUTSIDE = 0.01


def run_coupled(scene: Scene) -> None:
    """Emit modes, motion of both, loads on the ground and on a rigid foundation, their ratios."""
    given, body, mounts = scene.case.foundation, scene.parts.body, scene.parts.mounts
    assert given is not None and body is not None and mounts is not None
    loads: BodyLoads = scene.handed_on["loads"]
    frequency, used = loads.order * scene.case.machine.speed, loads.retained
    system: OnMounts
    if foundation_kind(scene.case) == "body":
        system = scene.handed_on["on_foundation"] = on_body(given, body, mounts)
        _emit_modes(scene, system)
        words = "two rigid bodies, 12 x 12 complex dynamic stiffness"
    else:
        system = on_tables(body, mounts, flexible_foundation(given, mounts.names))
        _inside(scene, system.curves, loads, frequency)
        words = "mounts in series with the dynamic stiffness of their feet"
    source = "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3 and 10"
    scene.cite(words, "motion of machine and foundation", source)

    def solve(load: Bounded) -> Moved:
        return moved_by(
            system, steady_motion(scene, system, system.felt(load), loads.order), frequency
        )

    still: OnMounts = scene.handed_on["on_mounts"]
    motion, alone = (
        steady_motion(scene, one, one.felt(loads.load), loads.order) for one in (system, still)
    )
    found = moved_by(system, motion, frequency)
    emit_steady(scene, mounts, found, solve)
    ground = system.ground_load(motion, frequency)
    natural = np.concatenate([still.shapes.natural_frequency, system.shapes.natural_frequency])
    scene.handed_on["ground"] = Ground(ground, system.transmissibility, natural)
    grid = frequency_grid(natural, highest=float(frequency[used - 1]))
    axes = {
        "order": loads.order[:used].astype(float),
        "direction": DIRECTIONS,
        "mount": mounts.names,
        "coordinate": COORDINATES,
        "foundation_frequency": grid / _TURN,
    }
    for group in _below(system, motion, found.force, scene.case.machine.speed, loads):
        scene.emit_all(group, axes)
    arriving = {"ground": ground, "rigid": still.ground_load(alone, frequency)}
    through = {
        name: one.transmissibility(frequency)
        for name, one in (("ground", system), ("rigid", still))
    }
    for what, part in (("force", slice(0, 3)), ("couple", slice(3, 6))):
        for name, load in arriving.items():
            both = loads.load[:, part], load[:, part]
            own = own_part(both[0], through[name], part)
            scene.emit_all(_arriving(scene, name, what, *both, own, loads), axes)
    for name, one in (("ground", system), ("rigid", still)):
        scene.emit_all({f"{COUPLED}/{name}/transmissibility": partial(_curves, one, grid)}, axes)


def _curves(system: OnMounts, frequency: np.ndarray) -> Bounded:
    return of_each(system.transmissibility(frequency))


def _emit_modes(scene: Scene, system: OnMounts) -> None:
    shapes = system.shapes
    axes = {"coupled_mode": np.arange(1, len(shapes.natural_frequency) + 1)}
    found = CoupledModes(
        natural_frequency=shapes.bounded_frequency,
        damping_ratio=system.damping_ratio(),
        machine_share=system.energy_fraction()[..., :6].sum(-1),
    )
    scene.emit_all(found, axes)


def _inside(scene: Scene, curves: Sequence[Curve], loads: BodyLoads, frequency: np.ndarray) -> None:
    """Say which orders are beyond the tables; refuse where these matter."""
    low = max(float(one.frequency[0]) for one in curves)
    high = min(float(one.frequency[-1]) for one in curves)
    out = (frequency < low) | (frequency > high)
    if low == high or not np.any(out[: loads.retained]):
        return  # one row holds at all frequencies
    size = np.abs(loads.load.value[: loads.retained])
    whole, beyond = (
        np.linalg.norm(part, axis=0) for part in (size, size * out[: loads.retained, None])
    )
    share = float(np.max(beyond / np.where(whole > 0.0, whole, 1.0)))
    first = float(loads.order[int(np.argmax(out))])
    words = (
        f"order {first:g} at {frequency[int(np.argmax(out))] / _TURN:.6g} Hz lies beyond the "
        f"tables of the foundation, {low / _TURN:.6g} to {high / _TURN:.6g} Hz"
    )
    if share > _OUTSIDE:
        raise NumericalFailure(
            f"{words}: {share:.1%} of the r.m.s. of a load on the machine is at such orders; give "
            "the tables more rows"
        )
    scene.warn(f"{words}: their first or last row holds there, for loads of {share:.1e} of all")


def _below(
    system: OnMounts, motion: Bounded, force: Bounded, speed: float, loads: BodyLoads
) -> Iterator[FoundationMotion | BelowMounts]:
    """What the foundation does by a motion (m, f) and forces (mounts, 3, m) of the mounts."""
    used = loads.retained
    kept = list(system.plate if isinstance(system, OnTables) else range(6))
    if kept:
        plate = motion[:used, 6 : 6 + len(kept)] @ np.eye(6)[kept]
        yield FoundationMotion(plate[:, :3], plate[:, 3:])
    foot = displacement(-system.stretch[..., 6:], motion[:, 6:])
    rate = foot * (1j * loads.order * speed)
    power = (rate * Bounded(np.conj(force.value), force.error)).real.sum((0, 1)) * 0.5
    rates = reshaped(rate, lambda one: np.moveaxis(one, -1, 0))
    level = rms(rates, used, loads.tail).norm().value
    yield BelowMounts(foot[..., :used], level, power[:used])


def _arriving(
    scene: Scene,
    name: str,
    what: str,
    held: Bounded,
    load: Bounded,
    own: ComplexArray,
    loads: BodyLoads,
) -> dict[str, Any]:
    """A load (m, 3) below the mounts, and how much less it is than that `held` on them, by path.

    Of the load the `own` part comes from what is held.
    """
    used, path = loads.retained, f"{COUPLED}/{name}/{what}"
    acting, total, alone = (rms(one, used, loads.tail).norm() for one in (held, load, bounded(own)))
    found: dict[str, Any] = {path: with_terms(load[:used])}
    found[f"{path}_rms"] = with_terms(total.value, total.rounding)
    words = f"{what} on {'a rigid foundation' if name == 'rigid' else 'the ground'}"
    unit = "N" if what == "force" else "N m"
    if has_share(scene, words, unit, acting, total, alone):
        found[f"{path}_efficiency"] = 1.0 - total.value / acting.value
    return found | {f"{path}_by_order": by_order(held[:used], load[:used], own[:used])[:, -1]}
