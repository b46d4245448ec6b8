"""`benchtwin clump`: fits overlapping balls to a mesh or to voxels of one seed, for
several DEM codes."""

import sys
from pathlib import Path

import cv2
import numpy as np

from benchtwin.sim.seed import MOST_SPHERES, Seed
from benchtwin.sim.seed.clump import spheres_for
from benchtwin.sim.seed.clump_error import ClumpError, clump_error
from benchtwin.sim.seed.clump_files import files
from benchtwin.sim.seed.mesh_file import read_mesh
from benchtwin.sim.seed.shape import Shape
from benchtwin.sim.seed.voxels import closed_surface

DONE, MISUSED = 0, 2
USUAL_TOLERANCE = 0.03  # rms surface error over the mean radius
SIDE, GREY, INK, DARK = 420, 205, (160, 60, 30), (60, 60, 60)
FONT = cv2.FONT_HERSHEY_SIMPLEX


def clump_command(
    source: Path,
    out: Path,
    spheres: int | None,
    tolerance: float | None,
    unit: str | None,
    voxel_mm: float | None,
    density_kg_m3: float,
    overwrite: bool,
    quiet: bool,
) -> int:
    """Fit the balls and write `out`; returns the exit code. spheres: so many; else the
    fewest within `tolerance`."""
    try:
        if spheres is not None and tolerance is not None:
            raise ValueError("--spheres and --tolerance: give one of them")
        if tolerance is not None and not 0.0 < tolerance < 1.0:
            raise ValueError(
                f"--tolerance {tolerance:g}: must be above 0 and below 1, a share of"
                " the mean radius"
            )
        shape = read_shape(source, unit, voxel_mm)
        tried: list[ClumpError | None] = []
        if spheres is None:
            spheres, tried = spheres_for(
                shape, tolerance or USUAL_TOLERANCE, MOST_SPHERES
            )
        seed = Seed.from_shape(shape, spheres, density_kg_m3)
        own = shape.principal()[0]
        texts = files(seed, source.name)
        there = [name for name in (*texts, "clump.png") if (out / name).exists()]
        if there and not overwrite:
            raise ValueError(
                f"{out / there[0]}: exists already; choose another --out, or say"
                " --overwrite"
            )
        out.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (out / name).write_text(text, encoding="utf8")
        if not cv2.imwrite(str(out / "clump.png"), picture(own, seed)):
            raise OSError(f"{out / 'clump.png'}: cannot be written")
    except (ValueError, OSError) as error:
        print(f"benchtwin clump: {error}", file=sys.stderr)
        return MISUSED
    if not quiet:
        misses = clump_error(own, seed.centres_m, seed.radii_m)
        print("\n".join([*_summary(own, seed, misses, tried), *shape.notes]))
        print(
            f"Files for LAMMPS, LIGGGHTS, YADE and EDEM: {out}; look at"
            f" {out / 'clump.png'}"
        )
    return DONE


def read_shape(source: Path, unit: str | None, voxel_mm: float | None) -> Shape:
    """A mesh file, or the voxels of a `.npy` array (i, j, k), non-zero where the seed
    is. ValueError names file and option."""
    if source.suffix.lower() != ".npy":
        if voxel_mm is not None:
            raise ValueError(
                f"--voxel-mm: {source} is no .npy array of voxels; a mesh takes --unit"
            )
        return read_mesh(source, unit)
    if voxel_mm is None or not voxel_mm > 0:
        raise ValueError(f"{source}: say the side of a voxel with --voxel-mm")
    try:
        filled = np.load(source, allow_pickle=False)
    except (OSError, ValueError) as error:
        raise ValueError(
            f"{source}: not an array that can be read ({error})"
        ) from error
    if filled.ndim != 3:
        raise ValueError(f"{source}: has {filled.ndim} dimensions; voxels have 3")
    try:
        return Shape(*closed_surface(filled != 0, 1e-3 * voxel_mm))
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from error


def _summary(
    shape: Shape, seed: Seed, error: ClumpError, tried: list[ClumpError | None]
) -> list[str]:
    length, width, thickness = 1e3 * np.ptp(shape.vertices_m, axis=0)
    moments = ", ".join(f"{100 * m:+.1f}" for m in error.moments)
    text = f"""\
{len(seed.radii_m)} balls: surface {100 * error.surface_rms:.2f} % rms, \
{100 * error.surface_max:.1f} % at most, of the mean radius
shape: {length:.3f} x {width:.3f} x {thickness:.3f} mm, \
{1e9 * shape.volume_m3:.4g} mm3, {1e3 * seed.mass_kg:.4g} g at \
{seed.density_kg_m3:g} kg/m3
the balls' union has {100 * error.volume:+.2f} % of its volume and {moments} % of its \
moments; the files state the shape's own"""
    lines = text.splitlines()
    if len(tried) > 1:
        found = (
            f"{n}: {'not one piece' if e is None else f'{100 * e.surface_rms:.1f} %'}"
            for n, e in enumerate(tried, 1)
        )
        lines.append("rms surface error with fewer balls: " + ", ".join(found))
    return lines


def picture(shape: Shape, seed: Seed) -> np.ndarray:
    """The shape (grey) and the balls' outlines (blue) along its three principal axes; a
    bar of 1 mm. uint8 BGR."""
    reach = np.abs(shape.vertices_m).max()
    scale = 0.43 * SIDE / reach
    panels = []
    views = {"from above": (0, 1), "from the side": (0, 2), "along its length": (1, 2)}
    for name, (across, up) in views.items():
        panel = np.full((SIDE, SIDE, 3), 255, np.uint8)
        corners = SIDE / 2 + scale * shape.vertices_m[:, [across, up]] * [1, -1]
        filled = np.zeros((SIDE, SIDE), np.uint8)
        for triangle in np.rint(16 * corners[shape.faces]).astype(np.int32):
            cv2.fillConvexPoly(filled, triangle, 255, cv2.LINE_8, 4)
        panel[filled > 0] = GREY
        for centre, radius in zip(seed.centres_m, seed.radii_m):
            x, y = SIDE / 2 + scale * centre[[across, up]] * [1, -1]
            middle = (round(16 * x), round(16 * y))
            wide = round(16 * scale * radius)
            cv2.circle(panel, middle, wide, INK[::-1], 2, cv2.LINE_AA, 4)
        cv2.putText(panel, name, (12, 24), FONT, 0.6, DARK, 1, cv2.LINE_AA)
        panels.append(panel)
    end = (12 + round(1e-3 * scale), SIDE - 14)
    cv2.line(panels[0], (12, SIDE - 14), end, DARK, 3)
    at = (12, SIDE - 22)
    cv2.putText(panels[0], "1 mm", at, FONT, 0.5, DARK, 1, cv2.LINE_AA)
    return np.hstack(panels)
