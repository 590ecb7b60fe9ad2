"""The change from one operation to another, in time."""
