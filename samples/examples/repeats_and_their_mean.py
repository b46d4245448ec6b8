"""Several repeats and their mean: seeds differ more than readings do.

Each of eight drops is measured to a part in ten thousand, but they scatter by 3 %: no
better camera helps, more seeds do. The interval of the mean comes from the scatter."""

from benchtwin import measure

found = measure([f"samples/soybean-bench/drop-{k:02d}" for k in range(1, 9)])
line = found.summary.set_index("quantity").loc["restitution"]
print(f"restitution {line['mean']:.3f} ({line['low']:.3f} to {line['high']:.3f})")
print(f"scatter {line['scatter']:.4f}, of which reading {line['measuring']:.5f}")
half_width = (line["high"] - line["low"]) / 2

picture = found.plot()
