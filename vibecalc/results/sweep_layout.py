"""Names in the file of a sweep, shared by its writer and its reader.

A sweep is stored as a result (`vibecalc.results.layout`) whose quantities have the axes of the
sweep first and their own axes after them. What it has on top of that:

    /                       attribute sweep_schema_version; dimension scales of the axes of the
                            sweep: values of the first key of each, or numbers of samples
    /sweep                  attributes identity, base, sampling, and as JSON texts: design, axes
                            (name, keys, labels, written units), kept (paths asked for) and
                            left_out (path to the reason why it could not be stacked)
    /sweep/status           what became of each point (`STATUS_WORDS`)
    /sweep/values/<key>     values of each key along its axis
    /sweep/message          for points without a result: point (numbers, in C order), cause (rows
                            of text) and text
    /sweep/error_estimate/<path>, /sweep/standard_error/<path>
                            errors of each point; the attributes of a quantity are the largest

Points without a quantity are NaN. Orders that a point does not have, where others do, are zero.
"""

SWEEP_SCHEMA_VERSION = 1

SWEEP = "sweep"
VERSION_ATTRIBUTE = "sweep_schema_version"
STATUS = "sweep/status"
VALUES = "sweep/values"
MESSAGE = "sweep/message"
ERRORS = "sweep/error_estimate"
STANDARD_ERRORS = "sweep/standard_error"

NOT_RUN, DONE, REFUSED, FAILED, TIMED_OUT, DIED, BUG = range(-1, 6)

#: what became of a point, in words
STATUS_WORDS = {
    NOT_RUN: "not run",
    DONE: "done",
    REFUSED: "input refused",
    FAILED: "numerical failure",
    TIMED_OUT: "timed out",
    DIED: "process died",
    BUG: "error in the program",
}

#: name of the one axis of a sampling
SAMPLE = "sample"
