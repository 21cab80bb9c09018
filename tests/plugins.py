"""Distributions of somebody else, as they are found when installed, without a package index."""

from __future__ import annotations

from pathlib import Path


def register(folder: Path, distribution: str, points: str) -> None:
    """The trace of an installed distribution that registers some systems."""
    info = folder / f"{distribution.replace('-', '_')}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[voronec.systems]\n{points}\n")


def install(folder: Path, distribution: str, project: Path) -> None:
    """Register what a pyproject.toml lists."""
    points = project.read_text().split('[project.entry-points."voronec.systems"]')[1]
    register(folder, distribution, points.split("[tool")[0].replace('"', ""))
