"""The server of the workbench: who is let in, what a message may be, several pages, and its end."""

import hashlib
from pathlib import Path

import flexmb as fm

PACKAGE = Path(fm.__file__).parent


def test_bundle_is_built_from_the_source():
    text = (PACKAGE / "workbench" / "workbench.js").read_text()
    source = PACKAGE / "viewer" / "src"
    parts = [*sorted(source.glob("*.js")), *sorted((source / "workbench").glob("*.js"))]
    total = hashlib.sha256(b"".join(path.read_bytes() for path in parts)).hexdigest()
    assert text.startswith(f"/* source {total}\n"), "run npm ci && npm run build in flexmb/viewer/src"
