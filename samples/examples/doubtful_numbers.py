"""What a doubtful number is: one that carries the reason why it may be wrong.

`quality` is good, doubtful or failed. Doubtful numbers stand in the tables like others,
with a sentence that says what to check; a failed one is no number at all."""

from benchtwin import measure

found = measure("samples/soybean-paper")  # a paper's printed means, taken as readings
table = found.quantities
doubtful = table[table["quality"] == "doubtful"]
for row in doubtful.itertuples():
    print(f"{row.recording}: {row.quantity} = {row.value:.4g} {row.unit}: {row.reason}")
counts = table["quality"].value_counts().to_dict()

picture = found.plot()
