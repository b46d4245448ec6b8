"""Reads a seed's mesh from STL, PLY or OBJ: unit stated, small holes closed, faces
thinned; open meshes are refused."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from benchtwin.sim.seed.shape import Shape, open_edges, thinned
from benchtwin.sim.seed.surface import area

Array = np.ndarray

KINDS = (".stl", ".ply", ".obj")
UNITS_M = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
USUAL_M = (0.2e-3, 0.1)  # seeds and grains
LEAST_M, MOST_M = 5e-5, 3.0
MOST_FACES = 20_000  # a smooth body in so many faces is true to 1e-4 of its size
SAME_PLACE = 1e-6  # of the size: vertices nearer than this are one
LARGEST_HOLE = 0.05  # of the surface


def read_mesh(file: Path | str, unit: str | None) -> Shape:
    """The closed shape in a file whose coordinates are in `unit`: "mm", "cm", "m" or
    "inch".

    Its notes say what was done to it. Raises ValueError, naming the file, where the
    unit is missing (with the sizes that each would mean), and for what is no mesh, open
    wider than 5 % of its surface, self-intersecting, or of no seed's size."""
    file = Path(file)
    if unit is not None and unit not in UNITS_M:
        raise ValueError(
            f"{file}: unit = {unit!r}: must be one of {', '.join(UNITS_M)}"
        )
    vertices, faces = _load(file)
    size = float(np.ptp(vertices, axis=0).max())
    if unit is None:
        raise ValueError(
            f"{file}: {size:.4g} long, in no unit; say which with --unit:"
            f" {_choices(size)}"
        )
    if not LEAST_M <= size * UNITS_M[unit] <= MOST_M:
        raise ValueError(
            f"{file}: {1e3 * size * UNITS_M[unit]:.4g} mm long if in {unit}: must be"
            f" {1e3 * LEAST_M:g} to {1e3 * MOST_M:g} mm; {_choices(size)}"
        )
    try:
        vertices, faces, notes = _repair(vertices, faces)
        return Shape(vertices * UNITS_M[unit], faces, tuple(notes))
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


def _choices(size: float) -> str:
    """What each unit would make of the size; those of a seed's size first."""
    usual = sorted(
        UNITS_M, key=lambda unit: not USUAL_M[0] <= size * UNITS_M[unit] <= USUAL_M[1]
    )
    return ", ".join(
        f"{unit} makes it {1e3 * size * UNITS_M[unit]:.4g} mm" for unit in usual
    )


def _load(file: Path) -> tuple[Array, Array]:
    import trimesh

    if not file.is_file():
        raise ValueError(f"{file}: there is no such file")
    if file.suffix.lower() not in KINDS:
        raise ValueError(f"{file}: must be a mesh in one of {', '.join(KINDS)}")
    try:
        mesh: Any = trimesh.load(file, force="mesh", process=False)
        vertices, faces = np.array(mesh.vertices, float), np.array(mesh.faces, np.int64)
    except Exception as error:  # every reader of trimesh fails in its own way
        raise ValueError(
            f"{file}: not readable as {file.suffix[1:].upper()}:"
            f" {error or type(error).__name__}"
        ) from error
    if not len(faces):
        raise ValueError(f"{file}: holds no triangles")
    if faces.max() >= len(vertices) or faces.min() < 0:
        raise ValueError(f"{file}: a face names a vertex that is not there")
    if not np.isfinite(vertices).all():
        vertices = vertices[: int(faces.max()) + 1]
    if not np.isfinite(vertices).all():
        raise ValueError(f"{file}: a vertex is not finite")
    return vertices, faces


def _repair(vertices: Array, faces: Array) -> tuple[Array, Array, list[str]]:
    """One closed surface, and what was done."""
    notes: list[str] = []
    vertices, faces = _merge_vertices(vertices, faces)
    vertices, faces = _largest_piece(vertices, faces, notes)
    if len(faces) > MOST_FACES:
        before = len(faces)
        vertices, faces = _merge_vertices(*thinned(vertices, faces, MOST_FACES))
        notes.append(f"thinned from {before:,} to {len(faces):,} faces")
    if open_edges(faces):
        faces = _orient_faces(vertices, faces, notes)
        vertices, faces = _close_holes(vertices, faces, notes)
    if open_edges(faces):
        raise ValueError(
            f"the surface is not closed: {open_edges(faces)} edges do not lie between"
            " two faces that agree"
        )
    crossing = crossing_faces(vertices, faces)
    if len(crossing):
        where = vertices[faces[crossing[0, 0]]].mean(axis=0)
        raise ValueError(
            f"the surface intersects itself: {len(crossing)} pairs of faces cross, one"
            f" at ({', '.join(f'{v:.4g}' for v in where)}) in the file's unit; mend it"
            " where it was made"
        )
    return vertices, faces, notes


