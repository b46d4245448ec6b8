"""Meshes from files: units, holes, faces that cross or are too many; voxels. Files are
written here by hand or by trimesh."""

import numpy as np
import pytest
import trimesh

from benchtwin.sim.seed.mesh_file import MOST_FACES, crossing_faces, read_mesh
from benchtwin.sim.seed.shape import Shape
from benchtwin.sim.seed.voxels import closed_surface


def sphere(faces_level=3, radius=4.0):
    return trimesh.creation.icosphere(faces_level, radius)


def saved(mesh, folder, name="grain.stl"):
    mesh.export(folder / name)
    return folder / name


@pytest.mark.parametrize("kind", ["stl", "ply", "obj"])
def test_each_format_gives_the_same_body(tmp_path, kind):
    mesh = trimesh.creation.box((8.0, 5.0, 3.0))
    shape = read_mesh(saved(mesh, tmp_path, f"grain.{kind}"), "mm")
    assert shape.volume_m3 == pytest.approx(120e-9, rel=1e-6)
    assert shape.dimensions_m == pytest.approx([8e-3, 5e-3, 3e-3], rel=1e-6)
    assert shape.notes == ()


def test_stl_as_text(tmp_path):
    corners = np.array([[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]], float)
    lines = ["solid tetrahedron"]
    for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        lines += [
            "facet normal 0 0 0",
            "outer loop",
            *(f"vertex {x} {y} {z}" for x, y, z in corners[list(face)]),
            "endloop",
            "endfacet",
        ]
    (tmp_path / "t.stl").write_text("\n".join([*lines, "endsolid"]))
    assert read_mesh(tmp_path / "t.stl", "mm").volume_m3 == pytest.approx(36e-9)


@pytest.mark.parametrize(
    ("unit", "factor"), [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("inch", 0.0254)]
)
def test_unit(tmp_path, unit, factor):
    shape = read_mesh(
        saved(
            trimesh.creation.box((0.008 / factor, 0.005 / factor, 0.003 / factor)),
            tmp_path,
        ),
        unit,
    )
    assert shape.dimensions_m == pytest.approx([8e-3, 5e-3, 3e-3], rel=1e-5)


def test_no_unit_is_asked_for_by_size(tmp_path):
    with pytest.raises(
        ValueError, match=r"grain.stl: 0.3 long, in no unit.*--unit: (mm|inch)"
    ):
        read_mesh(saved(trimesh.creation.box((0.3, 0.2, 0.2)), tmp_path), None)
    with pytest.raises(ValueError, match=r"mm makes it 8 mm"):
        read_mesh(saved(trimesh.creation.box((8, 5, 3)), tmp_path), None)


def test_a_small_hole_is_closed_and_said(tmp_path):
    mesh = sphere()
    whole = mesh.volume
    mesh.update_faces(np.arange(len(mesh.faces)) >= 3)
    shape = read_mesh(saved(mesh, tmp_path), "mm")
    assert shape.volume_m3 == pytest.approx(whole * 1e-9, rel=2e-3)
    assert "closed" in shape.notes[0]


def test_a_wide_hole_is_refused(tmp_path):
    mesh = sphere()
    mesh.update_faces(mesh.triangles_center[:, 2] < 1.0)
    with pytest.raises(
        ValueError, match=r"grain.stl: the surface is open: a hole of \d+ %"
    ):
        read_mesh(saved(mesh, tmp_path), "mm")


def test_faces_that_look_the_wrong_way_are_turned_and_said(tmp_path):
    mesh = sphere()
    whole = mesh.volume
    mesh.faces[:40] = mesh.faces[:40, ::-1]
    shape = read_mesh(saved(mesh, tmp_path), "mm")
    assert shape.volume_m3 == pytest.approx(whole * 1e-9, rel=1e-5)
    assert shape.notes == ("40 faces turned to agree with their neighbours",)


def test_a_surface_that_crosses_itself_is_refused(tmp_path):
    mesh = sphere()
    top = mesh.vertices[:, 2] > 3.6
    mesh.vertices[top] -= [0, 0, 9.0]  # the cap pushed out through the other side
    with pytest.raises(
        ValueError, match=r"the surface intersects itself: \d+ pairs of faces cross"
    ):
        read_mesh(saved(mesh, tmp_path), "mm")


def test_crossing_faces_are_those_of_every_pair_tried_by_hand():
    rng = np.random.default_rng(3)
    vertices = rng.uniform(0, 3.0, (80, 1, 3)) + rng.normal(0, 0.5, (80, 3, 3))
    faces = np.arange(240).reshape(80, 3)
    points = vertices.reshape(-1, 3)
    found = {tuple(pair) for pair in crossing_faces(points, faces)}

    def pierces(p, q, t):
        side = [
            np.linalg.det(np.stack([t[1] - t[0], t[2] - t[0], x - t[0]]))
            for x in (p, q)
        ]
        around = [
            np.linalg.det(np.stack([q - p, t[k] - p, t[(k + 1) % 3] - p]))
            for k in range(3)
        ]
        return side[0] * side[1] < 0 and (min(around) > 0 or max(around) < 0)

    expected = {
        (i, j)
        for i in range(80)
        for j in range(i + 1, 80)
        if any(
            pierces(vertices[a][k], vertices[a][(k + 1) % 3], vertices[b])
            for a, b in ((i, j), (j, i))
            for k in range(3)
        )
    }
    assert found == expected and len(found) > 20


