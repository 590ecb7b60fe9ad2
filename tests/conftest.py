"""The same examples in every run, and commands that can be interrupted wherever tests run."""

import gc
import signal

import pytest
from hypothesis import HealthCheck, settings

# what a search finds once becomes an example of its own; how long one takes tells of the machine
slow = [HealthCheck.too_slow]
settings.register_profile("fixed", derandomize=True, deadline=None, suppress_health_check=slow)
settings.load_profile("fixed")

# a shell's background jobs ignore an interrupt, and what they start would inherit that
signal.signal(signal.SIGINT, signal.default_int_handler)

# what is loaded for the tests stays to the end: nothing looks through it for what can go
gc.disable()


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop() -> None:
    gc.freeze()
    gc.enable()
