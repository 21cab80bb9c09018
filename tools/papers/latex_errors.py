r"""The errors that a typesetter or an author makes in a formula, made on its LaTeX one at a time.

Nothing here knows what a formula says, or how an audit reads it: words are exchanged, left out and
doubled where the signs of LaTeX allow it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise


@dataclass(frozen=True)
class Slip:
    """One error: its kind, and the LaTeX with it; ``at`` is where the characters differ first."""

    kind: str
    latex: str
    at: int


@dataclass(frozen=True)
class Word:
    """A command, a digit, a letter, a sign, or something that is no mathematics (``opaque``)."""

    text: str
    start: int
    end: int
    kind: str


@dataclass(frozen=True)
class Letter:
    """A letter with all that belongs to it: fonts and dots before it, primes and scripts behind.

    ``core`` is the letter alone, ``accents`` the commands before it, ``scripts`` the signs ``_``
    and ``^`` with the words of their groups, by positions among the words of the formula.
    """

    start: int
    end: int
    core: Word
    accents: tuple[Word, ...] = ()
    primes: tuple[Word, ...] = ()
    scripts: tuple[tuple[int, int], ...] = ()


_WORD = re.compile(
    r"(?P<opaque>\\(?:begin|end|label|text|mathrm|tag)\s*\{[^{}]*\}|\bconst\b|%[^\n]*|\\left|\\right"
    r"|\\[bB]ig+[lr]?|\\[,;:! ]|\\(?:limits|nonumber|overrightarrow))"
    r"|(?P<break>\\\\|&|\\q?quad)|(?P<command>\\(?:[a-zA-Z]+|.))|(?P<digit>\d)|(?P<letter>[a-zA-Z])"
    r"|(?P<sign>[^\s\w]|_)",
    re.DOTALL,
)
_DELIMITERS = re.compile(r"\\\[|\\\]|\$\$?")
_ACCENTS = frozenset(
    r"\dot \ddot \bar \tilde \hat \vec \mathbf \mathfrak \mathcal \mathbb \boldsymbol".split()
)
_FONTS = {"\\mathbf": "\\mathfrak ", "\\mathfrak": "\\mathbf "}
_GREEK = frozenset(
    r"\alpha \beta \gamma \delta \epsilon \zeta \theta \vartheta \kappa \lambda \mu \nu \pi \rho"
    r" \sigma \tau \phi \varphi \psi \omega \Gamma \Delta \Theta \Sigma \Phi \Omega \wp".split()
)
_RELATIONS = {"<": ">", ">": "<", "\\le": "\\ge", "\\ge": "\\le", "\\leq": "\\geq"} | {
    "\\geq": "\\leq",
    "\\ne": "=",
    "\\neq": "=",
}
_FUNCTIONS = {"\\sin": "\\cos", "\\cos": "\\sin", "\\tan": "\\cot", "\\cot": "\\tan"}
_PAIRS = (
    r"u v,v u,I 1,P p,p P,s S,X x,x X,\tau t,\nu v,\mu u,\omega w,n \eta,y x,i j,j i,\alpha a"
    r",a \alpha,q g,G C,C G,\gamma y,\Gamma T,k h,h k,r \tau,A \Lambda,E F,M N,K k,\rho p,b h"
)
_ALIKE = {pair.split()[0]: pair.split()[1] for pair in _PAIRS.split(",")}
"""Letters and what a typesetter takes for them."""
_OPENING = {"(": ")", "[": "]", "{": "}"}
_CLOSING = frozenset(_OPENING.values())
_ENDS = frozenset([",", ".", ";", "=", "<", ">", *_RELATIONS])
NEIGHBOURS = 2
"""How many of the other letters of a formula take the place of each one."""


@dataclass(frozen=True)
class Formula:
    """The LaTeX of a display or a formula of the text, with its delimiters, as words."""

    latex: str
    words: tuple[Word, ...] = field(init=False)

    def __post_init__(self) -> None:
        words = []
        hidden = [m.span() for m in _DELIMITERS.finditer(self.latex)]
        for match in _WORD.finditer(self.latex):
            start, end = match.span()
            if not any(a <= start < b for a, b in hidden):
                words.append(Word(match.group(), start, end, str(match.lastgroup)))
        object.__setattr__(self, "words", tuple(words))

    @cached_property
    def depths(self) -> tuple[int, ...]:
        """How many brackets are open at each word, the word's own not counted."""
        found, depth = [], 0
        for word in self.words:
            depth -= word.text in _CLOSING and depth > 0
            found.append(depth)
            depth += word.text in _OPENING
        return tuple(found)

    @cached_property
    def letters(self) -> tuple[Letter, ...]:
        """All letters that stand on the line, those in the groups of scripts too."""
        found, position = [], 0
        while position < len(self.words):
            letter, after = self._letter(position)
            if letter is not None:
                found.append(letter)
            position = after
        return tuple(found)

    @cached_property
    def in_scripts(self) -> frozenset[int]:
        """Positions of the words that stand in a script."""
        found: set[int] = set()
        for position, word in enumerate(self.words):
            if word.text in ("_", "^"):
                found |= set(range(position + 1, self.group_end(position + 1)))
        return frozenset(found)

    def group_end(self, position: int) -> int:
        """The position behind one argument of a command: a word, or a group in braces."""
        if position < len(self.words) and self.words[position].text in _ACCENTS:
            return self.group_end(position + 1)
        if position >= len(self.words) or self.words[position].text != "{":
            return min(position + 1, len(self.words))
        depth = self.depths[position]
        for i in range(position + 1, len(self.words)):
            if self.words[i].text == "}" and self.depths[i] == depth:
                return i + 1
        return len(self.words)

    def _letter(self, position: int) -> tuple[Letter | None, int]:
        """The letter that starts at a position, and where to look for the next one."""
        words, accents, at = self.words, list[Word](), position
        while at < len(words) and (words[at].text in _ACCENTS or (accents and _opens(words, at))):
            if words[at].text in _ACCENTS:
                accents.append(words[at])
            at += 1
        if at >= len(words) or not _is_letter(words[at]):
            return None, position + 1
        core, inner = words[at], at + 1
        while accents and inner < len(words) and words[inner].text == "}":
            if self.depths[inner] < self.depths[position]:
                break
            inner += 1
        primes, scripts, at = list[Word](), list[tuple[int, int]](), inner
        while at < len(words) and words[at].text in ("'", "_", "^"):
            end = at + 1 if words[at].text == "'" else self.group_end(at + 1)
            if words[at].text == "'":
                primes.append(words[at])
            else:
                scripts.append((at, end))
            at = end
        start, end = words[position].start, words[at - 1].end
        return Letter(start, end, core, tuple(accents), tuple(primes), tuple(scripts)), inner

    def cut(self, start: int, end: int, text: str, kind: str) -> Slip:
        """The slip that puts a text in the place of some characters."""
        before = self.latex[start - 1 : start]
        if re.search(r"\\[a-zA-Z]+$", self.latex[:start]) and text[:1].isalpha():
            text = " " + text
        if re.search(r"\\[a-zA-Z]+$", text) and self.latex[end : end + 1].isalpha():
            text += " "
        if not text and before.isalpha() and self.latex[end : end + 1].isalpha():
            text = " "
        return Slip(kind, self.latex[:start] + text + self.latex[end:], start)


