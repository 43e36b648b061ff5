# SPDX-License-Identifier: GPL-2.0-or-later
"""The manual is made of all pages without a warning, and what a browser loads with it is beside it."""
import importlib.util
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


def test_formulas_are_drawn_by_what_is_beside_the_pages(manual):
    """MathJax is in the folder, as files and not as links, so that the folder can be moved; pages with formulas load it."""
    drawn = [page for page in manual.rglob("*.html") if 'class="math ' in page.read_text(encoding="utf-8")]
    assert len(drawn) > 12
    for page in drawn:
        (script,) = re.findall(r'<script [^>]*src="([^"]*MathJax[^"]*)"', page.read_text(encoding="utf-8"))
        file, _, config = script.partition("?config=")
        mathjax = (page.parent / file).resolve().parent
        assert mathjax == manual / "_static" / "mathjax" and (mathjax / "MathJax.js").is_file() and (mathjax / "config" / f"{config}.js").is_file()
    assert list((manual / "_static/mathjax/jax/output/SVG/fonts/TeX").rglob("Main.js")), "the font"
    assert not [path for path in manual.rglob("*") if path.is_symlink()]
    assert sum(path.stat().st_size for path in manual.rglob("*") if path.is_file()) < 40e6


def test_no_formula_is_left_as_text(manual):
    """A $ outside of code is a formula that MyST did not read."""
    left = []
    for page in manual.rglob("*.html"):
        text = re.sub(
            r"<pre>.*?</pre>|<code.*?</code>|<script.*?</script>|<(span|div) class=\"math [^>]*>.*?</\1>", "", page.read_text(encoding="utf-8"), flags=re.S
        )
        left += [(page.name, found) for found in re.findall(r".{20}\$.{20}", text)]
    assert not left


def test_scripts_of_the_theme_run_in_a_browser(manual):
    """Debian's Furo has a script that imports another, which a browser refuses in a page; the choice of dark or light needs it."""
    script = (manual / "_static/scripts/furo.js").read_text(encoding="utf-8")
    assert "root.Gumshoe = factory(root)" in script and not re.search(r"^import ", script, re.M)
    assert "prefers-color-scheme: dark" in (manual / "_static/manual.css").read_text(encoding="utf-8")


def test_captions_of_the_contents_are_parts_on_paper():
    """Each caption of the contents begins a part at the chapter of its first page; a chapter that is missing stops."""
    spec = importlib.util.spec_from_file_location("manual_conf", ROOT / "doc/manual/conf.py")
    conf = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(conf)
    contents = (ROOT / f"{CONTENTS}.rst").read_text(encoding="utf-8")
    captions = re.findall(r":caption: (.*)", contents)
    pages = [page for block in contents.split(".. toctree::")[1:] for page in re.findall(r"^   (?:.*<)?/([\w/]+)>?$", block, re.MULTILINE)]
    tex = "".join(f"\n\\chapter{{{page}}}\n\\label{{\\detokenize{{{page}::doc}}}}\ntext\n" for page in pages)
    lines = conf.with_parts(tex, contents).splitlines()
    parts = [n for n, line in enumerate(lines) if line.startswith("\\part")]
    assert [lines[n] for n in parts] == [f"\\part{{{caption}}}" for caption in captions] and len(parts) > 5
    firsts = [re.search(r"/([\w/]+)>?\n", block)[1] for block in contents.split(":caption: ")[1:]]
    assert [lines[n + 1] for n in parts] == [f"\\chapter{{{page}}}" for page in firsts]
    with pytest.raises(conf.ExtensionError):
        conf.with_parts(tex.replace("theory", "other"), contents)
