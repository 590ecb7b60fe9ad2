"""What the couplings of a shaft line bear, next to what their makers permit."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import (
    Bounded,
    bounded,
    reshaped,
    rounded,
    sqrt,
    square,
    stack,
    where,
)
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray
from vibecalc.torsion.adapters.motion import EVERY, Motion, Reading, Rows
from vibecalc.torsion.adapters.search import Search, Top
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.couplings import LIMITS, Coupling, permitted_of
from vibecalc.torsion.study_results import COUPLING, LARGEST

# ----------------------------------------------------------------------------
# What each coupling bears, torques on its own shaft, and how much that is of what is permitted.
# ----------------------------------------------------------------------------

#: what is read of a coupling: names of results
VALUES = (
    "mean_torque", "peak_torque", "vibratory_torque", "torque_by_orders", "main_frequency",
    "power_loss", "temperature",
)  # fmt: skip

#: readings of couplings over the speeds
READ = (*VALUES, "use")


class Borne:
    """One of `VALUES` of each coupling (c,), or their "use" of limits (c k,), as a reading.

    `limits` (k,) are the places in `LIMITS` of those that some maker says.
    """

    kind = "mean"  # what nothing bounds is not searched for

    def __init__(self, setup: Setup, name: str) -> None:
        self.couplings, self.name = setup.shaft.couplings, name
        said = np.isfinite([permitted_of(one.permissible) for one in self.couplings])
        self.limits = np.flatnonzero(np.any(said, axis=0))
        each = len(self.limits) if name == "use" else 1
        self.coupling = np.repeat(np.arange(len(self.couplings)), each)
        self.element = np.array([one.element for one in self.couplings])
        #: sections, as in a reading
        self.place = self.element[self.coupling]

    def of(self, motion: Motion, at: Rows = EVERY, row: Rows = EVERY) -> Bounded:
        """As of a reading; infinite where nothing damps an order."""
        if at is EVERY:
            shape = len(motion.speed), len(self.place)
            every = self.of(motion, *np.indices(shape).reshape(2, -1))
            return reshaped(every, lambda one: one.reshape(shape))
        which = self.coupling[row]
        if self.name != "use":
            return self._value(self.name, motion, at, which)
        limit, found = np.tile(self.limits, len(self.couplings))[row], np.zeros((2, len(which)))
        for one in sorted(set(limit.tolist())):
            own = np.flatnonzero(limit == one)
            share = self._share(one, motion, at[own], which[own])
            found[:, own] = share.value, share.errors
        return Bounded(*found)

    def errors(self, motion: Motion) -> FloatArray:
        """As of a reading."""
        found = self.of(motion)
        return np.where(np.isfinite(found.value), found.errors, 0.0)

    def _value(self, name: str, motion: Motion, at: IntArray, which: IntArray) -> Bounded:
        """Of couplings `which` (k,), each at its own speed (k,)."""
        place = self.element[which]
        kind = {"mean_torque": "mean", "peak_torque": "peak_with_mean", "power_loss": "heat",
                "vibratory_torque": "half_range"}.get(name)  # fmt: skip
        if kind is not None:
            return Reading("torque", place, kind, "", ()).of(motion, at)
        if name == "temperature":
            power = self._value("power_loss", motion, at, which)
            rise, ambient = (self._each(which, one) for one in ("resistance", "temperature"))
            hot = where(rise > 0.0, where(rise > 0.0, power, 0.0) * rise, 0.0)
            return where(np.isfinite(power.value), hot, np.where(rise > 0.0, np.inf, 0.0)) + ambient
        size, w = abs(bounded(motion.rows("torque", place, at))), motion.state.frequency[at]
        if name == "main_frequency":
            main = np.take_along_axis(w, np.argmax(size.value, axis=-1)[:, None], axis=-1)
            return rounded(main[:, 0], 2.0)
        factor = rounded(self._by_coupling(which, w, Coupling.frequency_factor), 4.0)
        return where(~motion.masked[at], sqrt(square(factor * size).sum(axis=-1)), np.inf)

    def _each(self, which: IntArray, name: str) -> FloatArray:
        return np.array([getattr(one, name) for one in self.couplings])[which]

    def _by_coupling(
        self,
        which: IntArray,
        value: FloatArray,
        function: Callable[[Coupling, FloatArray], FloatArray],
    ) -> FloatArray:
        """A function of each coupling `which` (k,) at its values (k, ...)."""
        found = np.empty_like(value)
        for place, one in enumerate(self.couplings):
            found[which == place] = function(one, value[which == place])
        return found

    def _share(self, limit: int, motion: Motion, at: IntArray, which: IntArray) -> Bounded:
        """Use of one of `LIMITS`; 0 where the maker does not say it."""
        every = np.array([permitted_of(one.permissible) for one in self.couplings])
        permitted = every[which, limit]

        def value(name: str) -> Bounded:
            return self._value(name, motion, at, which)

        if limit < 4:
            name = VALUES[limit]
            heat = value("temperature").value
            finite = np.where(np.isfinite(heat), heat, 0.0)
            load = abs(value(name)) if name == "mean_torque" else value(name)
            load = load * rounded(self._by_coupling(which, finite, Coupling.service_factor), 4.0)
            if name == "vibratory_torque":
                main = value("main_frequency").value
                factor = self._by_coupling(which, main, Coupling.frequency_factor)
                load = load * rounded(factor, 4.0)
        elif limit == 4:
            load = value("power_loss")
        elif limit == 5:
            load = rounded(motion.speed[at] * np.abs(self._each(which, "ratio")), 4.0)
        else:
            ambient = self._each(which, "temperature")
            load, permitted = value("temperature") - ambient, permitted - ambient
        said = np.isfinite(permitted)
        return where(said, load, 0.0) * np.where(said, 1.0 / np.where(said, permitted, 1.0), 0.0)


def coupling_readings(setup: Setup, names: Sequence[str] = ("use",)) -> dict[str, Borne]:
    """What couplings bear, by the name of the reading: "coupling use" where makers say limits."""
    found = {f"coupling {name}": Borne(setup, name) for name in names if setup.shaft.couplings}
    return {name: one for name, one in found.items() if len(one.place)}


def _known(setup: Setup, name: str) -> tuple[IntArray, dict[str, Any]]:
    """The couplings of which a value is known, all but of temperatures, and axes of that."""
    couplings = setup.shaft.couplings
    known = [one.temperature > 0.0 or name != "temperature" for one in couplings]
    names = tuple(one.name for one, there in zip(couplings, known, strict=True) if there)
    return np.flatnonzero(known), {"coupling": names}


def _axes(setup: Setup) -> dict[str, Any]:
    limits = Borne(setup, "use").limits
    names = tuple(one.name for one in setup.shaft.couplings)
    return {"coupling": names, "coupling_limit": tuple(LIMITS[place] for place in limits)}


# ----------------------------------------------------------------------------
# Adapter: couplings at the operating speed.
# ----------------------------------------------------------------------------


def emit_couplings(scene: Scene, setup: Setup, motion: Motion) -> None:
    """Torques, heat, temperature, stiffness and use of the limits at the operating speed."""
    found = {name: Borne(setup, name).of(motion)[0] for name in VALUES}
    for name, value in found.items():
        place, axes = _known(setup, name)
        if len(place):
            scene.emit(f"{COUPLING}/{name}", value[place], axes=axes)
    _warn_of_rows(scene, setup, found)
    _emit_values(scene, setup)
    emit_uses(scene, COUPLING, [motion], {})


def _emit_values(scene: Scene, setup: Setup) -> None:
    """Stiffness and loss factor at the orders, stiffness at the natural frequencies, own values."""
    order, axes, states = setup.drive.order, _axes(setup), setup.model.couplings
    couplings, natural = setup.shaft.couplings, setup.modes.frequency
    off = 16.0 * EPSILON + (0.0 if states is None else states.spread())
    own = np.square([one.ratio for one in couplings])[:, None]

    def put(name: str, value: FloatArray, of: dict[str, Any], count: int) -> None:
        rows = np.broadcast_to(value, (count, value.shape[-1]))
        rows = rows[:, [one.element for one in couplings]].T
        rows = rows if name == "loss_factor" else rows / own
        scene.emit(f"{COUPLING}/{name}", rows, off * rows, {**axes, **of})

    line = setup.model.at(setup.speed, setup.speed * order)
    put("stiffness", line.stiffness, {"order": order}, len(order))
    put("loss_factor", line.loss_factor, {"order": order}, len(order))
    modes = {"mode": np.arange(1, len(natural) + 1)}
    put("mode_stiffness", setup.model.at(setup.speed, natural).stiffness, modes, len(natural))


def _warn_of_rows(scene: Scene, setup: Setup, found: Mapping[str, Bounded]) -> None:
    """Say where a coupling is beyond the last row of its table at the operating speed."""
    for place, one in enumerate(setup.shaft.couplings):
        for rows, name, words in (
            (one.mean_torque, "mean_torque", "mean torque"),
            (one.amplitude, "vibratory_torque", "vibratory torque"),
        ):
            size = abs(float(found[name].value[place]))
            if rows is not None and size > rows.at[-1]:
                scene.warn(
                    f"coupling '{one.name}': its {words}, {size:.5g} N m, exceeds the "
                    f"last row of its table, {rows.at[-1]:.5g} N m; the values of that row are used"
                )


# ----------------------------------------------------------------------------
# Adapter: couplings over a range of crank speeds, the largest use of each limit and where it is.
# ----------------------------------------------------------------------------

#: of a value, what it may differ by over the speeds and count as one
LEVEL = 1e-11


def emit_coupling_speeds(scene: Scene, setup: Setup, search: Search) -> None:
    """Curves over the speeds (s,) and the largest values at any of them."""
    axes = {**_axes(setup), "speed": search.speed}
    for name in VALUES:
        curve = search.bounded_curves(f"coupling {name}")
        place, own = _known(setup, name)
        if not len(place):
            continue
        axes_of = {**own, "speed": search.speed}
        scene.emit(f"{COUPLING}/speeds/{name}", curve.T[place], axes=axes_of)
        if name in LARGEST:
            top = _top(search, f"coupling {name}").of(0)
            scene.emit(f"{COUPLING}/largest/{name}", top.value[place], axes=own)
            scene.emit(f"{COUPLING}/largest/{name}_speed", top.speed[place], axes=own)
    if "coupling use" in search.columns:
        shape = (-1, len(axes["coupling_limit"]), len(search.speed))
        use = reshaped(search.bounded_curves("coupling use").T, lambda one: one.reshape(shape))
        scene.emit(f"{COUPLING}/speeds/utilisation", use, axes=axes)
        emit_largest_uses(scene, COUPLING, search, {})


def _top(search: Search, name: str) -> Top:
    """The largest; what is the same at every speed is met at the lowest."""
    top, curve = search.top(name), search.samples[:, search.columns[name]]
    level = []
    for line in range(search.machines):
        own = curve[search.pairs.real == line]
        with np.errstate(invalid="ignore"):  # where nothing damps an order
            level.append(np.ptp(own, axis=0) <= LEVEL * own.max(axis=0))
    return Top(top.value, where(np.array(level), search.speed[0], top.speed))


def emit_uses(scene: Scene, place: str, motions: Sequence[Motion], axes: Mapping[str, Any]) -> None:
    """Use of the limits in conditions (c,) at the operating speed; of the only one without axis."""
    uses = [coupling_readings(one.setup).get("coupling use") for one in motions]
    rows = [use.of(one)[0] for use, one in zip(uses, motions, strict=True) if use is not None]
    if rows:
        _put(scene, f"{place}/utilisation", motions[0].setup, stack(rows, axis=0), axes)


def emit_largest_uses(scene: Scene, place: str, search: Search, axes: Mapping[str, Any]) -> None:
    """The largest use of the limits in conditions (c,) at any speed, and where it is."""
    top = _top(search, "coupling use")
    for name, value in (
        ("largest_utilisation", top.value),
        ("largest_utilisation_speed", top.speed),
    ):
        _put(scene, f"{place}/{name}", search.lines[0], value, axes)


def _put(scene: Scene, path: str, setup: Setup, value: Bounded, axes: Mapping[str, Any]) -> None:
    """Of couplings and limits (c, k r) in conditions."""
    of = _axes(setup)
    shape = (-1, len(of["coupling"]), len(of["coupling_limit"]))
    each = reshaped(value, lambda one: one.reshape(shape))
    scene.emit(path, each if "condition" in axes else each[0], axes={**axes, **of})
