"""The report of `vibecalc accuracy`: its view of a result, the table, the object of --json."""
