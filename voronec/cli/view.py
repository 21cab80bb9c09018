"""``voronec view``: one HTML page of a motion, in space, that integrates by itself."""

from __future__ import annotations

from argparse import Namespace

from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress_line
from voronec.cli.values import instants, motion_of


def execute(arguments: Namespace) -> int:
    """Integrate, write ``NAME.html`` or ``NAME-SCENE.html``, and say where it is."""
    from voronec.motion import integrate
    from voronec.motion.viewer.page import Page, check_shapes

    times = instants(arguments.times)
    system, given = motion_of(arguments)
    check_shapes(system)
    folder, scene = wanted_folder(arguments.out or "."), given["scene"]
    everything = (*system.coordinates, *system.velocities)
    with progress_line(f"{system.name}: integrating ..."):
        trajectory = integrate(system, times=times, outputs=everything, **given)
        page = Page(trajectory, system.scenes[scene].caption if scene else "")
        text = page.text
    name = system.name if scene in (None, "default") else f"{system.name}-{scene}"
    (target,) = deliver(folder, lambda to: (to / f"{name}.html").write_text(text, "utf-8"))
    data = {
        "system": system.name, "scene": scene, "file": str(target), "bytes": len(text.encode()),
        "recorded": page.recording_reason,
    }  # fmt: skip
    recorded = page.recording_reason
    how = f"plays what was computed: {recorded}" if recorded else "integrates"
    told = f"wrote {target}, {data['bytes'] // 1000} kB; it {how}; open it in a browser"
    answer(arguments.json, lambda: data, [told])
    return 0
