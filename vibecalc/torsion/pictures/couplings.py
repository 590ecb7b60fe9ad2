"""Picture of elastic couplings: use of what their makers permit against speed."""

from vibecalc.core.report.canvas import LIMIT
from vibecalc.core.report.curves import Curve, Curves, Panel, operating
from vibecalc.torsion.pictures.excitation import also
from vibecalc.torsion.results import COUPLING

_BESIDE = {"loc": "upper left", "bbox_to_anchor": (1.005, 1.0)}


def _full(plot: object) -> None:
    """The line of all that is permitted."""
    plot.axes.axhline(100.0, color=LIMIT, linewidth=1.2, linestyle="--")  # type: ignore[attr-defined]


TORSION_COUPLINGS = Curves(
    also("couplings, use of what is permitted against speed"),
    (
        Panel(
            "use",
            (Curve(f"{COUPLING}/speeds/use", "{}", most=14), _full, operating),
            unit="%",
            legend=_BESIDE,
        ),
        Panel(
            "vibratory torque",
            (Curve(f"{COUPLING}/speeds/vibratory_torque", "{}"), operating),
            "half range of all orders",
            legend=_BESIDE,
        ),
        Panel(
            "power loss",
            (Curve(f"{COUPLING}/speeds/power_loss", "{}"), operating),
            legend=_BESIDE,
        ),
    ),
)
