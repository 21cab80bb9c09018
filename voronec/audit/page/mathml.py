"""LaTeX mathematics as MathML, by math-core: typeset formulas that need no network, no script."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape
from importlib.util import find_spec

from voronec.audit.page.marks import LINE_END, in_environment, mark, size_brackets
from voronec.audit.page.phrases import typeset_words
from voronec.errors import DefinitionError

_LABEL = re.compile(r"\\(?:label|tag)\s*\{[^}]*\}|\\(?:nonumber|notag)(?![a-zA-Z])")
_OUTER = re.compile(r"\s*(?:\$\$(.*)\$\$|\$(.*)\$|\\\[(.*)\\\]|\\\((.*)\\\))\s*", re.DOTALL)
_EQNARRAY = re.compile(r"\\(begin|end)\s*\{eqnarray\*?\}")
_UNKNOWN = re.compile(r'Unknown command "\\([a-zA-Z]+)"')
_PRIMES = re.compile("<mo>([\N{PRIME}\N{DOUBLE PRIME}\N{TRIPLE PRIME}]+)</mo>")
"""Superscripts that most fonts print too small; the style says how."""
_MACROS = {
    "marked": r"\textcolor{Melon}{#1}",
    "mbox": r"\text{#1}",
    "hbox": r"\text{#1}",
    "textrm": r"\text{#1}",
}
_MARK_STYLE = 'style="color:#FF9D7B;"'
"""How the colour of marks comes out; a class stands in its place."""


def mathml(
    latex: str, marks: Sequence[tuple[int, int]] = (), style: str = "changed", inline: bool = False
) -> str:
    """A formula, or a display with its delimiters, as ``<math>`` elements in one ``<div>``.

    A browser may end a line between two of them; a formula ``inline`` is one without the ``<div>``.
    Characters of ``latex`` in ``marks`` get the class ``style``.  What is no formula is shown as
    its source.
    """
    try:
        whole = mark(size_brackets(latex), marks, "marked", lines=not inline)
        pieces = re.split(rf"\s*{LINE_END}", _inner(whole))
        elements = [convert(("{}" if n else "") + piece)[0] for n, piece in enumerate(pieces)]
    except DefinitionError:
        return f'<code class="latex">{escape(latex)}</code>'
    elements = [one.replace(_MARK_STYLE, f'class="{style}"') for one in elements]
    if inline:
        return elements[0].replace(' displaystyle="true"', "", 1)
    return f'<div class="math">{"<wbr/>".join(elements)}</div>'


def prose(text: str) -> str:
    """Words with formulas between dollar signs, as HTML."""
    return typeset_words(text, escape, lambda formula: mathml(formula, inline=True))


def convert(latex: str, unknown: tuple[str, ...] = ()) -> tuple[str, tuple[str, ...]]:
    r"""A formula as one ``<math>`` element, and the names of commands, such as ``\diag`` of a
    paper's own, that are shown as the names of functions.  Where math-core is not installed the
    formula is shown as its source.

    Raises:
        DefinitionError: braces, environments or ``\left`` and ``\right`` do not match.
    """
    if find_spec("math_core") is None:
        return f'<code class="latex">{escape(latex)}</code>', ()
    from math_core import LatexError, LatexToMathML

    functions = {name: rf"\operatorname{{{name}}}" for name in unknown}
    converter = LatexToMathML(
        macros=_MACROS | functions, fancy_error=False, allow_unreliable_rendering=True
    )
    try:
        markup = converter.convert_with_local_state(_for_library(latex), displaystyle=True)
    except LatexError as error:
        named = _UNKNOWN.search(str(error))
        if named and named[1] not in unknown:
            return convert(latex, (*unknown, named[1]))
        raise DefinitionError(f"the formula '{latex[:40]}' is not typeset: {error}") from None
    markup = markup.replace('display="block"', 'displaystyle="true"', 1)
    markup = _PRIMES.sub(r'<mo class="prime">\1</mo>', markup)
    return markup.replace("&ApplyFunction;", "&#x2061;"), unknown


def _for_library(latex: str) -> str:
    """A formula without labels, its lines in an environment, and no formulas within text."""
    text = _EQNARRAY.sub(_as_array, _LABEL.sub("", _inner(latex)))
    return in_environment(re.sub(r"\$([^$]*)\$", r"}\1\\text{", text))


def _as_array(edge: re.Match[str]) -> str:
    return r"\begin{array}{rcl}" if edge[1] == "begin" else r"\end{array}"


def _inner(latex: str) -> str:
    """A formula without the delimiters of a display."""
    outer = _OUTER.fullmatch(latex)
    return latex if outer is None else outer[outer.lastindex or 0]