def _is_letter(word: Word) -> bool:
    return word.kind == "letter" or word.text in _GREEK


def _opens(words: Sequence[Word], at: int) -> bool:
    """Whether a brace after an accent holds a letter, or a letter with a further accent."""
    after = words[at + 1] if at + 1 < len(words) else None
    return (
        words[at].text == "{"
        and after is not None
        and (after.text in _ACCENTS or _is_letter(after))
    )


def slips(latex: str) -> list[Slip]:
    """Every error, each once, in a fixed order."""
    formula = Formula(latex)
    seen = {_bare(latex)}
    found = []
    for made in _MAKERS:
        for slip in made(formula):
            if _bare(slip.latex) not in seen:
                seen.add(_bare(slip.latex))
                found.append(slip)
    return found


def _bare(latex: str) -> str:
    return re.sub(r"\s+|\\left(?![a-z])|\\right(?![a-z])", "", latex)


# -- words exchanged ------------------------------------------------------------------------------


def _signs(formula: Formula) -> Iterator[Slip]:
    words = formula.words
    for i, word in enumerate(words):
        if word.text in ("+", "-"):
            kind = "index" if i in formula.in_scripts else "sign"
            yield formula.cut(word.start, word.end, "-" if word.text == "+" else "+", kind)
        after = words[i + 1].text if i + 1 < len(words) else "0"
        if word.text == "=" and after not in ("+", "-", "0", "&") and i not in formula.in_scripts:
            yield formula.cut(word.end, word.end, "-", "sign")


