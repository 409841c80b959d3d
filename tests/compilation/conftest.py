"""What the tests of compiled code share."""

import jax
import pytest

from flexmb.compilation import programs


@pytest.fixture
def compilations():
    """Names of the programs that are compiled, or read from disk."""
    count, own, found = [], set(), programs.Programs._program

    def program(self, leaves):
        count.append(self._by_jax.__name__)
        own.add(f"jit({self._by_jax.__name__})")
        return found(self, leaves)

    def listen(event: str, duration_secs: float, **kwargs: str | int) -> None:
        name = str(kwargs.get("fun_name"))
        # Those of functions of the package are counted above.
        if event == "/jax/core/compile/backend_compile_duration" and name.replace(".kept)", ")") not in own:
            count.append(name)

    jax.monitoring.register_event_duration_secs_listener(listen)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(programs.Programs, "_program", program)
        yield count
    jax.monitoring.unregister_event_duration_listener(listen)
