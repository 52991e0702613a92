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
# # A map from simulation, and the theory's beside it
#
# One axis, two stations, a virtual coupler: how stiff may it be at which delay? The theory answers
# with the spectral radius of the loop, the simulation with runs that calm down or do not.

# %%
import cohaptic

vary = {
    "lan.round_trip_delay": "0, 2, 4, 8",
    "k": {"set": "coupler_1[12].stiffness", "values": "200..6000/5 log"},
}
outcome = cohaptic.sweep(
    "single_axis_distributed",
    vary,
    expect={"coupler_11.force": {"growth_below": 0}},
    workers=0,
)
outcome

# %% [markdown]
# A row a run; `passed` says whether what moved became less.

# %%
table = outcome.to_dataframe()
print(table.iloc[:, :4].head())

# %% [markdown]
# How many of them see something else than the theory does? Those next to the boundary may: a run is
# finite.

# %%
print(outcome.disagreements, "of", len(outcome.results))
assert outcome.disagreements <= 2

# %% [markdown]
# The theory alone, for one loop:

# %%
for stiffness in (400, 4000):
    loop = cohaptic.load(
        "single_axis_distributed",
        sets=[
            "channels.lan.round_trip_delay=4",
            f"components.coupler_11.parameters.stiffness={stiffness}",
            f"components.coupler_12.parameters.stiffness={stiffness}",
        ],
    )
    print(stiffness, round(cohaptic.spectral_radius(loop), 5))
