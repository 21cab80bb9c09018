"""What the commands of LaTeX mathematics show: letters, signs, alphabets, accents."""

from __future__ import annotations


def _pairs(text: str) -> dict[str, str]:
    """Words in turn with what they show."""
    words = text.split()
    return dict(zip(words[::2], words[1::2], strict=True))


LETTERS = dict(
    zip(
        "alpha beta gamma delta epsilon varepsilon zeta eta theta vartheta iota kappa lambda mu nu"
        " xi pi varpi rho varrho sigma varsigma tau upsilon phi varphi chi psi omega Gamma Delta"
        " Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega wp ell partial Re Im hbar imath jmath"
        " nabla infty emptyset".split(),
        "αβγδϵεζηθϑικλμνξπϖρϱσςτυϕφχψωΓΔΘΛΞΠΣΥΦΨΩ℘ℓ∂ℜℑℏıȷ∇∞∅",
        strict=True,
    )
)
SIGNS = _pairs(
    """
    cdot ⋅   times ×   ast ∗   star ⋆   circ ∘   div ÷   dots …   ldots …   cdots ⋯   vdots ⋮
    ddots ⋱   ne ≠   neq ≠   le ≤   leq ≤   leqslant ⩽   ge ≥   geq ≥   geqslant ⩾   ll ≪
    gg ≫   equiv ≡   approx ≈   sim ∼   simeq ≃   cong ≅   propto ∝   pm ±   mp ∓   in ∈
    notin ∉   subset ⊂   subseteq ⊆   cup ∪   cap ∩   setminus ∖   wedge ∧   vee ∨   oplus ⊕
    otimes ⊗   perp ⊥   parallel ∥   mid ∣   forall ∀   exists ∃   to →   rightarrow →
    leftarrow ←   longrightarrow ⟶   mapsto ↦   longmapsto ⟼   Rightarrow ⇒
    Leftrightarrow ⇔   iff ⟺   implies ⟹   colon :   int ∫   oint ∮   iint ∬   sum ∑   prod ∏
    langle ⟨   rangle ⟩   lbrace {   rbrace }   lvert |   rvert |   vert |   Vert ‖   | ‖
    { {   } }   % %   & &   # #   $ $   _ _   prime ′
    """
)
FUNCTIONS = frozenset(
    "sin cos tan cot sec csc sinh cosh tanh coth arcsin arccos arctan ln log exp det dim ker lim"
    " max min sup inf arg gcd deg".split()
)
LIMITS = frozenset({"\\sum", "\\prod", "\\lim", "\\max", "\\min", "\\sup", "\\inf"})
"""Scripts of these stand below and above."""
ACCENTS = {"dot": "˙", "ddot": "¨", "tilde": "~", "bar": "¯", "hat": "^", "vec": "→", "check": "ˇ"}
ACCENTS_OF_WIDTH = {
    "overrightarrow": "→",
    "overline": "¯",
    "widehat": "^",
    "widetilde": "~",
    "overbrace": "⏞",
}
FONTS = {  # where the alphabet starts: capitals, small letters
    "mathbf": (0x1D400, 0x1D41A),
    "boldsymbol": (0x1D468, 0x1D482),
    "mathcal": (0x1D4D0, 0x1D4EA),
    "mathscr": (0x1D4D0, 0x1D4EA),
    "mathfrak": (0x1D504, 0x1D51E),
    "mathbb": (0x1D538, 0x1D552),
    "mathit": (0, 0),
}
_DOUBLE_STRUCK = dict(zip("CHNPQRZ", "ℂℍℕℙℚℝℤ", strict=True))
_FRAKTUR = dict(zip("CHIRZ", "ℭℌℑℜℨ", strict=True))
_GREEK_STARTS = {"mathbf": (0x1D6A8, 0x1D6C2), "boldsymbol": (0x1D71C, 0x1D736)}
BRACKETS = {"(": ")", "[": "]", "\\{": "\\}", "\\langle": "\\rangle", "\\lbrace": "\\rbrace"}
SPACES = {  # in em
    "\\quad": 1.0,
    "\\qquad": 2.0,
    "\\,": 0.17,
    "\\:": 0.22,
    "\\>": 0.22,
    "\\;": 0.28,
    "\\!": -0.17,
    "\\ ": 0.25,
    "\\\n": 0.25,
    "~": 0.25,
}
SIZES = frozenset(
    r"\big \Big \bigg \Bigg \bigl \bigr \Bigl \Bigr \biggl \biggr \Biggl \Biggr \bigm".split()
)
"""Sizes of brackets, which grow with what they enclose by themselves here."""
INVISIBLE = frozenset(
    r"\limits \nolimits \displaystyle \textstyle \scriptstyle \nonumber \notag \mathstrut".split()
)


def letter_in_font(text: str, font: str) -> str:
    """A letter in another alphabet; what has no such form stays."""
    special = {"mathbb": _DOUBLE_STRUCK, "mathfrak": _FRAKTUR}.get(font, {})
    if text in special:
        return special[text]
    if len(text) != 1 or font not in FONTS:
        return text
    if "α" <= text <= "ω" or "Α" <= text <= "Ω":
        capitals, small = _GREEK_STARTS.get(font, (0, 0))
        start = ord("Α") if text <= "Ω" else ord("α")
    else:
        capitals, small = FONTS[font] if text.isascii() and text.isalpha() else (0, 0)
        start = ord("A") if text.isupper() else ord("a")
    base = capitals if text.isupper() else small
    return chr(base + ord(text) - start) if base else text
