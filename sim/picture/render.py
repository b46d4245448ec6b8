"""The stage: seeds and parts as instances of a few meshes, drawn off-screen. With
context.py the only user of pyrender."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchtwin.sim.motion import Motion
from benchtwin.sim.picture import look as looks
from benchtwin.sim.picture.camera import Camera, axes, view
from benchtwin.sim.picture.context import Context
from benchtwin.sim.picture.outline import flat, level_for, silhouette_true
from benchtwin.sim.picture.pose import matrices, poses_at
from benchtwin.sim.seed.surface import Mesh

Array = np.ndarray


@dataclass(eq=False)
class _Form:
    """Instances of one mesh. who: their numbers among the motion's seeds, then parts;
    radius_m: how far it reaches."""

    primitive: Any  # pyrender's
    node: Any
    who: Array
    radius_m: float


class Stage:
    """A motion's seeds and parts before a camera. Use as a context manager: it holds an
    OpenGL context.

    draw(box, fine) renders columns x0…x1, rows y0…y1 of the undistorted picture, `fine`
    × `fine` samples a pixel, each of them of 4 multisamples: uint8 (rows·fine,
    columns·fine, 4), colour times alpha, and alpha."""

    def __init__(
        self, motion: Motion, camera: Camera, look: looks.Look, *, of: str = "union"
    ):
        self.motion, self.camera = motion, camera
        self.reach_m = np.array(
            [motion.shapes[s].bounding_radius_m for s in motion.shape_of]
            + [np.linalg.norm(p.mesh.vertices_m, axis=1).max() for p in motion.parts]
        ).reshape(-1)
        parts = [looks.part_colour(look, p.finish)[None] for p in motion.parts]
        self.colours = (
            np.vstack([looks.seed_colours(look, motion.seeds), *parts]) / 255.0
        )
        self.context, self._open = Context(), True
        try:
            self._furnish(look, of)
        except BaseException:
            self.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self) -> None:
        """Free the OpenGL context; a second call does nothing."""
        if self._open:
            self._open = False
            self.context.close()

    def _furnish(self, look: looks.Look, of: str) -> None:
        pyrender = self.context.pyrender
        self.scene = pyrender.Scene(
            bg_color=np.zeros(4), ambient_light=np.full(3, look.ambient)
        )
        self.lens = self.scene.add(
            pyrender.IntrinsicsCamera(1.0, 1.0, 0.0, 0.0),
            pose=_camera_pose(self.camera),
        )
        right, down, away = axes(self.camera)
        self.sky = looks.SKY @ np.array([right, -down, -away])
        towards = (
            np.array(look.light)
            @ np.array([right, -down, -away])
            / np.linalg.norm(look.light)
        )
        self.scene.add(
            pyrender.DirectionalLight(np.ones(3), intensity=1.0 - look.ambient),
            pose=_facing(towards),
        )
        self.forms: list[_Form] = []
        for shape, seed in enumerate(self.motion.shapes):
            who = np.flatnonzero(self.motion.shape_of == shape)
            if who.size:
                size_px = seed.bounding_radius_m * 1e3 / self.camera.mm_per_px
                level = level_for(size_px, self.motion.seeds)
                self._add(silhouette_true(seed, level, of), who)
        for number, part in enumerate(self.motion.parts):
            self._add(flat(part.mesh), np.array([self.motion.seeds + number]))

    def _add(self, mesh: Mesh, who: Array) -> None:
        poses = np.tile(np.eye(4), (len(who), 1, 1))
        primitive = self.context.pyrender.Primitive(
            mesh.vertices_m, normals=mesh.normals, indices=mesh.faces, poses=poses
        )
        node = self.scene.add(self.context.pyrender.Mesh([primitive]))
        radius_m = float(np.linalg.norm(mesh.vertices_m, axis=1).max())
        self.forms.append(_Form(primitive, node, who, radius_m))

    def place(
        self, frame: int, later_s: float = 0.0, *, only: Array | None = None
    ) -> None:
        """Put everything where it is at a frame's moment plus `later_s`; only (seeds +
        parts,) bool: leave out the others."""
        self.places_m, turns = poses_at(self.motion, frame, later_s)
        self.there = np.isfinite(self.places_m).all(axis=1) & (
            True if only is None else only
        )
        self.poses = matrices(self.places_m, turns)
        self.poses[:, 3, :3] = self.colours
        seeds = self.motion.seeds
        lit = looks.openness(self.places_m[:seeds], self.reach_m[:seeds], self.sky)
        self.poses[:seeds, 3, :3] *= lit[:, None]

    def boxes(self) -> Array:
        """Columns and rows x0, y0, x1, y1 (n, 4) [px] of the undistorted picture that
        hold each thing placed; NaN: not there."""
        seen = view(self.camera, self.places_m)
        depth = self.camera.distance_m + seen[:, 2] - self.reach_m
        scale = self.camera.focal_px / np.where(
            depth > 0.01 * self.camera.distance_m, depth, 0.01 * self.camera.distance_m
        )
        middle, reach = seen[:, :2] * scale[:, None], (self.reach_m * scale)[:, None]
        boxes = np.hstack([middle - reach, middle + reach]) + np.tile(
            self.camera.centre_px, 2
        )
        # long and flat: a sphere would be far too large
        for number, part in enumerate(self.motion.parts, start=self.motion.seeds):
            corners = (
                self.places_m[number]
                + part.mesh.vertices_m @ self.poses[number, :3, :3].T
            )
            seen = view(self.camera, corners)
            depth = np.maximum(
                self.camera.distance_m + seen[:, 2], 0.01 * self.camera.distance_m
            )
            flat_px = (
                seen[:, :2] * (self.camera.focal_px / depth)[:, None]
                + self.camera.centre_px
            )
            boxes[number] = np.r_[flat_px.min(axis=0), flat_px.max(axis=0)]
        return np.where(self.there[:, None], boxes, np.nan)

    def draw(self, box: tuple[int, int, int, int], fine: int) -> Array:
        x0, y0, x1, y1 = box
        lens = self.lens.camera
        lens.fx = lens.fy = self.camera.focal_px * fine
        lens.cx, lens.cy = (self.camera.centre_px + 0.5 - [x0, y0]) * fine
        lens.znear, lens.zfar = self._depths()
        bounds = self.boxes()
        with np.errstate(invalid="ignore"):
            inside = (
                (bounds[:, 0] < x1)
                & (bounds[:, 2] > x0)
                & (bounds[:, 1] < y1)
                & (bounds[:, 3] > y0)
            )
        for form in self.forms:
            self._fill(form, form.who[inside[form.who]])
        if not inside.any():
            return np.zeros(((y1 - y0) * fine, (x1 - x0) * fine, 4), np.uint8)
        return self.context.draw(self.scene, (x1 - x0) * fine, (y1 - y0) * fine)

    def _fill(self, form: _Form, who: Array) -> None:
        """Hand the poses of instances `who` to the form: its buffer is made for all of
        them and filled with the first ones."""
        form.node.mesh.is_visible = bool(who.size)
        primitive, gl = form.primitive, self.context.gl
        if not who.size:
            return
        if not primitive._in_context():
            self.context.platform.make_current()
            self.context.renderer._update_context(self.scene, 0)
        primitive._poses = np.ascontiguousarray(self.poses[who], dtype=np.float32)
        data = np.ascontiguousarray(primitive._poses.transpose(0, 2, 1))
        self.context.platform.make_current()
        # 0: vertices, 1: poses, 2: faces
        gl.glBindBuffer(gl.GL_ARRAY_BUFFER, primitive._buffers[1])
        gl.glBufferSubData(gl.GL_ARRAY_BUFFER, 0, data.nbytes, data)

    def _depths(self) -> tuple[float, float]:
        away = (view(self.camera, self.places_m)[:, 2] + self.camera.distance_m)[
            self.there
        ]
        reach = self.reach_m[self.there]
        if not away.size:
            return 0.5 * self.camera.distance_m, 2.0 * self.camera.distance_m
        near = max(float((away - reach).min()) * 0.999, 0.01 * self.camera.distance_m)
        return near, max(float((away + reach).max()) * 1.001, 1.01 * near)


def _camera_pose(camera: Camera) -> Array:
    right, down, away = axes(camera)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, -down, -away], axis=1)
    pose[:3, 3] = np.asarray(camera.target_m) - camera.distance_m * away
    return pose


def _facing(towards: Array) -> Array:
    """A pose whose −z looks away from `towards`: light shines along −z."""
    side = np.cross(towards, np.eye(3)[np.argmin(np.abs(towards))])
    side /= np.linalg.norm(side)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([side, np.cross(towards, side), towards], axis=1)
    return pose
