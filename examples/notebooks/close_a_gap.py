# %% [markdown]
# # Close a gap
#
# A simulated plate has something that its twin lacks. `flexura.gap` says what, and gives a twin that has it.
# Results go to the folder `puzzle-run`. The same exists as a script (`close_a_gap.py`) and as a notebook
# (`close_a_gap.ipynb`).

# %%
import subprocess
import sys
from pathlib import Path

import flexura

recording, results = Path("puzzle"), Path("puzzle-run")

# %% [markdown]
# ## The campaign, on the simulated rig
# `[simulation.effects]` of the experiment's file holds the secret; the campaign does not tell it.

# %%
acquire = ["acquire", str(flexura.example("hidden-effect.toml")), "--out", str(recording), "--quiet"]
subprocess.run([sys.executable, "-m", "flexura", *acquire], check=True)
campaign = flexura.load(recording)
print(campaign)

# %% [markdown]
# ## The plain twin misses more than noise

# %%
plain = flexura.update(campaign)
print(plain)

# %% [markdown]
# ## What it lacks

# %%
gap = flexura.gap(campaign, out=results)
print(gap)

# %%
for effect in gap.report.effects:
    values = ", ".join(f"{p.name} {p.value:.3g} ± {p.sigma:.2g} {p.unit}" for p in effect.parameters)
    print(f"{effect.name} (probability {effect.probability:.3f}): {values}")

# %%
flexura.plot(gap).savefig(results / "residual.png")

# %%
flexura.plot(gap, "laws").savefig(results / "corrected-laws.png")

# %% [markdown]
# ## The twin that has it
# Switched on for an update, the effect leaves no more than noise.

# %%
corrected = flexura.update(campaign, twin=results / "twin.toml")
print(corrected)
