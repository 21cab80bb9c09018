"""``voronec show``: what a system declares; nothing is derived."""

from __future__ import annotations

import io
from argparse import Namespace
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.cli.output import answer, plain, wrote
from voronec.cli.subject import entry_of_name, is_file, resolve
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.declaration.claims import Poisson
    from voronec.declaration.geometry import Frame
    from voronec.declaration.quadratures import Plane, Quadratures
    from voronec.declaration.scene import Scene
    from voronec.declaration.system import System


def _claims(system: System) -> list[dict[str, str]]:
    """Every claim: kind, name and statement; where corrected, what is printed and its source."""
    claims = [*_shared_claims(system, "")]
    for name, case in system.cases.items():
        values = ", ".join(f"{plain(k)} = {plain(v)}" for k, v in case.parameters.items())
        claims.append(_claim("case", name, ": ".join(filter(None, (values, case.note)))))
        claims += _shared_claims(case, f"{name}: ")
    if system.motion is not None:
        claims += _by_quadratures(system.motion)
    claims += [_claim("undecided", name, why) for name, why in system.undecided.items()]
    claims += [_claim("invariant", name, plain(e)) for name, e in system.invariants.items()]
    return claims


def _claim(kind: str, name: str, statement: str) -> dict[str, str]:
    return {"kind": kind, "name": name, "statement": statement}


def _shared_claims(holder: Any, case: str) -> Iterator[dict[str, str]]:
    """The claims that a system and a case have in common."""
    from voronec.declaration.claims import declared_claims

    shown: dict[str, tuple[str, Callable[[Any], str]]] = {
        "multiplier": ("dtau = N dt", lambda claim: "N = " + plain(claim)),
        "integrable": ("", lambda _: "by quadratures"),
        "poisson": ("bracket", _bracket),
        "essential": ("closed", _list),
    }
    last = ("poisson", "essential")
    for kind, name, _, _, claim in sorted(declared_claims(holder), key=lambda c: c.kind in last):
        title, words = shown.get(kind, ("", _statement))
        yield _claim(kind, case + (title or name), words(claim)) | _correction(claim)


def _by_quadratures(motion: Quadratures) -> Iterator[dict[str, str]]:
    """The rates of the variable and of the angles, and what the symbols in them stand for."""
    x, time = motion.x, "t" if motion.clock == 1 else "tau"
    yield _claim("motion", f"{x}", f"{x} = {plain(motion.meaning)}")
    for symbol, meaning in motion.constants.items():
        yield _claim("motion", f"{symbol}", f"{symbol} = {plain(meaning)}, constant")
    if motion.clock != 1:
        yield _claim("motion", "clock", f"dt/dtau = {plain(motion.clock)}")
    yield _claim("motion", f"rate of {x}", f"(d{x}/d{time})^2 = {plain(motion.quartic)}")
    for q, rate in motion.integrals.items():
        yield _claim("motion", f"rate of {plain(q)}", f"d{plain(q)}/d{time} = {plain(rate)}")
    for trace in motion.traces:
        name = plain(trace.colatitude)
        yield _claim("motion", f"cosine of {name}", f"cos({name}) = {plain(trace.cosine)}")
    if motion.space is not None:
        space = motion.space
        vector = f"({_list(space.frame * space.vector)})"
        yield _claim("motion", "space", f"{_list(space.coordinates)}: where {vector} is upright")
    if motion.plane is not None:
        plane = motion.plane
        yield _claim("motion", "plane", _run(plane, x, time))


def _run(plane: Plane, x: Any, time: str) -> str:
    """How a contact moves over a plane, in units of a vector there."""
    forward, left = (
        f"({plain(rate)}) d{time} + ({plain(slope)}) d{x}"
        for rate, slope in zip(plane.rates, plane.slopes, strict=True)
    )
    place, vector = _list(plane.place), _list(plane.direction)
    return f"({place}) by {forward} along ({vector}), {left} to its left"


def _correction(claim: Any) -> dict[str, str]:
    from voronec.declaration.claims import Corrected

    if not isinstance(claim, Corrected):
        return {}
    return {"printed": _statement(claim.printed), "source": claim.source}


