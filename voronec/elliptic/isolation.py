"""Balls that hold one root of a polynomial each, however near the roots are to each other."""

from __future__ import annotations

from collections.abc import Iterator

from flint import acb, acb_poly, arb, ctx

__all__ = ["isolations"]

ROOM = 40
"""Steps beyond those in which points that double their accuracy in each reach the precision."""


def isolations(polynomial: acb_poly) -> Iterator[list[acb]]:
    """Isolating balls of all roots, narrower ones each time: for who asks again.

    There may be none, where the roots cannot be told apart at the present precision.
    """
    for narrow in (None, 2.0**-40, arb(2) ** (-ctx.prec // 4), arb(2) ** (-ctx.prec // 2)):
        try:
            yield polynomial.roots() if narrow is None else polynomial.roots(tol=narrow)
        except ValueError:
            break
    # Flint gives up after some steps, of which roots 1e-100 apart take more.
    balls = _discs(polynomial, _approached(polynomial))
    if balls is not None:
        yield balls


def _approached(polynomial: acb_poly) -> list[acb]:
    """Points near the roots, by the method of Aberth and Ehrlich.

    Points near a multiple root halve their distance in each step; two roots that the precision
    can tell apart are 2^-(prec/2) apart at least, and more would be of no use.
    """
    degree = polynomial.degree()
    values = acb_poly([acb(c.mid()) for c in polynomial.coeffs()])
    slopes = values.derivative()
    size = _size(values)
    places = [acb((size * acb(arb(2 * k) / degree + arb(0.35)).exp_pi_i()).mid())
              for k in range(degree)]  # fmt: skip
    least = arb(2) ** (4 - ctx.prec)
    for _ in range(ctx.prec // 2 + ROOM):
        moved = False
        for k, place in enumerate(places):
            value = values(place)
            if value.contains(0):
                continue
            pull = acb(slopes(place).mid()) / acb(value.mid())
            for j, other in enumerate(places):
                pull -= 0 if j == k else 1 / (place - other)
            step = acb((1 / acb(pull.mid())).mid())
            if not step.is_finite():
                continue
            places[k] = acb((place - step).mid())
            moved = moved or bool(abs(step) > least * abs(place))
        if not moved:
            break
    return places


def _size(polynomial: acb_poly) -> arb:
    """A radius of the order of the roots': the largest of |c_k/c_n|^(1/(n - k))."""
    *rest, lead = polynomial.coeffs()
    degree = len(rest)
    sizes = [(abs(c) / abs(lead)).root(degree - k) for k, c in enumerate(rest) if not c.is_zero()]
    return arb(max((float(s.log()) for s in sizes), default=0.0)).exp()


def _discs(polynomial: acb_poly, places: list[acb]) -> list[acb] | None:
    """Smith's discs about points, of radius ``n |p(z_i)/(c prod (z_i - z_j))|``: they contain all
    roots, and one each where no two meet.  None where some do."""
    degree, lead = len(places), polynomial.coeffs()[-1]
    found = []
    for k, place in enumerate(places):
        below = acb(lead)
        for j, other in enumerate(places):
            if j != k:
                below *= place - other
        if below.contains(0):
            return None
        reach = arb(0, (degree * abs(polynomial(place) / below)).upper())
        found.append(place + acb(reach, reach))
    apart = all(not found[j].overlaps(found[k]) for k in range(degree) for j in range(k))
    return found if apart else None
