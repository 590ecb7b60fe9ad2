"""Every local maximum of the run-up in the report."""

import numpy as np

from vibecalc.core.report.sections import Section, along, labels, section
from vibecalc.core.report.writing import Column, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Record, Result
from vibecalc.isolation.results import RunUpMaxima

#: relative difference of forces and speeds that are one for a reader
_ALIKE = 1e-6
_MOST = 30


def run_up_maxima(result: Result) -> Section | None:
    """A line for each maximum, equal ones of several supports as one; None without any."""
    record = result.record
    if f"{RunUpMaxima.ROOT}/force" not in record:
        return None
    lines = _table(record) + paragraph(
        "largest: the order that is largest there, with its size over the peak of all; peaking: "
        "the order that bends the curve, with the mode nearest to its frequency; end: the curve "
        "goes on beyond the range"
    )
    shown = {path for path in record if path.startswith(f"{RunUpMaxima.ROOT}/")}
    return section("Maxima of the run-up, force on a support", [(lines, shown)])


def _table(record: Record) -> list[str]:
    names = (
        "mount", "force", "speed", "order", "order_share", "bending_order", "mode",
        "frequency_ratio", "at_end",
    )  # fmt: skip
    found = [record[f"{RunUpMaxima.ROOT}/{name}"] for name in names]
    columns = np.array([one.values for one in found], dtype=float)
    hit = along(record, "isolation/support_force/static", "mount")
    mounts = labels(hit[0].axes[0]) if hit is not None else []
    groups: list[tuple[np.ndarray, list[str]]] = []
    for one in columns.T:
        name = mounts[int(one[0]) - 1] if mounts else f"{one[0]:g}"
        for first, members in groups:
            if np.allclose(first[1:], one[1:], rtol=_ALIKE, atol=0.0):
                members.append(name)
                break
        else:
            groups.append((one, [name]))
    # of a machine with many mounts the highest, in the order of their speeds
    left = len(groups) - _MOST
    groups = sorted(groups, key=lambda group: -group[0][1])[:_MOST]
    groups.sort(key=lambda group: group[0][2])
    rows = [
        [
            show(rpm(one[2]), rpm(found[2].error_estimate)),
            show(one[1], found[1].error_estimate) if np.isfinite(one[1]) else "no bound",
            ", ".join(members),
            f"{one[3]:g}",
            f"{100.0 * one[4]:.0f} %",
            f"{one[5]:g}",
            f"{one[6]:.0f}",
            f"{one[7]:.3f}",
            "end" if one[8] else "",
        ]
        for one, members in groups
    ]
    heads = (
        number("rpm"), number("force N"), Column("mount"), number("largest"),
        number("of the peak"), number("peaking"), number("mode"),
        number("order/mode"), Column("")
    )  # fmt: skip
    lines = table(heads, rows)
    return lines + (paragraph(f"the other {left} are lower, and in the file") if left > 0 else [])
