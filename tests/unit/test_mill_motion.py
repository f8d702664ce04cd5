"""Motions against the thesis's equations."""

import numpy as np
import pytest

from millprint.config.included import load_mill
from millprint.mill.motion import motion_from_law

TIME = np.linspace(0, 0.4, 201)


def motion(name: str, speed: float = 300):
    return motion_from_law(load_mill(name).motion, speed / 60)


def test_circle():
    w = 2 * np.pi * 10
    expected = 0.017 * np.column_stack([np.cos(w * TIME), np.sin(w * TIME), 0 * TIME])
    assert motion("emax", 600).position(TIME) == pytest.approx(expected, abs=1e-15)


def test_motion_1_is_equation_6_34():
    a, b = 10 * np.pi * TIME, 20 * np.pi * TIME
    x, z = 1.7 * np.sin(a) - 0.85 * np.cos(b), 1.7 * np.cos(a) - 0.85 * np.sin(b)
    assert motion("emax_motion1").position(TIME) == pytest.approx(np.column_stack([x, z, 0 * x]) / 100, abs=1e-15)


def test_motion_2_is_equation_6_35():
    x, z = 1.7 * np.sin(10 * np.pi * TIME), 1.7 * np.cos(20 * np.pi * TIME)
    assert motion("emax_motion2").position(TIME) == pytest.approx(np.column_stack([x, z, 0 * x]) / 100, abs=1e-15)
