"""What the commands of LaTeX mathematics show: letters and signs."""

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
