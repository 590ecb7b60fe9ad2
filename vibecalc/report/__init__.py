"""From a result to words, tables, machine-readable objects and pictures. No physics here."""
