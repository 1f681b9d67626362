"""Figures are drawn without a screen, and closed after each test; interrupts reach the tests."""

import signal

import matplotlib
import matplotlib.pyplot as plt
import pytest

matplotlib.use("Agg")
# A shell may start a program in the background with interrupts ignored, and then no test of Ctrl-C would end.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")
