# %% [markdown]
# # Analyse a campaign
#
# From a recorded campaign to filters that follow the temperature. Run it as a script
# (`python analyse_a_campaign.py [CAMPAIGN]`), or open it as a notebook in any editor that knows `# %%` cells.
# The example's recording comes with the project; the results go to `analysed`.

# %%
import sys
from pathlib import Path

import flexura

EXAMPLES = Path(__file__).resolve().parents[1]
recording = Path(sys.argv[1]) if len(sys.argv) > 1 else EXAMPLES / "pp-plate"
results = Path("analysed")

# %% [markdown]
# ## Measurement
# Channels, lengths, units, clipping and temperatures of every file are checked here.

# %%
campaign = flexura.load(recording)
frf = flexura.frf(campaign)
print(campaign, frf, sep="\n")
results.mkdir(exist_ok=True)
flexura.plot(frf).savefig(results / "waterfall.png")

# %% [markdown]
# ## Modes, each sweep with its own

# %%
modes = flexura.identify(campaign, band=(100.0, 500.0), out=results)
print(modes)
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
modulus = updating.laws.at([20.0]).youngs_modulus[0]
print(f"E at 20 °C: {modulus / 1e9:.3f} GPa")
flexura.plot(updating, "laws").savefig(results / "laws.png")
flexura.plot(updating, "overlays").savefig(results / "overlays.png")

# %% [markdown]
# ## Filters of a panel of this material

# %%
filters = flexura.focus(results, temperature=[0.0, 20.0, 40.0, 60.0], out=results)
print(filters)
flexura.plot(filters).savefig(results / "before.png")