def _relations(formula: Formula) -> Iterator[Slip]:
    for word in formula.words:
        if word.text in _RELATIONS:
            yield formula.cut(word.start, word.end, _RELATIONS[word.text], "inequality")


def _functions(formula: Formula) -> Iterator[Slip]:
    for word in formula.words:
        if word.text in _FUNCTIONS:
            yield formula.cut(word.start, word.end, _FUNCTIONS[word.text], "sin/cos")


def _numbers(formula: Formula) -> Iterator[Slip]:
    for i, word in enumerate(formula.words):
        if word.kind != "digit":
            continue
        power = i in formula.in_scripts and _script_sign(formula, i) == "^"
        kind = "exponent" if power else "index" if i in formula.in_scripts else "number"
        for other in (int(word.text) + 1, int(word.text) - 1):
            if 0 <= other <= 9:
                yield formula.cut(word.start, word.end, str(other), kind)


def _script_sign(formula: Formula, position: int) -> str:
    """The sign of the script in which a word stands."""
    while formula.words[position].text not in ("_", "^"):
        position -= 1
    return formula.words[position].text


def _names(formula: Formula) -> Iterator[Slip]:
    """A letter for one that looks like it, and for the next letters of the formula."""
    cores = list(dict.fromkeys(letter.core.text for letter in formula.letters))
    for letter in formula.letters:
        at = formula.words.index(letter.core)
        kind = "index" if at in formula.in_scripts else "letter"
        here = cores.index(letter.core.text)
        others = [cores[(here + step) % len(cores)] for step in range(1, NEIGHBOURS + 1)]
        for other in (_ALIKE.get(letter.core.text), *others):
            if other is not None and other != letter.core.text:
                yield formula.cut(letter.core.start, letter.core.end, other, kind)


def _swaps(formula: Formula) -> Iterator[Slip]:
    """Two letters that follow each other take each other's places."""
    for one, two in pairwise(formula.letters):
        a, b = one.core, two.core
        if a.text != b.text:
            second = formula.cut(b.start, b.end, a.text, "swapped letters")
            yield replace(formula, latex=second.latex).cut(a.start, a.end, b.text, second.kind)


# -- marks of a letter ----------------------------------------------------------------------------


def _marks(formula: Formula) -> Iterator[Slip]:
    r"""Primes and dots, one less and one more; more only on letters that bear one somewhere."""
    dotted = {x.core.text for x in formula.letters if any("dot" in a.text for a in x.accents)}
    primed = {x.core.text for x in formula.letters if x.primes}
    for letter in formula.letters:
        for prime in letter.primes:
            yield formula.cut(prime.start, prime.end, "", "prime")
        if letter.core.text in primed:
            yield formula.cut(letter.core.end, letter.core.end, "'", "prime")
        dots = [a for a in letter.accents if "dot" in a.text]
        for dot in dots:
            yield formula.cut(dot.start, dot.end, "", "dot")
        if letter.core.text in dotted and not dots:
            yield formula.cut(letter.start, letter.start, "\\dot ", "dot")


