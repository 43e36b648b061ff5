# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""How Sphinx makes the manual from the pages of this repository: `make docs`. Its source folder is the top of the repository."""
import os
import re
from pathlib import Path

from pygments.lexer import RegexLexer
from pygments.lexers.shell import BashLexer
from pygments.token import Comment, Keyword, Name, Number, Punctuation, Text

ROOT = Path(__file__).resolve().parents[2]
found = re.search(r'^version: *"?([^"\n]+)', (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
if not found:
    raise ValueError("CITATION.cff has no version")

project = "USER-MPDEM"
author = "The USER-MPDEM developers"
project_copyright = author
release = found[1]
extensions = ["myst_parser"]
root_doc = "doc/manual/contents"
include_patterns = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "doc/*.md", "doc/manual/contents.rst", "patches/README.md", "tests/mutation/README.md"]
myst_heading_anchors = 5  # links to headings use the names that GitHub gives them
html_theme = "furo"
html_title = f"{project} {release}"
html_show_sourcelink = False
html_copy_source = False
html_extra_path = ["front"]
latex_engine = "xelatex"
latex_documents = [(root_doc, "user-mpdem.tex", f"{project} {release}", author, "manual")]


class ScriptLexer(RegexLexer):
    """Input scripts of LIGGGHTS."""

    name = "LIGGGHTS"
    aliases = ["liggghts"]
    tokens = {
        "root": [
            (r"[ \t]+", Text),
            (r"#.*", Comment),
            (r"(\w[\w/]*)", Keyword, "words"),
            (r"\n", Text),
            (r".", Text),
        ],
        "words": [
            (r"&[ \t]*\n", Punctuation),
            (r"\n", Text, "#pop"),
            (r"#.*", Comment),
            (r"\$\{\w+\}|\$\([^)\n]*\)|\$\w", Name.Variable),
            (r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?(?![\w/.])", Number),
            (r"[^\s#&$]+|.", Text),
        ],
    }


def pages():
    """All pages of the manual."""
    return [ROOT / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "patches/README.md")] + sorted((ROOT / "doc").glob("*.md"))


def languages():
    """Languages of the blocks of code; the tests tell fragments, templates and whole scripts apart by them."""
    return {language for page in pages() for language in re.findall(r"^```([\w-]+)", page.read_text(encoding="utf-8"), re.MULTILINE)}


ANCHOR = re.compile(r'^<a id="([\w-]+)"></a>', re.MULTILINE)
LINK = re.compile(r"\]\(([^()\s#]*)#([\w-]+)\)")


def label_of(page, name):
    """Label of an anchor of a page, a path from the top of the repository."""
    return f"{page.removesuffix('.md').replace('/', '-')}-{name}"


def anchors():
    """Names of the anchors that pages set themselves, by page."""
    return {str(page.relative_to(ROOT)): set(ANCHOR.findall(page.read_text(encoding="utf-8"))) for page in pages()}


def for_myst(known, page, text):
    """Text of a page with its anchors, and links to such anchors, as MyST writes them."""

    def link(match):
        to = os.path.normpath(os.path.join(os.path.dirname(page), match[1])) if match[1] else page
        return f"]({label_of(to, match[2])})" if match[2] in known.get(to, ()) else match[0]

    return ANCHOR.sub(lambda m: f"({label_of(page, m[1])})=\n", LINK.sub(link, text))


def setup(app):
    known = anchors()
    app.connect("source-read", lambda _app, name, source: source.__setitem__(0, for_myst(known, f"{name}.md", source[0])))
    app.add_lexer("liggghts", ScriptLexer)
    for language in languages():
        if language.startswith("liggghts-"):
            app.add_lexer(language, ScriptLexer)
        if language.startswith("sh-"):
            app.add_lexer(language, BashLexer)
