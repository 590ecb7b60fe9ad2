"""What a run leaves behind: named quantities, their file, their comparison."""
