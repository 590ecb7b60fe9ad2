"""Parts of machines that several subjects share: their tables, arrays and checks."""
