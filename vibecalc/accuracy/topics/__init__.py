"""What there is to compare in a stage: the question, the methods with their ladders, the truth."""
