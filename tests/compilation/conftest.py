"""What the tests of compiled code share."""

import jax
import pytest


@pytest.fixture
def compilations():
    """Names of the programs handed to the compiler, cached on disk or not."""
    count = []

    def listen(event: str, duration_secs: float, **kwargs: str | int) -> None:
        if event == "/jax/core/compile/backend_compile_duration":
            count.append(str(kwargs.get("fun_name")))

    jax.monitoring.register_event_duration_secs_listener(listen)
    yield count
    jax.monitoring.unregister_event_duration_listener(listen)
