"""``voronec view``: one HTML page of a motion, in space, that integrates by itself."""

from __future__ import annotations

from argparse import Namespace

from voronec.cli.files import delivery, wanted_folder
from voronec.cli.output import print_json, progress_line
from voronec.cli.subject import resolve
from voronec.cli.values import input_values, instants, pair, split_values

__all__ = ["execute"]


def execute(arguments: Namespace) -> int:
    """Integrate, write ``NAME.html`` or ``NAME-SCENE.html``, and say where it is."""
    from voronec.motion import integrate
    from voronec.motion.viewer.page import Page, check_shapes

    times = instants(arguments.times)
    pairs, inputs = [pair(text) for text in arguments.set], input_values(arguments.input)
    system, _ = resolve(arguments.system)
    check_shapes(system)
    folder = wanted_folder(arguments.out or ".")
    parameters, initial = split_values(system, pairs)
    scene = arguments.scene or system.first_scene
    everything = (*system.coordinates, *system.velocities)
    with progress_line(f"{system.name}: integrating ..."):
        trajectory = integrate(
            system, scene=scene, times=times, outputs=everything, parameters=parameters,
            initial=initial, inputs=inputs,
        )  # fmt: skip
        page = Page(trajectory, system.scenes[scene].caption if scene else "")
        text = page.text
    name = system.name if scene in (None, "default") else f"{system.name}-{scene}"
    with delivery(folder) as workshop:
        (workshop / f"{name}.html").write_text(text, "utf-8")
    target = folder / f"{name}.html"
    if arguments.json:
        print_json({
            "system": system.name, "scene": scene, "file": str(target),
            "bytes": len(text.encode()), "recorded": page.recording_reason,
        })  # fmt: skip
        return 0
    how = (
        f"plays what was computed: {page.recording_reason}"
        if page.recording_reason
        else "integrates"
    )
    print(f"wrote {target}, {len(text.encode()) // 1000} kB; it {how}; open it in a browser")
    return 0
