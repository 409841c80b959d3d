"""What is shown of a target on its way."""

import types

from cases import documents

from flexmb.workbench import session


def test_designs_are_shown_no_faster_than_the_pace(monkeypatch):
    clock, told, written = [10.0], [], []
    monkeypatch.setattr(session, "time", types.SimpleNamespace(monotonic=lambda: clock[0]))
    job = types.SimpleNamespace(stopped=False, tell=lambda **changes: told.append(changes))
    document = documents.drawn(2, {"t": "1e-3"}, [])
    shown = session.VisibleJob(job, document, lambda ops: written.append(ops[0]["to"]["value"]))  # type: ignore
    for after, value in ((0.0, 2e-3), (session.PACE / 2, 3e-3), (session.PACE, 4e-3)):
        clock[0] = 10.0 + after * 1.01
        shown.tell(design={"t": value})
    # The job is told all of them.
    assert [one["design"]["t"] for one in told] == [2e-3, 3e-3, 4e-3]
    assert [float(text) for text in written] == [2e-3, 4e-3]
