"""Names and versions in a result file, shared by its writer and its reader.

    /                       attributes: vibecalc_version, schema_version, name, case_sha256,
                            case_toml (as written), case_toml_resolved, and as JSON texts:
                            quantities (paths in the order they were made), plan, warnings,
                            methods
    /<stage>/...            one dataset for each quantity, under its path; attributes units,
                            long_name, error_estimate, and amplitude, standard_error and
                            terms if any
    /<stage>/<axis>         dimension scales (`order`, `order_2`, ...), shared inside a stage
    /provenance             attributes that change from run to run (among them `libraries`,
                            what its process had imported), left out of comparisons,
                            and text_checksum, a CRC-32 of all texts in the file
    /provenance/timings     attributes: seconds per stage

All texts are variable-length UTF-8, which HDF5 keeps outside the object header, so that a case of
more than 64 kB fits into an attribute. Complex numbers are compounds of `r` and `i`.
"""

#: version of the layout of result files
RESULT_SCHEMA_VERSION = 1

TEXT_ATTRIBUTES = (
    "vibecalc_version",
    "name",
    "case_sha256",
    "case_toml",
    "case_toml_resolved",
)
JSON_ATTRIBUTES = ("quantities", "plan", "warnings", "methods")

PROVENANCE = "provenance"
TIMINGS = "timings"
TEXT_CHECKSUM = "text_checksum"