def _fonts(formula: Formula) -> Iterator[Slip]:
    for letter in formula.letters:
        for accent in letter.accents:
            if "dot" not in accent.text:
                yield formula.cut(accent.start, accent.end, "", "font")
                if accent.text in _FONTS:
                    yield formula.cut(accent.start, accent.end, _FONTS[accent.text], "font")


def _scripts(formula: Formula) -> Iterator[Slip]:
    """An index or an exponent left out; one put to a letter that bears it elsewhere."""
    words, bearing = formula.words, dict[str, str]()
    for letter in formula.letters:
        for at, end in letter.scripts:
            text = formula.latex[words[at].start : words[end - 1].end]
            kind = "exponent" if text.startswith("^") and text[-1].isdigit() else "index"
            yield formula.cut(words[at].start, words[end - 1].end, "", kind)
            if kind == "index":
                bearing.setdefault(letter.core.text, text)
    for i, letter in enumerate(formula.letters):
        if formula.words.index(letter.core) in formula.in_scripts or letter.scripts:
            continue
        if letter.core.text in bearing:
            yield formula.cut(letter.end, letter.end, bearing[letter.core.text], "index")
        if i % 2 == 0:
            yield formula.cut(letter.end, letter.end, "^2", "exponent")


# -- factors, terms, brackets ---------------------------------------------------------------------


def _factors(formula: Formula) -> Iterator[Slip]:
    """A letter left out or doubled where it is a factor, a factor 2 before it."""
    for letter in formula.letters:
        at = formula.words.index(letter.core)
        if at in formula.in_scripts:
            continue
        text = formula.latex[letter.start : letter.end]
        before = [w for w in formula.words if w.end <= letter.start][-1:]
        after = [w for w in formula.words if w.start >= letter.end][:1]
        leads = not before or _edge(before[0])
        if not (leads and (not after or _edge(after[0]))):
            yield formula.cut(letter.start, letter.end, "", "factor")
        yield formula.cut(letter.start, letter.start, text + " ", "factor")
        if leads or before[0].text in _FUNCTIONS:
            yield formula.cut(letter.start, letter.start, "2", "factor")
    for i, word in enumerate(formula.words):
        lone = word.kind == "digit" and i not in formula.in_scripts and word.text != "0"
        if lone and formula.words[i - 1].text not in ("\\frac", "{", "=", "("):
            yield formula.cut(word.start, word.end, "", "factor")
        if word.text == "\\sqrt":
            yield formula.cut(word.start, word.end, "", "factor")


def _edge(word: Word) -> bool:
    """Whether a factor cannot go on beyond a word."""
    signs = ("+", "-", *_OPENING, *_CLOSING)
    return word.text in signs or _parts(word) or word.kind == "opaque"


def _terms(formula: Formula) -> Iterator[Slip]:
    """A term left out, a term twice."""
    for start, end, alone in _stretches(formula):
        words = formula.words[start:end]
        a, b = words[0].start, words[-1].end
        signed = words[0].text in ("+", "-")
        text = formula.latex[a:b]
        if not alone:
            plus = formula.words[end] if end < len(formula.words) else None
            skip = not signed and plus is not None and plus.text == "+"
            yield formula.cut(a, plus.end if skip and plus is not None else b, "", "dropped term")
        yield formula.cut(b, b, text if signed else "+" + text, "doubled term")


