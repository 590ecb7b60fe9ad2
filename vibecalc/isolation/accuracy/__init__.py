"""Speed against error of the methods for isolation."""
