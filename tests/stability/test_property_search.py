"""Claim: where the search has looked, two ways to a number differ by no more than they say."""

import numpy as np
import pytest
from stability.search import Contest, Find, measured, search
from stability.search_contests import CONTESTS
from stability.search_finds import CORRECTED, FINDS

from vibecalc.errors import NumericalFailure

NAMED = {contest.name: contest for contest in CONTESTS}


@pytest.mark.parametrize("find", [*FINDS, *CORRECTED], ids=lambda find: find.name)
def test_the_worst_points_keep_their_promise(find: Find) -> None:
    value, refused = measured(NAMED[find.name], np.array(find.point))
    assert value <= 1.0 and not refused


def test_every_contest_has_its_worst_point() -> None:
    assert [find.name for find in FINDS] == list(NAMED)
    for find in FINDS:
        assert find.ratio <= 1.0
        assert len(find.point) == NAMED[find.name].size
    for find in CORRECTED:
        assert find.ratio > 1.0 and len(find.point) == NAMED[find.name].size


@pytest.mark.long
@pytest.mark.parametrize("name", list(NAMED))
def test_a_short_search_finds_nothing(name: str) -> None:
    found = search(NAMED[name], seed=3, evaluations=200)
    assert found.ratio <= 1.0, found
    assert found.refused < found.tried


def ridge(point: np.ndarray) -> float:
    """A slope that leads to a narrow resonance of 2, away from which nothing is above .5."""
    away = float(np.max(np.abs(point - 0.7)))
    return 2.0 if away < 0.02 else 0.5 * (1.0 - away)


def test_a_planted_defect_is_climbed_to() -> None:
    planted = Contest("planted", "", 3, ridge)
    found = search(planted, seed=1, evaluations=600)
    assert found.ratio == 2.0 and max(abs(x - 0.7) for x in found.point) < 0.02
    # 300 random points alone miss it: a chance of 6e-5 each
    assert search(planted, seed=1, evaluations=2) != found
    assert search(planted, seed=1, evaluations=600) == found
    assert isinstance(found, Find)


def test_no_number_is_the_worst_and_a_refusal_the_best() -> None:
    assert measured(Contest("nan", "", 1, lambda _: np.nan), np.zeros(1)) == (np.inf, False)

    def refuses(_: np.ndarray) -> float:
        raise NumericalFailure("no digits")

    assert measured(Contest("loud", "", 1, refuses), np.zeros(1)) == (0.0, True)