def _statement(claim: Any) -> str:
    from voronec.declaration.claims import Assertion, Equation, Measure, right_of

    claim = right_of(claim)
    if isinstance(claim, Assertion):
        return _list(claim.expressions)
    if isinstance(claim, Equation):
        pairs = zip(claim.function, claim.rate, strict=True)
        return "; ".join(f"d/dt ({plain(f)}) = {plain(g)}" for f, g in pairs)
    if isinstance(claim, Measure):
        variables = f" in {_list(claim.variables)}" if claim.variables else ""
        return plain(claim.density) + variables
    return plain(claim)


def _bracket(claim: Poisson) -> str:
    pairs = [f"{{{plain(a)}, {plain(b)}}} = {plain(e)}" for (a, b), e in claim.bracket.items()]
    meanings = [f"{plain(z)} = {plain(e)}" for z, e in claim.variables.items() if z != e]
    clock = [] if claim.clock == 1 else [f"clock {plain(claim.clock)}"]
    return "; ".join([*meanings, *pairs, f"H = {plain(claim.hamiltonian)}", *clock])


def _list(things: Iterable[Any]) -> str:
    return ", ".join(map(plain, things))


def execute(arguments: Namespace) -> int:
    """Print the declaration."""
    if arguments.out is not None:
        return _draw_sketch(arguments.system, Path(arguments.out), arguments.json)
    data, _ = declaration(arguments.system)
    answer(arguments.json, lambda: data, _lines(data))
    return 0


def _draw_sketch(subject: str, path: Path, as_json: bool) -> int:
    """Write the sketch of a system."""
    from voronec.cli.files import replace
    from voronec.motion.pictures.run_pictures import save

    if path.suffix not in PICTURES:
        raise DefinitionError(f"'{path}' must end in {', '.join(PICTURES)}; rename it")
    sketch = resolve(subject)[0].sketch
    if sketch is None:
        raise DefinitionError(f"'{subject}' declares no sketch; give its System sketch=Sketch(...)")
    stream = io.BytesIO()
    save(sketch.figure(), stream, path.suffix)
    replace(path, stream.getvalue())
    answer(as_json, lambda: {"file": str(path)}, wrote([path]))
    return 0


PICTURES = (".svg", ".png", ".pdf")
MEMORY = 200
"""Declarations that are remembered: of all systems, in a few states of their files."""


def declaration(subject: str) -> tuple[dict[str, Any], Path | None]:
    """What a system declares, as an earlier time found it where its files are unchanged; and the
    folder of its file."""
    from voronec.declaration.source_digest import closure, digest
    from voronec.declaration.whole_files import Store

    origin = None if is_file(subject) else entry_of_name(subject).origin
    if origin is None:
        system, folder = resolve(subject)
        return _data(system), folder
    store, files = Store.of_user("show", MEMORY), sorted(closure([origin.resolve()]))
    key = digest(subject, files, __name__)
    declared: dict[str, Any] | None = store.load(key, "declaration")
    if declared is None:
        declared = _data(resolve(subject)[0])
        store.save(key, "declaration", declared)
    return declared, origin.parent


def _data(system: System) -> dict[str, Any]:
    from voronec.declaration.claims import right_of

    frame = system.frame
    quasi, group = (None, frame) if frame and frame.is_group else (frame, None)
    return {
        "name": system.name,
        "title": system.title,
        "description": system.description,
        "base": _words(system.fibration.base),
        "fibre": _words(system.fibration.fibre),
        "relations": _words(system.fibration.relations),
        "velocities": _words(system.velocities),
        "frame": _pairs(quasi.velocities, quasi.expressions) if quasi else None,
        "group": _group(group) if group else None,
        "lagrangian": plain(system.lagrangian),
        "constraints": _words(system.constraints),
        "forces": _pairs(system.forces.keys(), system.forces.values()),
        "parameters": [
            {"name": p.name, "value": None if p.value is None else str(p.value),
             "range": _range(p), "meaning": p.meaning}
            for p in system.parameters
        ],
        "meanings": dict(system.meanings),
        "possible": list(system.possible),
        "integrals": {name: plain(e) for name, e in system.conserved.items()},
        "measure": None if system.measure is None else plain(right_of(system.measure).density),
        "claims": _claims(system),
        "invariants": {name: plain(e) for name, e in system.invariants.items()},
        "scenes": {name: _scene(scene) for name, scene in system.scenes.items()},
        "charts": {name: plain(chart.singular) for name, chart in system.charts.items()},
        "references": list(system.references),
        "sketch": system.sketch is not None,
    }  # fmt: skip


