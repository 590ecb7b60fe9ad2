"""Speed against error of the methods for shaft lines."""
