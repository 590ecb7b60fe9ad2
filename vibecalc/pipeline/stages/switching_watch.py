"""Was the body watched for long enough after a change between operations?"""

from collections.abc import Sequence

import numpy as np

from vibecalc.response.switching.follow import Transient
from vibecalc.response.switching.lasting import lasting_peaks

#: readings of which peaks are given, with the columns that stand on one scale
READINGS = (
    ("displacement", slice(0, 3)),
    ("rotation", slice(3, 6)),
    ("force on the ground", slice(6, 9)),
    ("couple on the ground", slice(9, 12)),
    ("kinetic energy", slice(12, 13)),
    ("potential energy", slice(13, 14)),
)
#: a share of the largest peak of a reading that is not worth a word
_WORTH_A_WORD = 1e-6


def short_watch_warning(
    labels: Sequence[str], words: str, after: float, found: Sequence[Transient]
) -> str | None:
    """One sentence for the changes of which larger peaks may come after the time watched.

    `after` in s is that time from the last change of load, `words` say how the change is made.
    """
    parts = []
    for label, each in zip(labels, found, strict=True):
        grows = _may_grow(each) if each.settling.after > after else []
        if grows:
            parts.append(
                f"{label} {words} settles in {each.settling.after:.3g} s; its "
                f"{', '.join(grows)} may be larger later than the peak that is given"
            )
    if not parts:
        return None
    return (
        f"the {after:.6g} s watched after a change end before the body has settled: "
        f"{'; '.join(parts)}. Give [response.switching] a longer after"
    )


def _may_grow(found: Transient) -> list[str]:
    """`kinetic energy (up to 1.2 times)`: readings whose later bound is above their peak."""
    peaks = lasting_peaks(found)
    names = []
    for name, part in READINGS:
        value, later = peaks.value[part], found.later[part]
        scale = float(np.max(value))
        beyond = later > value + peaks.error[part] + _WORTH_A_WORD * scale
        if np.any(beyond):
            times = float(np.max(later[beyond])) / scale if scale > 0.0 else np.inf
            bound = f" (up to {times:.3g} times)" if 1.001 <= times < np.inf else ""
            names.append(name + bound)
    return names
