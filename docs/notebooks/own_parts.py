# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Parts of one's own: a class, a recording, a snapshot
#
# A component is a class with variables; it is handed to a run by name.

# %%
from pathlib import Path

import numpy as np

import cohaptic


class Push(cohaptic.Component):
    """Pushes with half a newton from tick 100 on."""

    @property
    def variables(self):
        return [cohaptic.Variable(name="value", causality=cohaptic.Causality.OUTPUT, unit="N")]

    def initialise(self, setup, inputs, outputs):
        self.value = outputs["value"]

    def evaluate(self, tick):
        self.value[0] = 0.5 if tick > 100 else 0.0

    def save(self):
        return None

    def load(self, values):
        pass


own = cohaptic.edit(
    cohaptic.load("single_axis_distributed", sets=["duration=0.5 s"]),
    {"components.step_1": {"python": Push, "station": "station_1", "rate": "control"}},
)
with cohaptic.run(own, figure=False).open() as run:
    print("pushed at tick", int(np.argmax(run["step_1.value"].values > 0)))

# %% [markdown]
# A recorded movement comes from a text file: a heading with names and units, a row a time.

# %%
t = np.arange(0, 1, 0.01)
rows = "\n".join(f"{1e3 * time:g}, {20 * np.sin(5 * time):.6f}" for time in t)
Path("hand.csv").write_text(f"t [ms], x [mm]\n{rows}\n")
Path("hand.yaml").write_text(
    """\
cohaptic: 1
duration: 1
rates: {control: 1024}
components:
  hand: {table: hand.csv, interpolate: linear}
  user: {fmu: operator, parameters: {trajectory: given, impedance: stiff}}
connections:
  - hand.x -> user.target_position[1]
"""
)
with cohaptic.run("hand.yaml", figure=False).open() as run:
    reference = run["user.reference_position[1]"]
    print(f"up to {reference.values.max():.4f} {reference.unit}")

# %% [markdown]
# A run leaves states behind, from which others go on, bit for bit:

# %%
whole = cohaptic.run(own, snapshots=["0.25 s"], figure=False)
later = cohaptic.resume(whole.folder, "0.25 s", figure=False)
with whole.open() as first, later.open() as second:
    name = "coupler_11.force"
    n = len(second[name].values)
    print("equal:", bool((first[name].values[-n:] == second[name].values).all()), "over", n, "rows")