def _merge_vertices(vertices: Array, faces: Array) -> tuple[Array, Array]:
    """Merge coinciding vertices; drop duplicate faces and faces without area."""
    size = float(np.ptp(vertices, axis=0).max())
    if not size > 0:
        raise ValueError("all its vertices are at one place")
    places = np.round(vertices / (SAME_PLACE * size))
    _, first, back = np.unique(places, axis=0, return_index=True, return_inverse=True)
    faces = back.reshape(-1)[faces]
    faces = faces[
        (faces[:, 0] != faces[:, 1])
        & (faces[:, 1] != faces[:, 2])
        & (faces[:, 2] != faces[:, 0])
    ]
    _, once = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    faces = faces[np.sort(once)]
    if not len(faces):
        raise ValueError("none of its faces has an area")
    used, renamed = np.unique(faces, return_inverse=True)
    return vertices[first[used]], renamed.reshape(-1, 3)


def _largest_piece(
    vertices: Array, faces: Array, notes: list[str]
) -> tuple[Array, Array]:
    """Of several separate surfaces the one of the largest extent: a void inside is
    filled, dust left out."""
    links = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = coo_matrix((np.ones(len(links)), links.T), (len(vertices), len(vertices)))
    pieces, label = connected_components(graph, directed=False)
    if pieces == 1:
        return vertices, faces
    extent = [
        float(np.prod(np.ptp(vertices[label == k], axis=0))) for k in range(pieces)
    ]
    order = np.argsort(extent)[::-1]
    outer, inner = (vertices[label == k] for k in order[:2])
    contained = (inner.min(axis=0) >= outer.min(axis=0)).all() and (
        inner.max(axis=0) <= outer.max(axis=0)
    ).all()
    if extent[order[1]] > 0.2 * extent[order[0]] and not contained:
        raise ValueError(
            f"it holds {pieces} separate surfaces, two of them nearly as large: give"
            " each seed a file of its own"
        )
    notes.append(
        f"the largest of {pieces} separate surfaces was taken: voids and dust are"
        " left out"
    )
    faces = faces[label[faces[:, 0]] == order[0]]
    used, renamed = np.unique(faces, return_inverse=True)
    return vertices[used], renamed.reshape(-1, 3)


def _orient_faces(vertices: Array, faces: Array, notes: list[str]) -> Array:
    """Orient all faces alike."""
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    trimesh.repair.fix_winding(mesh)
    turned = int((mesh.faces != faces).any(axis=1).sum())
    if turned:
        notes.append(
            f"{min(turned, len(faces) - turned)} faces turned to agree with their"
            " neighbours"
        )
    return np.array(mesh.faces, np.int64)


def _close_holes(
    vertices: Array, faces: Array, notes: list[str]
) -> tuple[Array, Array]:
    """Close every small hole by a fan of triangles to its middle; ValueError for a
    large one."""
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    codes = ends @ [len(vertices), 1]
    single = ends[~np.isin(codes, ends @ [1, len(vertices)])]
    if not len(single):
        return vertices, faces
    whole = area(vertices, faces)
    added: list[Array] = []
    middles: list[Array] = []
    for ring in _rings(single):
        middle = len(vertices) + len(middles)
        middles.append(vertices[ring].mean(axis=0))
        fan = np.stack([np.roll(ring, -1), ring, np.full(len(ring), middle)], axis=1)
        share = area(np.vstack([vertices, middles]), fan) / whole
        if share > LARGEST_HOLE:
            raise ValueError(
                f"the surface is open: a hole of {100 * share:.0f} % of it; up to"
                f" {100 * LARGEST_HOLE:g} % is closed"
            )
        added.append(fan)
    notes.append(f"{len(added)} hole{'s' * (len(added) > 1)} closed")
    return np.vstack([vertices, middles]), np.concatenate([faces, *added])


