# SPDX-License-Identifier: GPL-2.0-or-later
"""The manual is made of all pages without a warning, and what a browser loads with it is beside it."""
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CONTENTS = "doc/manual/contents"


@pytest.fixture(scope="module")
def manual(tmp_path_factory):
    out = tmp_path_factory.mktemp("manual")
    done = subprocess.run(
        ["/usr/bin/sphinx-build", "-W", "--keep-going", "-q", "-b", "html", "-c", "doc/manual", ".", str(out)], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return out


def pages():
    return [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "patches/README.md")] + sorted((ROOT / "doc").glob("*.md"))


def test_every_page_is_in_the_contents(manual):
    contents = manual / f"{CONTENTS}.html"
    listed = {(contents.parent / link).resolve() for link in re.findall(r'href="([^"#]+)"', contents.read_text(encoding="utf-8"))}
    assert not [page.name for page in pages() if (manual / page.relative_to(ROOT)).with_suffix(".html") not in listed]


def test_nothing_is_loaded_from_a_network(manual):
    loads = re.compile(r'<(?:script|img|iframe)[^>]*\bsrc="(https?:)?//|<link[^>]*rel="(?:stylesheet|preload)"[^>]*href="(https?:)?//')
    assert not [page for page in manual.rglob("*.html") if loads.search(page.read_text(encoding="utf-8"))]


def test_search_finds_the_commands(manual):
    index = (manual / "searchindex.js").read_text(encoding="utf-8")
    for page in ("fix_mpm", "create_cement", "bond_stiffness"):
        assert f'"doc/{page}"' in index


def test_links_lead_somewhere(manual):
    """Links to other pages and to places in them, as they stand in the HTML."""
    lost = []
    ids = {}

    def ids_of(page):
        if page not in ids:
            ids[page] = set(re.findall(r'\bid="([^"]+)"', page.read_text(encoding="utf-8")))
        return ids[page]

    for page in manual.rglob("*.html"):
        for link in re.findall(r'<a class="reference internal[^"]*" href="([^"]+)"', page.read_text(encoding="utf-8")):
            path, _, place = link.partition("#")
            to = (page.parent / path).resolve() if path else page
            if not to.is_file() or (place and to.suffix == ".html" and place not in ids_of(to)):
                lost.append(f"{page.name}: {link}")
    assert not lost
