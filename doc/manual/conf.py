# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""How Sphinx makes the manual from the pages of this repository: `make docs`. Its source folder is the top of the repository."""
import os
import re
import shutil
import subprocess
from pathlib import Path

from docutils import nodes
from pygments.lexer import RegexLexer
from pygments.lexers.shell import BashLexer
from pygments.token import Comment, Keyword, Name, Number, Punctuation, Text
from sphinx.errors import ExtensionError

ROOT = Path(__file__).resolve().parents[2]
found = re.search(r'^version: *"?([^"\n]+)', (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
if not found:
    raise ValueError("CITATION.cff has no version")

project = "USER-MPDEM"
author = "The USER-MPDEM developers"
project_copyright = author
release = found[1]
extensions = ["myst_parser", "sphinx.ext.mathjax"]
root_doc = "doc/manual/contents"
include_patterns = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "doc/*.md", "doc/manual/contents.rst", "patches/README.md", "tests/mutation/README.md"]
myst_heading_anchors = 5  # links to headings use the names that GitHub gives them
myst_enable_extensions = ["dollarmath"]  # $...$ and $$...$$, by the rules of GitHub
myst_dmath_allow_space = False
myst_update_mathjax = False
html_theme = "furo"
html_title = f"{project} {release}"
html_show_sourcelink = False
html_copy_source = False
html_extra_path = ["front"]
html_static_path = ["static"]
html_css_files = ["manual.css"]
# MathJax of Debian draws formulas as SVG: no fonts are loaded, so a browser shows them from a folder, too.
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_SVG"
mathjax2_config = {
    "messageStyle": "none",
    "menuSettings": {"zoom": "None"},
    "tex2jax": {"ignoreClass": ".*", "processClass": "math"},
    "SVG": {"font": "TeX", "scale": 92, "linebreaks": {"automatic": False}},
}
latex_engine = "xelatex"
latex_documents = [(root_doc, "user-mpdem.tex", project, author, "manual")]


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
MOVING = re.compile(r"!\[([^\]]*)\]\([^)]*\.gif\)")
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


MATHJAX = Path("/usr/share/javascript/mathjax")
# What a page with formulas may ask for; the rest of the package is other fonts, inputs and languages.
PARTS = ["MathJax.js", "config/TeX-AMS_SVG.js", "extensions", "jax/element", "jax/input/TeX", "jax/output/SVG", "localization/en"]
LEFT_OUT = ["Asana-Math", "Gyre-*", "Latin-Modern", "Neo-Euler", "STIX-Web"]


def copy_mathjax(app, exception):
    """Puts MathJax beside the pages, so that the folder of the manual can be moved and read without a network."""
    if exception or app.builder.format != "html":
        return
    if not (MATHJAX / "MathJax.js").is_file():
        raise ExtensionError(f"{MATHJAX} has no MathJax.js: install Debian's package libjs-mathjax")
    for name in PARTS:
        source, to = MATHJAX / name, Path(app.outdir) / "_static" / "mathjax" / name
        to.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            shutil.copytree(source, to, ignore=shutil.ignore_patterns(*LEFT_OUT), dirs_exist_ok=True)
        else:
            shutil.copy2(source, to)
    shutil.copy2("/usr/share/doc/libjs-mathjax/copyright", Path(app.outdir) / "_static" / "mathjax" / "copyright")


def join_scripts(app, exception):
    """Debian's Furo imports one script in another, which browsers refuse: without this there is no choice of dark or light."""
    folder = Path(app.outdir) / "_static" / "scripts"
    if exception or app.builder.format != "html" or not (folder / "gumshoe-patched.js").is_file():
        return
    furo = (folder / "furo.js").read_text(encoding="utf-8")
    first, _, rest = furo.partition("\n")
    if first.startswith("import Gumshoe"):
        (folder / "furo.js").write_text((folder / "gumshoe-patched.js").read_text(encoding="utf-8") + "(function () {\n" + rest + "})();\n", encoding="utf-8")


def wrap_long_tables(app, doctree, _name):
    """In LaTeX tables of many rows must be able to go over pages, and then need widths of their columns: of the longest word, and what a line has left."""
    if app.builder.format != "latex":
        return
    for table in doctree.findall(nodes.table):
        rows = [[entry.astext() for entry in row.findall(nodes.entry)] for row in table.findall(nodes.row)]
        columns = list(table.findall(nodes.colspec))
        if len(rows) <= 12 or any(len(row) != len(columns) for row in rows):
            continue
        words = [max(len(word) for text in texts for word in text.split() or [""]) for texts in zip(*rows)]
        mean = [sum(map(len, texts)) / len(texts) for texts in zip(*rows)]
        left = max(0, 95 - sum(min(word, 24) + 4 for word in words))  # of some 95 letters a line
        for column, word, length in zip(columns, words, mean):
            column["colwidth"] = round(min(word, 24) + 4 + left * length / sum(mean))
        table["classes"] += ["colwidths-given", "longtable"]


CAPTION = re.compile(r"^   :caption: (.*)\n(?:   :.*\n)*\n   (?:[^<\n]*<)?/([^>\n]+)", re.MULTILINE)


def with_parts(text, contents):
    """LaTeX of the manual in which each caption of the contents is a part, from the chapter of its first page on. Sphinx drops captions there."""
    for caption, page in CAPTION.findall(contents):
        at = text.find(rf"\label{{\detokenize{{{page}::doc}}}}")
        chapter = text.rfind("\n\\chapter{", 0, at)
        if at < 0 or chapter < 0:
            raise ExtensionError(f"the LaTeX manual has no chapter for {page}, the first page below '{caption}' of contents.rst")
        text = f"{text[:chapter]}\n\\part{{{caption}}}{text[chapter:]}"
    return text


def for_paper(app, exception):
    """Captions of the contents become parts. LaTeX reads no SVG: drawings become PDF."""
    if exception or app.builder.format != "latex":
        return
    tex = Path(app.outdir) / "user-mpdem.tex"
    text = with_parts(tex.read_text(encoding="utf-8"), (ROOT / "doc/manual/contents.rst").read_text(encoding="utf-8"))
    for drawing in sorted(Path(app.outdir).glob("*.svg")):
        subprocess.run(["rsvg-convert", "--format=pdf", f"--output={drawing.with_suffix('.pdf')}", drawing], check=True)
        text = text.replace(f"{{{{{drawing.stem}}}.svg}}", f"{{{{{drawing.stem}}}.pdf}}")
    tex.write_text(text, encoding="utf-8")


def setup(app):
    known = anchors()

    def read(app, name, source):
        text = for_myst(known, f"{name}.md", source[0])
        # Paper shows no film, and LaTeX cannot read its file.
        source[0] = MOVING.sub(r"*(A film in the HTML manual: \1)*", text) if app.builder.format == "latex" else text

    app.connect("source-read", read)
    app.connect("build-finished", copy_mathjax)
    app.connect("build-finished", join_scripts)
    app.connect("doctree-resolved", wrap_long_tables)
    app.connect("build-finished", for_paper)
    app.add_lexer("liggghts", ScriptLexer)
    for language in languages():
        if language.startswith("liggghts-"):
            app.add_lexer(language, ScriptLexer)
        if language.startswith("sh-"):
            app.add_lexer(language, BashLexer)
