"""Filters for listeners against filters for the field, and the sound at two listeners against the plain way.

    python benchmarks/sound.py [LAWS.h5] [--seconds S]

Design at 13 temperatures of the section-2 panel, with its sound judged: processor time by listeners over that by
the field. Then the volts of six actuators through the responses at two listeners, two ears beside them, while the
panel warms from 20 to 45 °C: seconds of sound to a second of processor time, against scipy's oaconvolve through
the responses of one temperature, which gives the same sound where the temperature stands still. One thread.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from scipy.signal import oaconvolve
from threadpoolctl import threadpool_limits

sys.path.insert(0, str(Path(__file__).resolve().parent))

from filters import paper_laws

from analysis.focusing.over_temperature import focus
from analysis.focusing.panel import PanelSound, SoundListener
from analysis.rendering.renderer import SAMPLES_BEFORE_ZERO, impulse_responses
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.results.laws_file import load_laws
from app.sound.rendering import ListenersOfPanel
from app.twins.panel_twin import panel_twin

MOST = 1.5
"""Design for listeners over design for the field."""
LEAST = 20.0
"""Times real time."""
BLOCK = 512


def main() -> None:
    """Measure both, print the ratios; exit 1 where one falls short or results differ."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("laws", type=Path, nargs="?")
    parser.add_argument("--seconds", type=float, default=60.0, help="of audio")
    options = parser.parse_args()
    declared = read_panel(SECTION_2)
    laws = declared.plate.grown(paper_laws() if options.laws is None else load_laws(options.laws))
    model = panel_twin(declared, laws, lambda _stage, _share: None)
    temperature = np.linspace(*np.clip(laws.temperature_range, 0.0, 60.0), 13)
    ears = tuple(SoundListener(name=name, position=(x, 0.1, 0.8)) for name, x in (("one", 0.0), ("two", 0.24)))
    with threadpool_limits(1):
        taken = []
        for aim in ("field", "listeners"):
            filters = declared.filters.model_copy(update={"aim": aim})
            panel = declared.model_copy(update={"filters": filters, "sound": PanelSound()})
            focus(model, panel, laws, temperature)  # warm
            begun = time.process_time()
            focus(model, panel, laws, temperature)
            taken.append(time.process_time() - begun)
        ratio = taken[1] / taken[0]
        print(f"design at 13 temperatures: field {taken[0]:.2f} s, listeners {taken[1]:.2f} s, ratio {ratio:.2f}")

        panel = declared.model_copy(update={"sound": PanelSound(listener=ears)})
        listeners = ListenersOfPanel.of(model, panel, laws)
        rate = panel.filters.sample_rate
        count = int(options.seconds * rate) // BLOCK * BLOCK
        volts = np.random.default_rng(0).standard_normal((len(panel.centers), count))
        factor = count / rate / _rendered(listeners, volts, np.linspace(20.0, 45.0, count // BLOCK))[1]
        still, _ = _rendered(listeners, volts, np.full(count // BLOCK, 30.0))
        begun = time.process_time()
        impulses = impulse_responses(listeners.response, panel.filters, 30.0)
        plain = sum(oaconvolve(volts[n][None], impulses[:, n], axes=1) for n in range(len(volts)))
        theirs = count / rate / (time.process_time() - begun)
    late = np.asarray(plain)[:, SAMPLES_BEFORE_ZERO : SAMPLES_BEFORE_ZERO + still.shape[1]]
    error = float(np.abs(late - still).max() / np.abs(late).max())
    print(
        f"{count / rate:.0f} s of sound at two listeners and two ears: {factor:.0f} times real time as it warms; "
        f"plain, at one temperature, {theirs:.0f} times, ratio {factor / theirs:.2f}; they differ by {error:.1e}"
    )
    good = ratio <= MOST and factor >= LEAST and error < 1e-9
    print("as wanted" if good else "FALLS SHORT")
    sys.exit(0 if good else 1)


def _rendered(listeners: ListenersOfPanel, volts: np.ndarray, course: np.ndarray) -> tuple[np.ndarray, float]:
    """Sound (L, n) and the processor seconds that it took."""
    begun = time.process_time()
    work, parts = listeners.renderer(float(course[0])), []
    for place, temperature in enumerate(course):
        parts += work.take(volts[:, place * BLOCK : (place + 1) * BLOCK], float(temperature))
    return np.concatenate(parts, axis=1), time.process_time() - begun


if __name__ == "__main__":
    main()
