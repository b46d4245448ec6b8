"""A saved state in ParaView: its balls, the forces between them, the seeds' first axes.

    pvpython samples/state_in_paraview.py heap/pile-01/state.vtkhdf heap.png

Or open the file in ParaView (5.12 or newer), choose it in the pipeline, and run this
file with View > Python Shell > Run Script: it takes the source that is chosen."""

import sys

from paraview import simple as pv

# the first column of the turn that the quaternion (x, y, z, w) stands for
X, Y, Z, W = (f'"orientation_{k}"' for k in range(4))
AXIS = (
    f"(1 - 2*({Y}*{Y} + {Z}*{Z}))*iHat + 2*({X}*{Y} + {Z}*{W})*jHat"
    f" + 2*({X}*{Z} - {Y}*{W})*kHat"
)


def show(state, view) -> None:
    """Balls, see-through; a line along each seed's first axis; tubes between balls that
    touch, coloured by how hard they are pressed together."""
    least, most = state.PointData["radius"].GetRange()
    every = {"Input": state, "GlyphMode": "All Points"}
    size = ["POINTS", "radius"]
    balls = pv.Show(
        pv.Glyph(**every, GlyphType="Sphere", ScaleArray=size, ScaleFactor=2), view
    )
    balls.Opacity = 0.05
    every["Input"] = pv.Calculator(Input=state, ResultArrayName="axis", Function=AXIS)
    along = ["POINTS", "axis"]
    axes = pv.Show(
        pv.Glyph(**every, GlyphType="Line", OrientationArray=along, ScaleFactor=most),
        view,
    )
    for one in balls, axes:
        pv.ColorBy(one, ("POINTS", ""))
        one.AmbientColor = one.DiffuseColor = [1.0, 1.0, 1.0]
    pressed = pv.Calculator(
        Input=state,
        AttributeType="Cell Data",
        ResultArrayName="pressed together [N]",
        Function="-normal_force",
    )
    forces = pv.Show(pv.Tube(Input=pressed, Radius=least / 4), view)
    pv.ColorBy(forces, ("CELLS", "pressed together [N]"))
    colours = pv.GetColorTransferFunction("pressed together [N]")
    colours.ApplyPreset("Plasma (matplotlib)", True)
    forces.SetScalarBarVisibility(view, True)
    bar = pv.GetScalarBar(colours, view)
    bar.WindowLocation, bar.Orientation = "Lower Center", "Horizontal"
    for hidden in state, pressed:
        pv.Hide(hidden, view)


def main() -> None:
    """Show the file that is named, or the source that is chosen in ParaView."""
    files = sys.argv[1:]
    state = pv.OpenDataFile(files[0]) if files else pv.GetActiveSource()
    view = pv.GetActiveViewOrCreate("RenderView")
    state.UpdatePipeline()
    show(state, view)
    view.ResetActiveCameraToPositiveY()
    view.ResetCamera()
    pv.Render(view)
    if len(files) > 1:
        pv.SaveScreenshot(files[1], view, ImageResolution=[1200, 800])


if __name__ == "__main__":
    main()
