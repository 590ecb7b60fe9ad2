"""What a result of `vibecalc accuracy` holds, shared by its writer and its readers.

    accuracy/<stage>/<topic>/worst_relative, worst_level, position_error, work, status, cause,
        setting, is_default, on_front         (rung)     one entry for each method and setting
    .../order, order_kind                     (method)   fitted order of convergence
    .../cheapest_in_work                      (target)   number of the rung from 1, 0: none
    .../agreement, extra_work                            of the reference; of the default

All of these are the same from run to run on one machine. What is not is a JSON text in the
attribute `accuracy` of /provenance: seconds of each rung (null: not run), the front and the
cheapest rungs in seconds, by the folder of the topic. The words of topics and methods are rows of
`plan`, told apart by the key `method`.
"""

from vibecalc.results.record import Result

ROOT = "accuracy"

#: how a rung ended
DONE, FAILED, NOT_RUN = 0, 1, 2
STATUS_WORDS = {DONE: "done", FAILED: "failed", NOT_RUN: "not run"}

#: worst relative errors that users ask for
TARGETS = (1e-3, 1e-6, 1e-9)

#: kinds of a fitted order
ALGEBRAIC, GEOMETRIC, NOT_FITTED = "order", "digits", "none"

#: between the method and the setting in the name of a rung
BETWEEN = " | "

#: name in /provenance
MEASURED = "accuracy"


def is_accuracy(result: Result) -> bool:
    """Whether a result is one of `vibecalc accuracy`."""
    return any(path.startswith(f"{ROOT}/") for path in result.record)
