# %% [markdown]
# # Close a gap
#
# A simulated plate has something that its twin lacks. `flexura.gap` says what, and gives a twin that has it.
# Run it as a script, or open it as a notebook in any editor that knows `# %%` cells. Results go to `puzzle-run`.

# %%
import subprocess
import sys
from pathlib import Path

import flexura

EXAMPLES = Path(__file__).resolve().parents[1]
recording, results = Path("puzzle"), Path("puzzle-run")

# %% [markdown]
# ## The campaign, on the simulated rig
# `[simulation.effects]` of the experiment's file holds the secret; the campaign does not tell it.

# %%
acquire = ["acquire", str(EXAMPLES / "hidden-effect.toml"), "--out", str(recording), "--quiet"]
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
for effect in gap.report.effects:
    values = ", ".join(f"{p.name} {p.value:.3g} ± {p.sigma:.2g} {p.unit}" for p in effect.parameters)
    print(f"{effect.name} (probability {effect.probability:.3f}): {values}")
flexura.plot(gap).savefig(results / "residual.png")
flexura.plot(gap, "laws").savefig(results / "corrected-laws.png")

# %% [markdown]
# ## The twin that has it
# Switched on for an update, the effect leaves no more than noise.

# %%
corrected = flexura.update(campaign, twin=results / "twin.toml")
print(corrected)