def _stretches(formula: Formula) -> Iterator[tuple[int, int, bool]]:
    """From, to, and whether a term is the only one of its sum, outside scripts and accents."""
    stack: list[list[list[list[int]]]] = [[[]]]  # brackets, sums, terms, from and to
    sums: list[list[list[int]]] = []
    for i, word in enumerate(formula.words):
        if i in formula.in_scripts:
            continue
        level = stack[-1]
        if word.text in _CLOSING and len(stack) > 1:
            sums += stack.pop()
            stack[-1][-1][-1][1] = i + 1
            continue
        if _parts(word):
            level.append([])
            continue
        if not level[-1] or word.text in ("+", "-"):
            level[-1].append([i, i + 1])
        level[-1][-1][1] = i + 1
        if word.text in _OPENING:
            stack.append([[]])
    for several in [*(x for level in stack for x in level), *sums]:
        for start, end in several:
            while end in formula.in_scripts:
                end += 1
            if not _is_accented(formula, start):
                yield start, end, len(several) == 1


def _is_accented(formula: Formula, position: int) -> bool:
    """Whether a stretch is what an accent takes in braces."""
    before = [w.text for w in formula.words[max(position - 2, 0) : position]]
    return len(before) == 2 and before[1] == "{" and before[0] in _ACCENTS


def _parts(word: Word) -> bool:
    opaque = ("\\begin", "\\end", "\\label", "\\text")
    return word.text in _ENDS or word.kind == "break" or word.text.startswith(opaque)


def _brackets(formula: Formula) -> Iterator[Slip]:
    """A bracket that closes one word too early or too late, and one left out."""
    for before, word, after in zip(
        formula.words, formula.words[1:], formula.words[2:], strict=False
    ):
        if word.text not in (")", "]"):
            continue
        yield formula.cut(word.start, word.end, "", "bracket")
        if _is_letter(after) or after.kind == "digit":
            text = formula.latex[word.end : after.end] + formula.latex[word.start : word.end]
            yield formula.cut(word.start, after.end, text, "bracket")
        if _is_letter(before) or before.kind == "digit":
            text = formula.latex[word.start : word.end] + formula.latex[before.start : before.end]
            yield formula.cut(before.start, word.end, text, "bracket")


def _fractions(formula: Formula) -> Iterator[Slip]:
    r"""A fraction turned, and one sign of differentiation left out."""
    words = formula.words
    for i, word in enumerate(words):
        if word.text == "\\frac":
            middle = formula.group_end(i + 1)
            end = formula.group_end(middle)
            (a, b), (c, d) = (
                (words[p].start, words[q - 1].end) for p, q in ((i + 1, middle), (middle, end))
            )
            top, bottom = formula.latex[a:b], formula.latex[c:d]
            if "\\partial" not in top and not top.strip("{} ").startswith("d"):
                yield formula.cut(a, d, f" {bottom} {top}", "fraction")
        elif word.text == "\\partial":
            yield formula.cut(word.start, word.end, "", "differential")


def _repeat_formula(formula: Formula) -> Iterator[Slip]:
    """One formula of a display in the place of its neighbour."""
    words, spans, start = formula.words, list[tuple[int, int]](), 0
    for i in range(len(words) + 1):
        ends = i == len(words) or (formula.depths[i] == 0 and _separates(words[i]))
        if ends:
            if any(w.text in ("=", *_RELATIONS) for w in words[start:i]):
                spans.append((words[start].start, words[i - 1].end))
            start = i + 1
    for (a, b), (c, d) in pairwise(spans):
        yield formula.cut(c, d, formula.latex[a:b], "repeated")
        yield formula.cut(a, b, formula.latex[c:d], "repeated")


def _separates(word: Word) -> bool:
    if word.kind == "opaque":
        return word.text.startswith(("\\text", "\\begin", "\\end", "\\label"))
    return word.text in (",", ";", "\\\\", "\\quad", "\\qquad")


_MAKERS: tuple[Callable[[Formula], Iterator[Slip]], ...] = (
    _signs,
    _relations,
    _functions,
    _numbers,
    _names,
    _swaps,
    _marks,
    _fonts,
    _scripts,
    _factors,
    _terms,
    _brackets,
    _fractions,
    _repeat_formula,
)
