"""A drop simulated, filmed, measured, and compared with the truth.

The engine lets a bean fall, a camera films it, and the code that measures films from
the bench measures this one. The simulation knows the answer, so that the error
of filming and measuring stands alone."""

import tempfile

from benchtwin import simulate

once = {"drop.bounces": 1}
drop = simulate("drop", out=tempfile.mkdtemp(), settings=once, rendered=True)
measured = drop.measured.quantities.set_index("quantity")
value, sd = measured.loc["restitution", ["value", "sd"]]
truth = drop.truth["restitution"].iloc[0]
print(f"measured {value:.4f} ± {sd:.4f}, the simulation knows {truth:.4f}")

picture = drop.measured.picture(drop.names[0])
