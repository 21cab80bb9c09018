"""One HTML page of a motion: it holds all that it needs, and asks no network for anything.

What it computes - rates, places of bodies and integrals - is one program in JavaScript.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.symbols import names_in, plain_name
from voronec.declaration.shapes import MESH, Shape
from voronec.declaration.whole_files import draft
from voronec.equations.program import Program, javascript_source
from voronec.equations.program.straight import Block
from voronec.equations.voronec_equations import derive
from voronec.errors import DefinitionError, IntegrationError, VoronecError
from voronec.motion.closed_form import closed_form
from voronec.motion.observables import watch_of
from voronec.motion.request import Namespace

if TYPE_CHECKING:
    from voronec.declaration.system import System
    from voronec.motion.pictures.motion_record import MotionRecord
    from voronec.motion.request import Namespace


def page_program(namespace: Namespace, shapes: Sequence[Shape]) -> Program:
    """The whole equations on coordinates and velocities; its extra quantities place each
    shape by fifteen numbers, centre, attitude row by row and contact, and then are integrals, the
    sizes of their terms, and ``quartic_parts``."""
    placed = {
        f"shape {i} {k}": namespace.inward(e)
        for i, shape in enumerate(shapes)
        for k, e in enumerate((*shape.centre, *shape.attitude, *(shape.contact or (0, 0, 0))))
    }
    beside = watch_of(namespace, ())
    names = [*beside.integrals.values(), *beside.sizes.values()]
    kept = {name: beside.expressions[name] for name in names}
    return Program.of(namespace.equations.form, placed | kept | quartic_parts(namespace))


def quartic_parts(namespace: Namespace) -> dict[str, Any]:
    """Of a motion by quadratures, (dx/dtau)^2 = f(x): x, and f at -1, -1/2, 0, 1/2, 1, which fix a
    quartic, as functions of the state; nothing of other motions."""
    motion = namespace.equations.system.motion
    if motion is None:
        return {}
    known = dict(motion.constants)
    places = [sp.Rational(k, 2) for k in range(-2, 3)]
    values = [motion.quartic.xreplace({motion.x: place}).xreplace(known) for place in places]
    parts = [motion.meaning, *values]
    return {f"quartic {i}": namespace.inward(part) for i, part in enumerate(parts)}


def mesh_program(shapes: Sequence[Shape], namespace: Namespace) -> Program:
    """A program whose extra quantities at the state (a, b) are three numbers for each patch of each
    shape, one after the other."""
    parameters = tuple(map(se.Symbol, namespace.equations.system.parameter_names))
    points = [
        namespace.equations.bridge.inward(e) for s in shapes for p in s.patches for e in p.position
    ]
    a, b = (se.Symbol(str(x)) for x in MESH)
    names = tuple(f"point {i}" for i in range(len(points)))
    return Program(
        time=namespace.equations.form.time,
        coordinates=(a,),
        velocities=(b,),
        parameters=parameters,
        derivative=Block((), (se.Integer(0), se.Integer(0))),
        names=names,
        extras=Block((), tuple(points)),
    )


LARGEST = 900_000
"""How many bytes a page may have."""
LONG = 2000.0
"""For longer than that a page would compute too long a time, and too inaccurately."""
SECONDS = 25.0
"""About how long a page plays a motion."""


def check_shapes(system: System) -> None:
    """``DefinitionError`` where nothing of the system can be drawn."""
    if not system.shapes:
        raise DefinitionError(
            f"system '{system.name}' has no shape to be viewed; declare one, such as "
            "shapes=(Shape.ball(R, centre=(x, y, R), attitude=rotation.matrix), Shape.plane()), "
            'or in a text file a table [[shapes]] with kind = "ball", radius = "R" and '
            'centre = ["x", "y", "R"]'
        )


@dataclass(frozen=True)
class Page:
    """The page of a trajectory, which holds all coordinates and velocities of the equations.

    It integrates the equations itself, and again where somebody moves a slider.  What it cannot
    integrate - inputs, switching surfaces, changes of coordinates on the way, a long time - it
    plays from the instants of the trajectory, and says so.  ``caption`` says what there is to see
    below the ``title``, by default that of the system.
    """

    trajectory: MotionRecord
    caption: str = ""
    title: str = ""

    @property
    def system(self) -> System:
        """What moves."""
        return self.trajectory.system

    @cached_property
    def namespace(self) -> Namespace:
        """The names of its equations."""
        return Namespace.of(derive(self.system))

    @cached_property
    def program(self) -> Program:
        """What the page computes."""
        return page_program(self.namespace, self.system.shapes)

    @cached_property
    def states(self) -> np.ndarray:
        """The states of the program (instants, variables) along the trajectory."""
        names = [str(x) for x in self.program.state]
        try:
            columns = [np.asarray(self.trajectory[name], dtype=float) for name in names]
        except DefinitionError:
            raise DefinitionError(
                f"system '{self.system.name}': a page needs {', '.join(names)}, and the trajectory "
                "holds less; integrate with outputs=(*system.coordinates, *system.velocities)"
            ) from None
        return np.stack(columns, axis=1)

    @property
    def span(self) -> float:
        """How long the motion takes."""
        return abs(float(self.trajectory.t[-1] - self.trajectory.t[0]))

    @cached_property
    def recording_reason(self) -> str:
        """Why the page plays what was computed, and does not integrate; empty where it does."""
        program, cost = self.program, self.trajectory.cost
        if self.span > LONG:
            return "the motion is longer than a page integrates"
        if program.inputs:
            return "inputs move the system"
        if program.is_rough:
            return "the equations have switching surfaces"
        if cost.switches:
            return "the coordinates were changed on the way"
        return ""

    @cached_property
    def parts(self) -> Mapping[str, str]:
        """The scripts of the page but for three.js and what needs a document, in order."""
        folder = files(__package__)
        return {
            "program": _module_object(javascript_source(self.program)),
            "mesh": _module_object(
                javascript_source(mesh_program(self.system.shapes, self.namespace))
            ),
            "DATA": _json(self.data),
            "dop853": (folder / "dop853.js").read_text("utf-8"),
            "motion": (folder / "motion.js").read_text("utf-8"),
        }

    @property
    def motion_script(self) -> str:
        """Everything that computes: ``motionOf(start, parameters)`` is the motion."""
        named = ("program", "mesh", "DATA")
        held = "".join(f"const {name} = {self.parts[name]};\n" for name in named)
        return held + self.parts["dop853"] + self.parts["motion"]

    @cached_property
    def data(self) -> dict[str, Any]:
        """What is particular to this motion."""
        self._require_values()
        recorded = self.recording_reason
        start = self.states[0]
        bound = set().union(*map(names_in, self.system.fibration.relations), ())
        tied = {plain_name(x) for x in bound}
        values = self.trajectory.parameters
        return {
            "title": self.title or self.system.title or self.system.name,
            "caption": self.caption,
            "source": f"Recorded: {recorded}."
            if recorded
            else "The page integrates the equations of motion itself: move a slider.",
            "times": _pack(self.trajectory.t),
            "recorded": _pack(self.states) if recorded else "",
            "start": [
                self._entry(i, str(x), value, not recorded and str(x) not in tied)
                for i, (x, value) in enumerate(zip(self.program.state, start, strict=True))
            ],
            "parameters": [
                self._entry(i, str(p), float(values[str(p)]), not recorded and str(p) not in tied)
                for i, p in enumerate(self.program.parameters)
            ],
            "integrals": [
                name.removeprefix("integral ")
                for name in self.program.names
                if name.startswith("integral ")
            ],
            "quartic": self._quartic,
            "shapes": [_describe_shape(shape) for shape in self.system.shapes],
            "pace": 1.0 if SECONDS / 5 <= self.span <= 2 * SECONDS else self.span / SECONDS,
        }

    @property
    def _quartic(self) -> dict[str, str] | None:
        """Of a motion by quadratures: its variable, and the classes of its traces."""
        motion = self.system.motion
        if motion is None:
            return None
        start = dict(zip(map(str, self.program.state), map(float, self.states[0]), strict=True))
        values = {name: float(x) for name, x in self.trajectory.parameters.items()}
        try:
            traces = closed_form(self.system, parameters=values, initial=start).classes
            classes = "; ".join(f"{title}: class {of}" for title, of in traces.items())
        except VoronecError:  # the page shows the motion all the same
            classes = ""
        return {"variable": f"{motion.x} = {motion.meaning}", "classes": classes}

    def _require_values(self) -> None:
        missing = [str(p) for p in self.program.parameters
                   if str(p) not in self.trajectory.parameters]  # fmt: skip
        if missing:
            raise DefinitionError(
                f"system '{self.system.name}': a page needs a value of {', '.join(missing)}; "
                "integrate with parameters={...}"
            )

    def _entry(self, place: int, name: str, value: float, slides: bool) -> dict[str, Any]:
        """One number that a slider moves."""
        parameter = next((p for p in self.system.parameters if p.name == name), None)
        positive = parameter is not None and parameter.is_positive
        reach = 2 * abs(value) or 1.0
        low, high = (value / 10, 3 * value) if positive else (value - reach, value + reach)
        if parameter is not None:
            low = low if parameter.lower is None else max(low, float(parameter.lower))
            high = high if parameter.upper is None else min(high, float(parameter.upper))
        meaning = parameter.meaning if parameter is not None else self.system.meanings.get(name, "")
        return {
            "place": place, "name": name, "value": float(value), "meaning": meaning,
            "low": low, "high": high, "positive": positive, "slides": slides,
        }  # fmt: skip

    @cached_property
    def text(self) -> str:
        """The page.  ``DefinitionError`` where the scene is too long for one."""
        folder = files(__package__)
        style, page = (folder / "page.css").read_text("utf-8"), (folder / "page.html").read_text()
        three, viewer = ((folder / f).read_text("utf-8") for f in ("three.min.js", "viewer.js"))
        script = _inline("\n".join((three, self.motion_script, viewer)))
        policy = (
            f"default-src 'none'; script-src '{_digest(script)}'; style-src '{_digest(style)}'; "
            "base-uri 'none'; form-action 'none'"
        )
        title = html.escape(self.data["title"])
        parts = {"POLICY": policy, "TITLE": title, "STYLE": style, "SCRIPT": script}
        # in one pass: what fills a place may itself hold the mark of another
        page = re.sub("@([A-Z]+)@", lambda mark: parts[mark[1]], page)
        if len(page.encode()) > LARGEST:
            raise DefinitionError(
                f"system '{self.system.name}': the scene is too long for a page, "
                f"{len(self.trajectory.t)} instants; give fewer times"
            )
        return page


@dataclass(frozen=True)
class PageView:
    """A page that a notebook shows, in a frame of its own; ``text`` is the page."""

    text: str = field(repr=False)

    def _repr_html_(self) -> str:
        quoted = html.escape(self.text, quote=True)
        return (
            f'<iframe srcdoc="{quoted}" sandbox="allow-scripts" width="100%" height="780" '
            'style="border:0"></iframe>'
        )


def view_of(trajectory: MotionRecord, path: str | os.PathLike[str] | None) -> PageView:
    """The page of a trajectory, written to ``path`` if there is one."""
    check_shapes(trajectory.system)
    target = None if path is None else Path(path)
    if target is not None and target.suffix != ".html":
        raise DefinitionError(f"'{target.name}' must end in .html")
    if target is not None and not target.parent.is_dir():
        raise DefinitionError(f"there is no folder '{target.parent}' to write into")
    view = PageView(Page(trajectory).text)
    if target is not None:
        with draft(target) as new:
            new.write_text(view.text, "utf-8")
    return view


def _describe_shape(shape: Shape) -> dict[str, Any]:
    """What the page is told of a shape; where it is, the program says."""
    ranges = [
        None if p.ranges is None else [[float(x) for x in pair] for pair in p.ranges]
        for p in shape.patches
    ]
    return {
        "title": shape.title,
        "role": shape.role,
        "contact": shape.contact is not None,
        "patches": ranges,
    }


def _module_object(module: str) -> str:
    """A module's functions as one object, for a page that has no modules."""
    body = module.replace("export function ", "function ").replace("export const ", "const ")
    return f"(() => {{\n{body}\nreturn {{ rhs, extras }};\n}})()"


def _pack(numbers: Any) -> str:
    """Doubles as they lie in memory, little-endian, in base 64."""
    return base64.b64encode(np.ascontiguousarray(numbers, dtype="<f8").tobytes()).decode()


def _json(data: Any) -> str:
    try:
        return json.dumps(data, allow_nan=False)
    except ValueError:
        raise IntegrationError("the motion holds values that are not finite", None, None) from None


def _inline(script: str) -> str:
    """A script that does not end before its end, whatever names and titles it quotes."""
    return script.replace("</", "<\\/").replace("<!--", "<\\!--")


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
