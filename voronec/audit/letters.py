r"""What the letters of a paper mean, as far as the system and the words of the paper tell.

Letters of the system are known by their spelling: Greek names, indices, dots, other shapes of a
letter.  T, V, L, E, H and the momenta are derived; they mean that only where the paper says so in
words, as "the kinetic energy T", and another letter may take their place there.  What is left is
given in a table of TOML, ``[letters]``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import sympy as sp

from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import as_expression, formula
from voronec.audit.latex.document import PrintedDisplay
from voronec.audit.latex.nodes import TRANSPOSE, Name, Node, Power
from voronec.audit.latex.tokens import FUNCTIONS, Unfamiliar
from voronec.audit.lessons.judgement import CONSTANT, Language
from voronec.audit.lessons.notation import BASE
from voronec.audit.meaning import SENSELESS, UnknownName, evaluate
from voronec.audit.printed_claims import PrintedClaim
from voronec.audit.study import Motion, Range, Study, key_of, spell
from voronec.declaration.text_file import read_toml
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, did_you_mean

_USUAL_WORDS = {
    "T": r"kinetic|energ",
    "V": r"potential|energ",
    "L": r"lagrang|kinetic potential",
    "E": r"energ",
    "H": r"energ|hamilton",
    "p": r"moment|impuls",
}
"""Letters of mechanics, and the words with which they have their usual meaning."""
_NAMES_OF_ENERGIES = (
    ("T", r"kinetic(?: energy)?"),
    ("V", r"potential(?: energy)?"),
    ("L", r"lagrangian|lagrange function|kinetic potential"),
    ("E", r"(?:total |full |mechanical )?energy|hamiltonian"),
)
_ON_CONSTRAINTS = re.compile(r"constrain|reduced|restricted", re.IGNORECASE)
_PARTIAL = re.compile(
    r"rotat|translat|spring|wheel|part|first|second|each|elastic|relative|moving|per unit",
    re.IGNORECASE,
)
"""Words behind which an energy is that of a part of the system."""
_SHAPE = re.compile(r"\\(?:(?:mathcal|mathrm|mathbf|boldsymbol)\{|el(?=l))(.*?)\}?")
"""Shapes in which a letter of the system may be printed."""


def study_of(equations: VoronecEquations, text: str = "") -> Study:
    """The dictionary of a system: its own letters, and its motion with all accelerations.

    Their rates, which may be long, are known only where the text of a paper may hold them.
    """
    language = Language.of(equations)
    system = equations.system
    known = dict(language.study.names)
    known.pop(f"\\mathrm{{{BASE}}}")
    spoken = {k for k in ("L", "T", "V") if k not in language.symbols}
    names = {k: v for k, v in known.items() if k not in spoken and v != CONSTANT}
    names.setdefault("e", sp.E)
    names |= _vectors(names, {p.symbol for p in system.parameters})
    field = Motions.of(equations).on_coordinates
    values = [as_expression(equations.bridge.outward(a)) for a in field.accelerations]
    dots = [velocity(v) for v in equations.velocities]
    motion = Motion.of(equations, {u: velocity(u) for u in system.inputs})
    motion = replace(motion, accelerations=dict(zip(dots, values, strict=True)))
    if "\\dddot" in text or (motion.quasi and "\\ddot" in text):
        slopes = {dot: motion.derivative(value) for dot, value in motion.accelerations.items()}
        motion = replace(motion, rates={**motion.rates, **slopes})
    signs = {
        p.symbol: sp.Symbol(f"{p.name}", positive=True) for p in system.parameters if p.positive
    }
    others = {*motion.rates, *(p.symbol for p in system.parameters)} - signs.keys()
    real = {x: sp.Symbol(plain_name(x), real=True) for x in sorted(others, key=str)}
    where = Range("", "", {**signs, **real}, tuple(signs.values()), tuple(real.values()))
    return Study(names=names, motion=motion, ranges=(where,), context=equations)


def _vectors(names: Mapping[str, Any], parameters: set[Any]) -> dict[str, Any]:
    """Bold letters: the vector of three components, the diagonal matrix of three parameters."""
    vectors: dict[str, Any] = {}
    for name in names:
        head, _, index = name.partition("_")
        several = [f"{head}_{{{i}}}" for i in ("123" if index == "{1}" else "xyz")]
        if index in ("{1}", "{x}") and all(one in names for one in several):
            values = [names[one] for one in several]
            value = sp.diag(*values) if {*values} <= parameters else sp.Matrix(values)
            vectors |= {f"\\{shape}{{{head}}}": value for shape in ("mathbf", "boldsymbol", "vec")}
    return vectors


def _letters_of_mechanics(equations: VoronecEquations, study: Study) -> dict[str, Any]:
    """The letters of mechanics by their keys."""
    system = equations.system
    known = Language.of(equations).study.names
    letters = {k: known[k] for k in ("L", "T", "V") if k in known}
    if "T" in letters and "V" in letters:
        letters |= dict.fromkeys(("E", "H"), letters["T"] + letters["V"])
    for q in system.coordinates:
        slope = sp.diff(system.lagrangian, velocity(q))
        letters |= {f"p_{key}": slope for key, value in study.table.items() if value == q}
    return letters


def names_in(part: Any) -> Iterator[Name]:
    """The names in a tree, without those that stand as indices, and the T of what is transposed."""
    if isinstance(part, Power) and part.exponent in TRANSPOSE:
        part = part.base
    if isinstance(part, Name):
        yield part
    elif isinstance(part, tuple):
        for item in part:
            yield from names_in(item)
    elif hasattr(part, "at"):
        for value in vars(part).values():
            yield from names_in(value)


def with_words(study: Study, claims: Iterable[PrintedClaim]) -> Study:
    """The dictionary with what the words of a paper bind, whose formulas these are."""
    derived, table = _letters_of_mechanics(study.context, study), dict(study.table)
    letters: dict[str, Any] = {}
    seen: set[int] = set()
    claims = list(claims)
    plain_l = any(n.head == "l" for claim in claims for n in names_in(claim.chain or ()))
    for claim in claims:
        words = claim.sentence.lower()
        for name in names_in(claim.chain or ()):
            key = key_of(name)
            shape = _SHAPE.fullmatch(name.head)
            plain = key.replace(name.head, shape[1], 1) if shape else key
            letter = plain.partition("_")[0]
            if key in table or key == "const" or (plain_l and name.head == "\\ell"):
                continue
            if plain in table:
                letters[name_latex(name)] = table[key] = table[plain]
            elif plain in derived and re.search(_USUAL_WORDS.get(letter, "$."), words):
                letters[name_latex(name)] = table[key] = derived[plain]
        first = claim.chain.parts[0] if claim.chain and id(claim.display) not in seen else None
        seen |= {id(claim.display)} if claim.chain else set()
        if isinstance(first, Name) and not first.sup and key_of(first) not in table:
            value = _value_by_words(claim.display, first, derived, study)
            if value is not None:
                letters[name_latex(first)] = table[key_of(first)] = value
    return replace(study, names={**study.names, **letters})


def has_usual_words(name: Name, words: str) -> bool:
    """Whether words around a letter of mechanics say that it means what it usually does."""
    head = _SHAPE.sub(r"\1", name.head)
    return head not in _USUAL_WORDS or re.search(_USUAL_WORDS[head], words.lower()) is not None


def _value_by_words(
    display: PrintedDisplay, name: Name, derived: Mapping[str, Any], study: Study
) -> Any:
    """What the words before a display call the letter on its left side, else None."""
    before = display.before.rpartition("$")[2][-60:].lower()
    restricted = _ON_CONSTRAINTS.search(display.before + display.after)
    for letter, words in _NAMES_OF_ENERGIES:
        said = re.search(rf"(?:{words})(\W[^.]*)?$", before)
        if letter not in derived or said is None or _PARTIAL.search(before):
            continue
        if restricted:
            return study.motion.restrict(derived[letter])
        return None if name.sub or "'" in name.head else derived[letter]
    return None


def name_latex(name: Name) -> str:
    """A name as a dictionary spells it."""
    below, above = (",".join(map(spell, marks)) for marks in (name.sub, name.sup))
    return name.head + (f"_{{{below}}}" if below else "") + (f"^{{{above}}}" if above else "")


def unknown_names(chain: Node, study: Study) -> list[str]:
    """The names of a tree that neither the dictionary nor the paper explains, as they are spelled;
    each once."""
    unknown: dict[str, None] = {}
    for name in names_in(chain):
        if name.head in {"const", "\\pm", "d"} | FUNCTIONS:
            continue
        try:
            evaluate(name, study)
        except UnknownName:
            unknown.setdefault(name_latex(name))
        except Unfamiliar:  # p_v, where v has a value that is no index
            unknown |= {name_latex(name): None} if name.sub or name.sup else {}
        except SENSELESS:
            continue  # told where the formula gets its verdict
    return [*unknown]


def read_letters(path: str | Path, equations: VoronecEquations) -> dict[str, Any]:
    """The table ``[letters]`` of a file: letters of the paper, and what they are in the system.

    ``DefinitionError`` with line and column; an entry that is left empty is none.
    """
    names = dict(Language.of(equations).symbols)
    names |= {plain_name(velocity(q)): velocity(q) for q in equations.coordinates}
    letters: dict[str, Any] = {}
    top = read_toml(Path(path)).table(("letters",))
    for letter, item in top["letters"].table().items() if "letters" in top else ():
        text = item.scalar()
        if not text.strip():
            continue
        try:
            value = formula(text, item.title, names)
            unknown = value.free_symbols - {
                x for v in names.values() for x in as_expression(v).free_symbols
            }
        except DefinitionError as error:
            item.refuse(error)
        for symbol in sorted(unknown, key=str):
            item.wrong(f"'{symbol}' is no symbol of the system{did_you_mean(str(symbol), names)}")
        letters[letter] = value
        try:
            Study({letter: value}).table  # noqa: B018  (it is read)
        except DefinitionError as error:
            item.wrong_key(str(error))
    return letters


def letters_table(letters: Mapping[str, list[str]]) -> str:
    """A table to be filled in: letters with the places where they stand, most frequent first."""
    lines = [
        '# What the letters of the paper are in the system, as "\\\\omega" = "phidot".',
        "# Leave empty what it does not have.",
        "[letters]",
    ]
    for letter, places in sorted(letters.items(), key=lambda entry: -len(entry[1])):
        several = ", ".join(places[:4]) + (" ..." if len(places) > 4 else "")
        key = letter.replace("\\", "\\\\").replace('"', '\\"')
        lines.append(f'"{key}" = ""  # in {len(places)}: {several}')
    return "\n".join(lines) + "\n"
