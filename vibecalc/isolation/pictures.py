"""Pictures of a body on its mounts: forces over a turn, modes, run-up, mounts."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    ORDER_NAMES,
    QUIET,
    TOTAL,
    bounds_of,
    canvas,
    note,
)
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Mark,
    Panel,
    Plot,
    decades,
    level,
    limits,
    spans,
    usual_ends,
)
from vibecalc.core.report.marks import peak, resonances
from vibecalc.core.report.rows import chosen, reduced
from vibecalc.core.report.sections import having, labels, scalar_of, speed_of, table_of
from vibecalc.core.report.sources import Look, of_freedoms, over_turn, sourced
from vibecalc.core.report.writing import hertz, rpm, show
from vibecalc.core.results.record import Quantity, Result
from vibecalc.isolation.efficiency_report import LOUD, ROOTS, resultant
from vibecalc.isolation.results import AT_REST, BY_ORDER, MOVING, ByDirection
from vibecalc.response.report import main_coordinates

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# The pitch couple / lever during one turn, body held still and on its mounts.
# ----------------------------------------------------------------------------


def _over_cycle(name: str, words: str) -> Panel:
    stem = f"isolation/couple_over_lever/{name}"
    orders = [
        Curve(over_turn(f"{stem}_harmonics", partial(np.equal, order)), said)
        for order, said in ORDER_NAMES.items()
    ]
    total = Curve(over_turn(f"{stem}_harmonics"), "total", {"color": TOTAL, "linewidth": 2.0})
    marks = (level(f"{stem}_peak", "peak", mirrored=True), limits(f"{stem}_peak", mirrored=True))

    def title(result: Result) -> str:
        peak = scalar_of(result.record, f"{stem}_peak")
        return words if peak is None else f"{words}, peak {show(peak, digits=4)} N"

    return Panel("force", (*orders, total, *marks), title, unit="N")


FORCE_OVER_CYCLE = Curves(
    "pitch couple / lever during one turn",
    (
        _over_cycle("blocked", "without isolation: rigidly mounted"),
        _over_cycle("steady", "through the mounts"),
    ),
    names=5,
)


# ----------------------------------------------------------------------------
# Couple of the cylinders' torque on the body, and the load of every support, over the cycle.
# ----------------------------------------------------------------------------

_COUPLE = "isolation/torque_reaction/couple"
_MEAN = "isolation/torque_reaction/mean_couple"
_FORCE = "isolation/support_force/"
#: of the largest order of a couple, what the last has to reach for ripples to be seen
_RIPPLE = 2e-3


def _reaction(result: Result) -> str:
    size = np.abs(result.record[_COUPLE].values)
    ripples = "; ripples result from the orders left out" * bool(size[-1] > _RIPPLE * size.max())
    return "torque reaction on the mounts" + ripples


def _couple(result: Result) -> Quantity | None:
    """The couple with its mean."""
    found, mean = sourced(over_turn(_COUPLE), result), scalar_of(result.record, _MEAN)
    return found and replace(found, values=found.values + (mean or 0.0))


def _loads(result: Result) -> Quantity | None:
    """What each support carries about its mean load, downwards, named with all that it carries."""
    found = sourced(over_turn(f"{_FORCE}steady_harmonics"), result)
    if found is None or _couple(result) is None:
        return None
    ends = [result.record.quantities.get(_FORCE + end) for end in ("minimum_load", "largest_load")]
    names = labels(found.axes[0])
    for i, name in enumerate(names if None not in ends else ()):
        names[i] = f"{name}: {' to '.join(show(one.values[i], digits=4) for one in ends if one)} N"
    mounts = replace(found.axes[0], values=np.array(names, dtype=object))
    up = "xyz".index(str(table_of(result.case, "isolation").get("up") or "z"))
    return replace(found, values=-found.values[:, up], axes=(mounts, found.axes[2]))


ENGINE_MOUNTS = Curves(
    _reaction,
    (
        Panel("couple", (Curve(_couple, look={"color": TOTAL}), level(_MEAN, "mean couple {}")),
              "couple on the body about the crankshaft", unit="N*m", needs=(_loads,)),
        Panel("load", (Curve(_loads, "mount {}", most=99),),
              "dynamic load on each mount, torque and shaking, downwards", unit="N"),
    ),
    high=3.05,
    names=3,
)  # fmt: skip


# ----------------------------------------------------------------------------
# Transmissibility of the pitch model against the frequency ratio, with the orders marked.
# ----------------------------------------------------------------------------

_BASE = "isolation/pitch/"
#: orders whose levels are named
_NAMED = 6


def _decibel(values: Any) -> Any:
    """20 log10 |T|; what is zero or infinite is a gap."""
    size = np.abs(np.asarray(values))
    return 20.0 * np.log10(np.where((size > 0.0) & np.isfinite(size), size, np.nan))


def _at_orders(result: Result) -> Quantity | None:
    """The transmissibility at the orders, over their ratios of frequency at the crank speed."""
    found = having(result.record, _BASE + "transmissibility", "order")
    natural = scalar_of(result.record, _BASE + "natural_frequency")
    if found is None or not natural:
        return None
    ratio = found.axes[0].values * (speed_of(result) or 0.0) / natural
    return replace(found, axes=(replace(found.axes[0], name="frequency_ratio", values=ratio),))


def _levels(result: Result) -> str:
    found = result.record[_BASE + "transmissibility"]
    levels = zip(found.axes[0].values[:_NAMED], _decibel(found.values), strict=False)
    return "dB at orders " + ", ".join(f"{order}: {level:.1f}" for order, level in levels)


def _isolates(plot: Plot) -> None:
    words = "isolation above $\\sqrt{2}$"
    plot.axes.axvline(np.sqrt(2.0), color=QUIET, linestyle=":", linewidth=1.2, label=words)


def _transmitted(part: Callable[[Any], Any]) -> tuple[Curve, Curve]:
    dots = {"color": COLOURS[0], "marker": "o", "linestyle": "none"}
    curve = Curve(_BASE + "transmissibility_curve", look={"color": TOTAL}, part=part)
    return curve, Curve(_at_orders, _levels, dots, part=part)


TRANSMISSIBILITY = Curves(
    "transmissibility of the mounts, pitch",
    (
        Panel("|force out / force in| in dB", (*_transmitted(_decibel), _isolates), log="x",
              height=2.0),
        Panel("phase in deg", _transmitted(lambda ratio: np.degrees(np.angle(ratio))), log="x",
              ends=(-185.0, 5.0), below="excitation frequency / natural frequency"),
    ),
    high=2.45,
)  # fmt: skip


# ----------------------------------------------------------------------------
# The run-up: at each speed the largest force over the cycle, with limits and resonances.
# ----------------------------------------------------------------------------

_NATURAL = ("isolation/modes/natural_frequency", "isolation/pitch/natural_frequency")


def _steady(path: str) -> Mark:
    """Limits of the steady state, at the operating speed."""

    def draw(plot: Plot) -> None:
        at = rpm(speed_of(plot.result) or np.nan)
        for words, bound in bounds_of(plot.result, path):
            height = plot.factor * bound
            plot.axes.plot([at], [height], "v", color=LIMIT, markersize=9, clip_on=False)
            note(plot.axes, f"steady {words}", (at, height), (-4, 7), ha="right", color=LIMIT)
            plot.points.append(height)

    return draw


def _run_up(path: str, label: str, look: Look) -> Panel:
    top = f"{path}/run_up_peak"
    parts = (
        Curve(f"{path}/run_up", "{each}", look),
        limits(top, "run-up"),
        _steady(f"{path}/steady_peak"),
        resonances(*_NATURAL),
        spans("isolation/resonances_skipped"),
        peak(top, f"{top}_speed"),
    )
    return Panel(f"{label}\nforce", parts, unit="N", log="x", ends=partial(usual_ends, low=0.0))


RUN_UP = Curves(
    "run-up: peak force over the cycle",
    (
        _run_up("isolation/couple_over_lever", "pitch couple / lever", {"color": TOTAL}),
        _run_up("isolation/support_force", "mount", {}),
    ),
    high=3.4,
)

# ----------------------------------------------------------------------------
# Which freedoms move in which mode of the body: shares of energy on each other.
# ----------------------------------------------------------------------------


def _modes(natural: Quantity) -> list[str]:
    """Modes by number and frequency."""
    each = zip(labels(natural.axes[0]), natural.values, strict=True)
    return [f"mode {mode}\n{show(hertz(float(value)), digits=4)} Hz" for mode, value in each]


#: share of the energy that is all of it
_ALONE = 0.9999


def _shares(result: Result) -> Quantity | None:
    """Share of each coordinate in the modes, which are named with their frequencies."""
    share = having(result.record, "isolation/modes/energy_fraction", "mode", "coordinate")
    natural = having(result.record, "isolation/modes/natural_frequency", "mode")
    if share is None or natural is None:
        return None
    modes, coordinates = share.axes
    modes = replace(modes, values=np.array(_modes(natural), dtype=object))
    return replace(share, path="", values=share.values.T, axes=(coordinates, modes))


def _modal_words(result: Result) -> str:
    share = result.record["isolation/modes/energy_fraction"].values
    alone = bool(np.all(np.abs(share).max(axis=1) > _ALONE))
    return "modes on the mounts: " + ("uncoupled" if alone else "shares of energy")


MODAL_ENERGY = Curves(
    _modal_words,
    (Panel("share of the energy", (Curve(_shares, "{}", bars=True),), unit="%", stacked=True),),
    names=6,
)


# ----------------------------------------------------------------------------
# The modes of the body as a box seen in perspective: where it goes and how it turns.
# ----------------------------------------------------------------------------

#: a way along all edges of a box, by the bits of its corners, and the box in perspective
_WAY = np.array([0, 1, 3, 2, 0, 4, 5, 1, 5, 7, 3, 7, 6, 2, 6, 4])
_BOX = (2 * (_WAY[:, None] >> np.arange(3) & 1) - 1) * np.array([0.62, 0.62, 0.5])
#: lengths of the arrows, how far the box is drawn aside, and by what angle, of a mode of size 1
_ARROW, _ASIDE, _ANGLE = 1.05, 0.4, 0.35


def draw_mode_shapes(result: Result) -> "Figure | None":
    """A panel for each mode; None without shapes and their shares of energy.

    Metres and radians have no common scale: each component is drawn as long as the square root of
    its share of the kinetic energy, with the sign of the shape.
    """
    found = [having(result.record, f"response/modes/{name}", "mode", "coordinate")
             for name in ("shape", "energy_fraction")]  # fmt: skip
    natural = having(result.record, "response/modes/natural_frequency", "mode")
    shape, share = found
    if shape is None or share is None or natural is None or shape.values.shape[-1] != 6:
        return None
    length = np.sign(np.real(shape.values)) * np.sqrt(np.abs(share.values))
    rows = -(-len(length) // 3)
    figure = canvas(result, "modes of the body; arrows scaled by energy share", 1.2 + 2.6 * rows)
    for i, (vector, name) in enumerate(zip(length, _modes(natural), strict=True)):
        axes = figure.add_subplot(rows, 3, i + 1, projection="3d")
        _mode(axes, vector)
        axes.set_title(f"{name}\n{main_coordinates(share, i)}")
    handles, words = axes.get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower center", ncols=4)
    return figure


def _mode(axes: Any, vector: np.ndarray) -> None:
    """The box at rest, the box displaced, and the two arrows from its centre."""
    from scipy.spatial.transform import Rotation

    along, about = vector[:3], vector[3:]
    moved = Rotation.from_rotvec(_ANGLE * about).apply(_BOX) + _ASIDE * along
    look: dict[str, Any] = {"linewidth": 2.2, "zorder": 5}
    axes.quiver(0, 0, 0, *(_ARROW * along), color=COLOURS[0], label="translation", **look)
    words = "rotation (right-handed)"
    axes.quiver(0, 0, 0, *(_ARROW * about), color=COLOURS[1], label=words, **look)
    axes.plot(*_BOX.T, color="#b0b0b0", linewidth=0.9, label="at rest")
    axes.plot(*moved.T, color="#444444", linewidth=1.4, label="displaced, exaggerated")
    for name, end in zip("xyz", np.diag([1.2, 1.2, 0.95]), strict=True):
        axes.plot(*np.transpose([0.0 * end, end]), color=QUIET, linewidth=0.8, ls=":")
        axes.text(*end, name, color=QUIET)
    axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-0.8, 0.8))
    axes.set_box_aspect((1.0, 1.0, 0.8), zoom=1.1)
    axes.view_init(elev=24.0, azim=-62.0)
    axes.set_axis_off()


# ----------------------------------------------------------------------------
# Mounts: load over deflection with the rest and the motion, stiffness by order.
# ----------------------------------------------------------------------------


def _rests(plot: Plot) -> None:
    """A dot where each mount is at rest, with the range of its motion at speed."""
    record = plot.result.record
    load, deflection = (record[path].values for path in AT_REST[:2])
    travel = record[MOVING[0]].values if MOVING[0] in record else np.zeros(len(load))
    plot.axes.errorbar(1e3 * deflection, plot.factor * load, xerr=1e3 * travel, fmt="o", zorder=5,
                       color=TOTAL, capsize=2.5, label="at rest")  # fmt: skip


_DOTS = {"marker": "o", "markersize": 3.5}
_BY_ORDER = "at the frequency of each order"
MOUNTS = Curves(
    "mounts: static load and stiffness",
    (
        Panel("load", (Curve(AT_REST[4], "{each}"), _rests),
              "static load against compression along the axis; dots: at rest"),
        Panel("stiffness", (Curve(BY_ORDER[0], "{each}", _DOTS),), f"dynamic stiffness {_BY_ORDER}",
              unit="kN/mm"),
        Panel("loss factor", (Curve(BY_ORDER[1], look=_DOTS),), f"loss factor {_BY_ORDER}"),
    ),
)  # fmt: skip


# ----------------------------------------------------------------------------
# Load transmitted by order, next to that of the rigidly mounted machine; over the frequency.
# ----------------------------------------------------------------------------


def _panel(path: str, word: str) -> Panel:
    sizes = reduced(f"{path}/held"), reduced(f"{path}/ground")
    dots = Curve(chosen(resultant(path), LOUD, *sizes), bars=True, part=lambda share: 1.0 - share)
    words = f"{word} on the ground / {word} rigidly mounted"
    return Panel("transmitted", (dots, level(lambda _: 1.0)), words, unit="%", log="y",
                 ends=decades(4))  # fmt: skip


def _ratio(turning: bool) -> Panel:
    of = of_freedoms(f"{ByDirection.ROOT}/transmissibility", turning)
    words = f"load on the ground / load on the body, {'about' if turning else 'along'} axes"
    return Panel("transmissibility", (Curve(of, "{}"), level(lambda _: 1.0)), words, log="xy")


EFFICIENCY = Curves(
    "isolation: load transmitted to the ground",
    (*(_panel(root, word) for word, root in ROOTS.items()), _ratio(False), _ratio(True)),
    columns=2,
    names=6,
    level="row",
)