def test_many_faces_are_thinned_and_said(tmp_path):
    mesh = sphere(6)  # 81,920 faces
    shape = read_mesh(saved(mesh, tmp_path), "mm")
    assert len(shape.faces) <= MOST_FACES
    assert shape.notes[0].startswith("thinned from 81,920 to")
    assert shape.volume_m3 == pytest.approx(mesh.volume * 1e-9, rel=1e-4)
    distance = np.linalg.norm(shape.vertices_m - shape.solid.centre_m, axis=1)
    assert distance == pytest.approx(np.full(len(distance), 4e-3), rel=2e-3)


def test_dust_and_voids_are_left_out_and_two_seeds_refused(tmp_path):
    speck, void, other = sphere(1, 0.1), sphere(2, 1.0), sphere(3)
    speck.apply_translation([6, 0, 0])
    void.invert()
    other.apply_translation([9, 0, 0])
    shape = read_mesh(
        saved(trimesh.util.concatenate([sphere(), speck, void]), tmp_path), "mm"
    )
    assert shape.volume_m3 == pytest.approx(sphere().volume * 1e-9, rel=1e-5)
    assert "largest of 3 separate surfaces" in shape.notes[0]
    with pytest.raises(ValueError, match="a file of its own"):
        read_mesh(saved(trimesh.util.concatenate([sphere(), other]), tmp_path), "mm")


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.stl", b"", "a.stl"),
        ("a.stl", b"solid x\nendsolid x\n", "a.stl"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n", "a.ply"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\n", "a.obj"),
        ("a.step", b"ISO-10303-21;", "must be a mesh in one of"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "hole|closed"),
        ("a.obj", b"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", "mm long|one place"),
    ],
)
def test_bad_files_are_named(tmp_path, name, content, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=words) as caught:
        read_mesh(tmp_path / name, "mm")
    assert name in str(caught.value)


def test_bad_units_and_sizes(tmp_path):
    file = saved(sphere(), tmp_path)
    with pytest.raises(ValueError, match="must be one of mm, cm, m, inch"):
        read_mesh(file, "furlong")
    with pytest.raises(ValueError, match="8000 mm long if in m"):
        read_mesh(file, "m")
    with pytest.raises(ValueError, match="no such file"):
        read_mesh(tmp_path / "none.stl", "mm")


def ellipsoid_voxels(halves, pitch, centre=(0.0, 0.0, 0.0)):
    half = int(max(halves) / pitch) + 4
    at = (
        np.mgrid[-half : half + 1, -half : half + 1, -half : half + 1].transpose(
            1, 2, 3, 0
        )
    ) * pitch - centre
    return ((at / halves) ** 2).sum(axis=-1) <= 1.0


def test_voxels_of_an_ellipsoid():
    halves, pitch = np.array([4.36e-3, 3.42e-3, 2.99e-3]), 0.2e-3
    voxels = ellipsoid_voxels(halves, pitch, (3e-5, 5e-5, -2e-5))
    shape = Shape(*closed_surface(voxels, pitch))
    volume = 4 / 3 * np.pi * np.prod(halves)
    # the voxels' own count scatters by about the square root of their number on the
    # surface over all: 0.2 %
    assert shape.volume_m3 == pytest.approx(volume, rel=3e-3)
    assert shape.dimensions_m == pytest.approx(2 * halves, rel=0.015)
    a, b, c = halves**2
    moments = np.diag(shape.principal()[0].solid.inertia(1.0))
    assert moments == pytest.approx(
        volume / 5 * np.array([b + c, a + c, a + b]), rel=0.01
    )


def test_voxels_lose_dust_and_voids():
    voxels = ellipsoid_voxels(np.array([10.0, 8, 6]), 1.0)
    clean = Shape(*closed_surface(voxels, 1e-4))
    voxels[1, 1, 1] = True
    middle = voxels.shape[0] // 2
    voxels[middle - 1 : middle + 1, middle, middle] = False
    shape = Shape(*closed_surface(voxels, 1e-4))
    assert shape.vertices_m == pytest.approx(clean.vertices_m)
    assert shape.notes == (
        "the largest of 2 pieces was taken",
        "voids of 2 voxels were filled",
    )


def test_voxels_that_meet_in_an_edge_only_still_give_a_closed_surface():
    voxels = np.zeros((24, 24, 24), bool)
    voxels[2:12, 2:12, 2:20] = voxels[12:22, 12:22, 2:20] = True
    voxels[8:16, 8:16, 10:14] = True  # one piece through here
    vertices, faces, _ = closed_surface(voxels, 1e-4)
    assert Shape(vertices, faces).volume_m3 == pytest.approx(
        voxels.sum() * 1e-12, rel=1e-6
    )


@pytest.mark.parametrize(
    ("voxels", "pitch", "words"),
    [
        (np.ones((3, 3), bool), 1.0, "three dimensions"),
        (np.zeros((9, 9, 9), bool), 1.0, "0 voxels"),
        (np.ones((9, 9, 9), bool), 0.0, "pitch_m"),
        (np.ones((4, 4, 4), bool), 1.0, "64 voxels: 200 at least"),
    ],
)
def test_bad_voxels(voxels, pitch, words):
    with pytest.raises(ValueError, match=words):
        closed_surface(voxels, pitch)
