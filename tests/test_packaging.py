"""What is installed from an index: metadata, versions that agree, and a wheel that works without this repository."""

import datetime
import importlib.machinery
import importlib.util
import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

import flexmb as fm

ROOT = Path(__file__).parent.parent


def run(*words, **options):
    done = subprocess.run(words, capture_output=True, text=True, timeout=240, check=False, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def release():
    """The program that makes a release, as a module."""
    loader = importlib.machinery.SourceFileLoader("release", str(ROOT / ".ci/release"))
    spec = importlib.util.spec_from_loader("release", loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


def versions(folder):
    """The version by the file that states it."""
    lines = (folder / "CITATION.cff").read_text().splitlines() + (
        folder / "flexmb/__init__.py"
    ).read_text().splitlines()
    stated = [line.split(maxsplit=1)[1] for line in lines if line.startswith("version: ")]
    stated += [line.split('"')[1] for line in lines if line.startswith("__version__ = ")]
    return [tomllib.loads((folder / "pyproject.toml").read_text())["project"]["version"], *stated]


def test_versions_agree_before_and_after_a_release(tmp_path, monkeypatch):
    assert versions(ROOT) == [fm.__version__] * 3
    for name in ("pyproject.toml", "CITATION.cff", "CHANGELOG.md", "flexmb/__init__.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    program = release()
    monkeypatch.setattr(program, "ROOT", tmp_path)
    program.bump("0.2.0rc1", datetime.date(2030, 1, 2))
    assert versions(tmp_path) == ["0.2.0rc1"] * 3
    assert "## [Unreleased]\n\n## [0.2.0rc1] - 2030-01-02\n\n" in (tmp_path / "CHANGELOG.md").read_text()
    (tmp_path / "CITATION.cff").write_text("")
    with pytest.raises(SystemExit, match=r"CITATION\.cff has 0 places"):
        program.bump("0.3.0", datetime.date(2030, 1, 2))


def test_metadata_is_valid():
    run(sys.executable, "-m", "validate_pyproject", str(ROOT / "pyproject.toml"))


@pytest.mark.slow
def test_a_wheel_works_without_the_repository(tmp_path):
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", str(tmp_path / "dist"), str(ROOT))
    (wheel,), (archive,) = (list((tmp_path / "dist").glob(ending)) for ending in ("*.whl", "*.tar.gz"))
    run(sys.executable, "-m", "twine", "check", "--strict", str(wheel), str(archive))
    names = zipfile.ZipFile(wheel).namelist()
    assert "flexmb/py.typed" in names
    assert "flexmb/viewer/viewer.js" in names
    assert {name.split("/")[0] for name in names} == {"flexmb", f"flexmb-{fm.__version__}.dist-info"}
    with tarfile.open(archive) as packed:
        inside = {name.split("/")[1] for name in packed.getnames()}
    assert not inside & {"tests", "benchmarks", "notebooks", ".ci"}
    assert {"flexmb", "README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md"} <= inside
    for number, packed in enumerate((wheel, archive)):
        target = tmp_path / str(number)
        run(
            *(sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"),
            *("--target", str(target), str(packed)),
        )
        environment = {**os.environ, "PYTHONPATH": str(target)}
        places = run(sys.executable, "-c", "import flexmb; print(flexmb.__file__)", cwd=tmp_path, env=environment)
        assert Path(places.strip()).is_relative_to(target)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "0")}
    said = run(sys.executable, "-m", "flexmb", "demo", cwd=tmp_path, env=environment)
    assert "Hz" in said
