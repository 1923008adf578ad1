# %% [markdown]
# # Analyse a campaign
#
# From a recorded campaign to filters that follow the temperature. The example's recording comes with Flexura: put
# the path of your own in its place. Results go to the folder `analysed`. The same exists as a script
# (`analyse_a_campaign.py`) and as a notebook (`analyse_a_campaign.ipynb`).

# %%
from pathlib import Path

import flexura

recording = flexura.example("pp-plate")
results = Path("analysed")
results.mkdir(exist_ok=True)

# %% [markdown]
# ## Measurement
# Channels, lengths, units, clipping and temperatures of every file are checked here.

# %%
campaign = flexura.load(recording)
print(campaign)

# %%
frf = flexura.frf(campaign)
print(frf)

# %%
flexura.plot(frf).savefig(results / "waterfall.png")

# %% [markdown]
# ## Modes, each sweep with its own

# %%
modes = flexura.identify(campaign, band=(100.0, 500.0), out=results)
print(modes)

# %%
first = modes.tracked.modes[0]
for frequency, loss in zip(
    first.reading("hysteretic").frequency_hz[first.real],
    first.reading("hysteretic").loss_factor[first.real],
    strict=True,
):
    print(f"{frequency:8.1f} Hz, loss factor {100 * loss:.2f} %")

# %% [markdown]
# ## Material of the plate over temperature
# `out` writes the files that `flexura update` writes, so that verbs go on from here.

# %%
updating = flexura.update(campaign, out=results)
print(updating)

# %%
modulus = updating.laws.at([20.0]).youngs_modulus[0]
print(f"E at 20 °C: {modulus / 1e9:.3f} GPa")

# %%
flexura.plot(updating, "laws").savefig(results / "laws.png")

# %%
flexura.plot(updating, "overlays").savefig(results / "overlays.png")

# %% [markdown]
# ## Filters of a panel of this material

# %%
filters = flexura.focus(results, temperature=[0.0, 20.0, 40.0, 60.0], out=results)
print(filters)

# %%
flexura.plot(filters).savefig(results / "before.png")
