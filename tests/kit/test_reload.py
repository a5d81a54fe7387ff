"""kit.py server N --reload: when a file counts as saved. A whole run is in test_kit.py."""

from __future__ import annotations

from types import SimpleNamespace

from kitlib import reload


def test_an_editor_that_writes_in_steps_starts_it_once(tmp_path, monkeypatch):
    path, other = tmp_path / "server.py", tmp_path / "4913.py"
    path.write_text("1")
    steps = [
        lambda: None,
        # One that comes and goes is no save.
        lambda: other.write_text("x"),
        other.unlink,
        lambda: None,
        lambda: path.write_text(""),
        lambda: path.write_text("whole"),
        lambda: path.rename(other),
        lambda: other.rename(path),
        lambda: None,
        lambda: None,
    ]
    monkeypatch.setattr(reload, "time", SimpleNamespace(sleep=lambda _: steps.pop(0)()))
    running = SimpleNamespace(poll=lambda: None)
    assert reload.wait_for_save([tmp_path], reload.files([tmp_path]), running) == ["server.py"]
    assert len(steps) == 1, "as soon as it is whole"
