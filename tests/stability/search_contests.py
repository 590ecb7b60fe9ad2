"""The contests of `search.py`: which two ways to which number."""

from stability.search import Contest
from stability.search_lines import LINES
from stability.search_machines import MACHINES
from stability.search_tuning import TUNINGS

CONTESTS: tuple[Contest, ...] = (*MACHINES, *LINES, *TUNINGS)
