"""Claim: a slip of the hand on the command line costs neither a file nor a true exit code."""
