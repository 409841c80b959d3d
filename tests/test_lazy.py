"""How names are loaded, and how a process ends."""

import gc
import sys

import jax
import pytest

from flexmb.lazy import end_quickly


@pytest.mark.parametrize(("device", "given_back"), [("cpu", False), ("gpu", True)])
def test_programs_on_processors_are_not_given_back_one_by_one_at_the_end(monkeypatch, device, given_back):
    jax.device_put(0.0)
    left = []
    monkeypatch.setattr("atexit.unregister", left.append)
    monkeypatch.setattr(gc, "freeze", lambda: None)
    monkeypatch.setattr(jax, "default_backend", lambda: device)
    end_quickly()
    # What JAX has registered; elsewhere under another name, and then left to it.
    assert left == ([] if given_back else [sys.modules["jax._src.api"].clean_up])
