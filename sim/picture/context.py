"""An off-screen OpenGL context with pyrender's renderer in it, and the clear word where
there is none."""

import os
import threading
from pathlib import Path
from typing import Any

import numpy as np

Array = np.ndarray

# the same as scripts/system-packages.sh
EGL_PACKAGES = "libegl1 libegl-mesa0 libgl1-mesa-dri"
SHADERS = Path(__file__).parent / "shaders"


_lock = threading.Lock()
# contexts open in each process: the display belongs to all of a process, the last one
# ends it
_open: dict[int, int] = {}


class RenderingUnavailable(RuntimeError):
    """Pictures cannot be rendered here; the message says what to install."""


def _pyrender():
    """pyrender, imported late: it takes a second, needs EGL, and measuring must do
    without either.

    Written for numpy 1: `Mesh.bounds`, `Scene.bounds` and shadows ask for np.infty, so
    they cannot be used."""
    # off-screen; read by OpenGL when it is first imported
    os.environ["PYOPENGL_PLATFORM"] = "egl"
    import pyrender
    import pyrender.platforms.egl

    return pyrender


class Context:
    """An EGL context with pyrender's renderer in it, for one thread; several may be
    open side by side, in threads or processes.

    pyrender's own OffscreenRenderer ends the whole process's display when one of them
    is closed. A process that was forked while its parent had one open cannot render
    (the driver's threads are not copied) and is told so, where it would hang."""

    def __init__(self):
        inherited = [
            pid for pid, count in _open.items() if count and pid != os.getpid()
        ]
        if inherited:
            raise RenderingUnavailable(
                f"process {os.getpid()} was forked while process {inherited[0]} was"
                " rendering, and cannot render: close films before forking, or start"
                " worker processes with multiprocessing.get_context('spawn')"
            )
        with _lock:
            self._create()
            self.pid = os.getpid()
            _open[self.pid] = _open.get(self.pid, 0) + 1
        self.renderer = _renderer(self.pyrender, self.gl)(64, 64)
        self.renderer._program_cache.shader_dir = str(SHADERS)

    def _create(self) -> None:
        try:
            self.pyrender = _pyrender()
            from OpenGL import GL

            device = self.pyrender.platforms.egl.get_device_by_index(
                int(os.environ.get("EGL_DEVICE_ID", "0"))
            )
            self.platform = self.pyrender.platforms.egl.EGLPlatform(
                64, 64, device=device
            )
            self.platform.init_context()
        # EGL is missing in a dozen ways: no library, no driver, no device, no context
        except Exception as error:
            raise RenderingUnavailable(
                f"pictures cannot be rendered: no EGL ({type(error).__name__}:"
                f" {error}). On Debian or Ubuntu install it by   sudo apt-get update &&"
                f" sudo apt-get install -y --no-install-recommends {EGL_PACKAGES}"
            ) from error
        self.gl = GL

    def name(self) -> str:
        """Driver and version."""
        self.platform.make_current()
        return " · ".join(
            self.gl.glGetString(s).decode()
            for s in (self.gl.GL_RENDERER, self.gl.GL_VERSION)
        )

    def draw(self, scene: Any, width: int, height: int) -> Array:
        """The scene's RGBA, uint8 (height, width, 4), alpha = how much of the pixel is
        covered, colour times alpha."""
        self.platform.make_current()
        self.renderer.viewport_width, self.renderer.viewport_height = width, height
        flags = self.pyrender.RenderFlags
        return self.renderer.render(scene, flags.OFFSCREEN | flags.RGBA)

    def close(self) -> None:
        """Free everything; the process's last one ends the display. Not in a forked
        copy: it is its parent's."""
        from OpenGL import EGL, contextdata

        if self.pid != os.getpid():
            return
        self.platform.make_current()
        self.renderer.delete()
        contextdata.cleanupContext()
        with _lock:
            display = self.platform._egl_display
            EGL.eglMakeCurrent(
                display, EGL.EGL_NO_SURFACE, EGL.EGL_NO_SURFACE, EGL.EGL_NO_CONTEXT
            )
            EGL.eglDestroyContext(display, self.platform._egl_context)
            _open[self.pid] -= 1
            if not _open[self.pid]:
                EGL.eglTerminate(display)
            self.platform._egl_context = self.platform._egl_display = None


def _renderer(pyrender: Any, GL: Any) -> Any:
    class ColourRenderer(pyrender.Renderer):
        """pyrender's renderer without the depth picture, which cost more than the
        drawing."""

        def _read_main_framebuffer(self, scene, flags):
            width, height = self._main_fb_dims
            box = (0, 0, width, height)
            GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._main_fb_ms)
            GL.glBindFramebuffer(GL.GL_DRAW_FRAMEBUFFER, self._main_fb)
            GL.glBlitFramebuffer(*box, *box, GL.GL_COLOR_BUFFER_BIT, GL.GL_NEAREST)
            GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._main_fb)
            pixels = np.empty((height, width, 4), np.uint8)
            GL.glReadPixels(*box, GL.GL_RGBA, GL.GL_UNSIGNED_BYTE, pixels)
            return pixels[::-1]

    return ColourRenderer


def renderer_name() -> str:
    """Driver and version of the machine's EGL, such as "llvmpipe (LLVM 15.0.6, 256
    bits) · 4.5 (Core Profile) Mesa 22.3.6"."""
    context = Context()
    try:
        return context.name()
    finally:
        context.close()