def _rings(edges: Array) -> list[list[int]]:
    """Directed edges (n, 2) put together to rings of vertices, none of which passes a
    vertex twice."""
    following: dict[int, list[int]] = {}
    for a, b in edges.tolist():
        following.setdefault(a, []).append(b)
    rings: list[list[int]] = []
    way: list[int] = []
    while following or way:
        way = way or [next(iter(following))]
        ends = following.get(way[-1])
        if not ends:
            raise ValueError(
                "the surface is not closed, and the edge of a hole does not run round"
                " it: mend it where it was made"
            )
        at = ends.pop()
        if not ends:
            del following[way[-1]]
        if at in way:
            rings.append(way[way.index(at) :])
            way = way[: way.index(at) + 1] if at in following else way[: way.index(at)]
        else:
            way.append(at)
    return rings


def crossing_faces(vertices: Array, faces: Array) -> Array:
    """Pairs of faces (n, 2) without a common vertex of which an edge of one passes
    through the other.

    The vertices are shifted by a millionth of the size at random, so that an edge which
    meets an edge is seen too."""
    size = float(np.ptp(vertices, axis=0).max())
    vertices = vertices + 1e-6 * size * np.random.default_rng(0).uniform(
        -1.0, 1.0, vertices.shape
    )
    pairs = _near_pairs(vertices, faces)
    shared = (faces[pairs[:, 0]][:, :, None] == faces[pairs[:, 1]][:, None, :]).any(
        axis=(1, 2)
    )
    pairs = pairs[~shared]
    hit = np.zeros(len(pairs), bool)
    for one, other in ((0, 1), (1, 0)):
        triangle = vertices[faces[pairs[:, other]]]
        for k in range(3):
            start, end = (vertices[faces[pairs[:, one], j % 3]] for j in (k, k + 1))
            hit |= _segments_cross_triangles(start, end, triangle)
    return pairs[hit]


def _near_pairs(vertices: Array, faces: Array) -> Array:
    """Pairs of faces whose boxes overlap, found through cells of the size of most
    boxes."""
    low, high = vertices[faces].min(axis=1), vertices[faces].max(axis=1)
    cell = max(
        float(np.quantile((high - low).max(axis=1), 0.9)),
        float(np.ptp(vertices, axis=0).max()) / 200.0,
    )
    first, last = (
        np.floor((corner - vertices.min(axis=0)) / cell).astype(np.int64)
        for corner in (low, high)
    )
    counts = np.prod(last - first + 1, axis=1)
    face = np.repeat(np.arange(len(faces)), counts)
    number = np.arange(len(face)) - np.repeat(np.cumsum(counts) - counts, counts)
    spans = (last - first + 1)[face]
    wide = spans[:, 2]
    at = first[face] + np.stack(
        [number // (spans[:, 1] * wide), number // wide % spans[:, 1], number % wide], 1
    )
    most = int(last.max()) + 1
    code = at @ [most * most, most, 1]
    order = np.argsort(code, kind="stable")
    code, face = code[order], face[order]
    found, apart = [np.empty((0, 2), np.int64)], 1
    while apart < len(code):
        same = np.flatnonzero(code[apart:] == code[:-apart])
        if not len(same):
            break
        a, b = face[same], face[same + apart]
        meet = ((low[a] <= high[b]) & (low[b] <= high[a])).all(axis=1)
        found.append(np.sort(np.stack([a[meet], b[meet]], axis=1), axis=1))
        apart += 1
    return np.unique(np.concatenate(found), axis=0)


def _segments_cross_triangles(start: Array, end: Array, triangle: Array) -> Array:
    """Whether segments (n, 3) to (n, 3) pass through triangles (n, 3, 3) (Möller &
    Trumbore 1997)."""
    a = triangle[:, 0]
    u = triangle[:, 1] - triangle[:, 0]
    v = triangle[:, 2] - triangle[:, 0]
    along = end - start
    p = np.cross(along, v)
    volume = np.einsum("ij,ij->i", u, p)
    scale = (
        np.linalg.norm(along, axis=1)
        * np.linalg.norm(u, axis=1)
        * np.linalg.norm(v, axis=1)
    )
    # parallel ones pass nowhere
    safe = np.where(np.abs(volume) > 1e-9 * scale, volume, np.nan)
    offset = start - a
    s = np.einsum("ij,ij->i", offset, p) / safe
    q = np.cross(offset, u)
    t, way = np.einsum("ij,ij->i", along, q) / safe, np.einsum("ij,ij->i", v, q) / safe
    return (s > 0) & (t > 0) & (s + t < 1) & (way > 0) & (way < 1)
