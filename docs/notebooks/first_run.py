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
# # A run, looked at
#
# `pip install 'cohaptic[notebook]'` is all that is needed. Two people hold a box over a network;
# half a second more or less is a matter of one place in the scenario.

# %%
import cohaptic

scenario = cohaptic.load("two_users_box", sets=["duration=3 s"])
finished = cohaptic.run(scenario, figure=False)
finished

# %% [markdown]
# The record opens as a mapping of signals; each is a NumPy array with its unit.

# %%
run = finished.open()
run

# %%
height = run["vr_a.box_pose.y"]
print(height.unit, height.values[-3:])

# %% [markdown]
# A table for pandas, a column a signal:

# %%
frame = run.to_dataframe("vr_?.box_pose.y")
print(frame.tail(3))

# %% [markdown]
# The two copies of the box drift apart as long as the network delays what each side knows of the
# other. A heavier box moves less:

# %%
heavier = cohaptic.edit(
    scenario, {"components.vr_a.parameters.mass": 0.5, "components.vr_b.parameters.mass": 0.5}
)
other = cohaptic.run(heavier, figure=False)
for each in (finished, other):
    print(f"{each.summary.content['measures']['drift'] * 1e3:.3f} mm")

# %%
run.close()
