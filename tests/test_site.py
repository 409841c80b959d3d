"""The documentation site: one command builds it without a warning, its links lead somewhere, it needs no network."""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from flexmb import blocks

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.slow
pytest.importorskip("zensical", reason="the extra `docs` is not installed")


class Links(HTMLParser):
    """Anchors of a page, its links, and the files that it loads."""

    def __init__(self, page):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.anchors |= {found.get("id"), found.get("name")} - {None}
        if tag in ("script", "img", "iframe", "source", "video"):
            self.loaded += [found["src"]] if found.get("src") else []
        elif tag == "link" and found.get("rel") in ("stylesheet", "icon", "preload", "modulepreload"):
            self.loaded.append(found["href"])
        elif tag == "a" and found.get("href"):
            self.links.append(found["href"])


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site") / "built"
    command = [sys.executable, ROOT / "notebooks/site/build.py", folder]
    done = subprocess.run(command, cwd=folder.parent, capture_output=True, text=True)
    text = done.stdout + done.stderr
    assert done.returncode == 0, text
    assert not re.search("warning", text, re.IGNORECASE), text
    return {page: Links(page) for page in folder.rglob("*.html") if "gallery" not in page.parent.name}, folder


def test_links_lead_somewhere(site):
    pages, folder = site
    assert len(pages) > 40
    wrong = []
    for page, found in pages.items():
        for link in [*found.links, *found.loaded]:
            parts = urlsplit(link)
            if parts.scheme:
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            if target.is_dir():
                target /= "index.html"
            # The page of a missing file is found from anywhere, by the address of a server.
            if page.name == "404.html" or not target.exists():
                wrong += [] if page.name == "404.html" else [f"{page.relative_to(folder)}: {link}"]
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
                wrong.append(f"{page.relative_to(folder)}: {link}")
    assert not wrong, "\n".join(wrong)


def test_no_other_host_is_asked(site):
    """Pages load files of the site alone; links to other hosts are for readers to follow."""
    asked = {link for found in site[0].values() for link in found.loaded if urlsplit(link).scheme not in ("", "data")}
    assert not asked
    styles = "".join(path.read_text(encoding="utf-8") for path in site[1].rglob("*.css"))
    assert not re.search(r"(?:@import|url\()\s*['\"]?https?:", styles)


def test_reference_has_arguments_and_errors(site):
    page = (site[1] / "api/flexmb.html").read_text(encoding="utf-8")
    for name in ("frequencies", "equilibrium", "Builder", "simulate"):
        assert re.search(rf'id="flexmb\.[\w.]+\.{name}"', page), name
    assert "Raises" in page
    # Methods of results, and sections of a module.
    for page, name in (
        ("fm_identification", "Fit.next_measurement"),
        ("flexmb_paths", "Path.along"),
        ("flexmb_statics", "Equilibrium.position"),
        ("fm_sections", "General"),
    ):
        text = (site[1] / f"api/{page}.html").read_text(encoding="utf-8")
        assert re.search(rf'id="flexmb\.[\w.]+\.{re.escape(name)}"', text), name


def test_pages_show_code_and_names_as_written(site):
    for page in site[0]:
        text = page.read_text(encoding="utf-8")
        # Outside code blocks, whose colours split the text.
        prose = re.sub(r"<(pre|script)\b.*?</\1>", "", text, flags=re.DOTALL)
        assert "```" not in prose, page
        assert not re.search(r":(?:func|class|meth|mod):", prose), page
        # Equations in TeX.
        assert "$$" not in prose, page
        assert not re.search(r"\\(?:frac|sqrt|mathrm|\()", prose), page
    assert "<mfrac>" in (site[1] / "notebooks" / "01_build_guide.html").read_text(encoding="utf-8")
    assert "&lt;name&gt; middle" in (site[1] / "api/fm_blocks.html").read_text(encoding="utf-8")


def test_every_block_is_in_the_gallery(site):
    page = (site[1] / "gallery.html").read_text(encoding="utf-8")
    for name in dir(blocks):
        assert f"gallery/{name}.png" in page
        assert (site[1] / f"gallery/{name}.png").stat().st_size > 3000
    assert page.count("<iframe") == 3
    for source in (ROOT / "notebooks").glob("[0-9][0-9]_*.ipynb"):
        assert f"notebooks/{source.stem}.html" in page
    # A picture links to its code.
    blocks_page = (site[1] / "api/fm_blocks.html").read_text(encoding="utf-8")
    assert blocks_page.count("Source code") >= len(dir(blocks))