def _group(frame: Frame) -> dict[str, Any]:
    """The frame of a group: its velocities, their brackets and the rates of the coordinates."""
    brackets = {
        f"[{plain(a)}, {plain(b)}]": plain(sum(x * c for c, x in parts.items()))
        for (a, b), parts in (frame.brackets or {}).items()
    }
    return {
        "velocities": _words(frame.velocities),
        "fibre": _words(frame.fibre),
        "brackets": brackets,
        "rates": _pairs(frame.rates.keys(), frame.rates.values()),
    }


def _scene(scene: Scene) -> dict[str, Any]:
    return {
        "initial": _pairs(scene.initial.keys(), scene.initial.values()),
        "parameters": _pairs(scene.parameters.keys(), scene.parameters.values()),
        "times": [float(t) for t in scene.times],
        "outputs": _words(scene.outputs),
        "caption": scene.caption,
    }


def _lines(data: dict[str, Any]) -> list[str]:
    title = f"{data['name']}: {data['title']}" if data["title"] else data["name"]
    lines = [title, *([data["description"]] if data["description"] else []), ""]
    heads = [["base", ", ".join(data["base"])], ["fibre", ", ".join(data["fibre"]) or "none"]]
    heads += [["relation", f"{e} = 0"] for e in data["relations"]]
    heads += [["velocity", f"{v} = {e}"] for v, e in (data["frame"] or {}).items()]
    if data["group"] is not None:
        heads += [["velocities", ", ".join(data["group"]["velocities"])]]
        heads += [["in the fibre", ", ".join(data["group"]["fibre"]) or "none"]]
        heads += [[f"d{q}/dt", e] for q, e in data["group"]["rates"].items()]
        heads += [
            ["brackets", f"{len(data['group']['brackets'])} of the group (--json lists them)"]
        ]
    heads += [["L", data["lagrangian"]]]
    heads += [[f"constraint {i + 1}", f"{e} = 0"] for i, e in enumerate(data["constraints"])]
    heads += [[f"force on {q}", e] for q, e in data["forces"].items()]
    lines += columns(heads)
    if data["meanings"]:
        lines += ["", "in words", *columns(map(list, data["meanings"].items()), "  ")]
    if data["parameters"]:
        rows = [
            [
                p["name"],
                "no default" if p["value"] is None else p["value"],
                p["range"],
                p["meaning"],
            ]
            for p in data["parameters"]
        ]
        lines += ["", "parameters", *columns(rows, "  ")]
        lines += [f"  {words}" for words in data["possible"]]
    lines += ["", "claims", *_claim_lines(data["claims"])]
    lines += ["", "scenes", *_scene_lines(data["scenes"])]
    if data["charts"]:
        rows = [[name, f"where {e} vanishes"] for name, e in data["charts"].items()]
        lines += ["", "charts", *columns(rows, "  ")]
    lines += ["", "references  " + (", ".join(data["references"]) or "none")]
    drawn = f"sketch      voronec show {data['name']} --out {data['name']}.svg"
    return [*lines, drawn] if data["sketch"] else lines


def _claim_lines(claims: list[dict[str, str]]) -> list[str]:
    """One line a claim, and one for a printed form that it corrects."""
    rows = []
    for claim in claims:
        rows.append([claim["kind"], claim["name"], claim["statement"]])
        if "printed" in claim:
            words = f"not {claim['printed']}, as printed in {claim['source']}"
            rows.append(["", "", words])
    return columns(rows, "  ") or ["  none: nothing is proved of it"]


def _scene_lines(scenes: dict[str, dict[str, Any]]) -> list[str]:
    lines = []
    for name, scene in scenes.items():
        given = {**scene["parameters"], **scene["initial"]}
        start = ", ".join(f"{k} = {v}" for k, v in given.items()) or "all at zero"
        begin, end = scene["times"]
        lines.append(f"  {name}: {start}; t from {begin:g} to {end:g}")
        lines += [f"    {scene['caption']}"] if scene["caption"] else []
    return lines or ["  none"]


def _range(parameter: Any) -> str:
    words = ["positive"] if parameter.positive else []
    words += [f"at least {parameter.lower}"] if parameter.lower is not None else []
    words += [f"at most {parameter.upper}"] if parameter.upper is not None else []
    return ", ".join(words)


def _words(things: Iterable[Any]) -> list[str]:
    return [plain(e) for e in things]


def _pairs(keys: Iterable[Any], values: Iterable[Any]) -> dict[str, str]:
    return {plain(k): plain(v) for k, v in zip(keys, values, strict=True)}
