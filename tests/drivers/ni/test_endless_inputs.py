"""Inputs read without end: every sample once, in order; what the cards refuse is told."""

import numpy as np
import pytest

from drivers.ni.cards import Action, DaqError
from drivers.ni.daqmx import EndlessInputs
from drivers.ni.simulated.faults import Faults
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq
from drivers.ni.wiring import InputWiring

WIRING = InputWiring(
    drive_input="cDAQ1Mod1/ai0",
    responses=("cDAQ1Mod1/ai1",),
    thermocouples=("cDAQ1Mod3/ai0",),
    sample_rate=2048.0,
)


def test_blocks_follow_each_other_without_a_gap(server: SimulatedDaq, channel: InProcessChannel) -> None:
    with EndlessInputs(WIRING, channel) as inputs:
        assert inputs.sample_rate == pytest.approx(51_200.0 / 25)
        assert inputs.full_scale == pytest.approx(5.0, rel=0.1)
        inputs.begin()
        pieces = np.concatenate([inputs.read(n) for n in (100, 1, 2047, 512)], axis=1)
        assert inputs.temperatures() == pytest.approx([20.0], abs=0.5)  # meanwhile, by another module
        assert inputs.read(300).shape == (2, 300)
    task_noise = pieces.std(axis=1)
    assert pieces.shape == (2, 2660)
    assert np.all(task_noise > 1e-5)  # the module's own
    assert server.tasks_open() == ()


def test_a_program_that_does_not_keep_up_is_told_that_samples_were_lost(
    server: SimulatedDaq, channel: InProcessChannel
) -> None:
    with EndlessInputs(WIRING, channel) as inputs:
        inputs.begin()
        inputs.read(100)
        server.clock.sleep(60.0)
        with pytest.raises(DaqError) as raised:
            inputs.read(100)
        assert raised.value.action is Action.RETRY_DISCARD
        inputs.begin()  # and goes on
        assert inputs.read(100).shape == (2, 100)


def test_cards_that_are_unplugged_are_lost(server: SimulatedDaq, channel: InProcessChannel) -> None:
    inputs = EndlessInputs(WIRING, channel)
    inputs.begin()
    server.chassis.faults = Faults(unplugged=(server.clock.now() + 1.0, 1e9))
    inputs.read(200)
    with pytest.raises(DaqError) as raised:
        inputs.read(3000)
    assert raised.value.action is Action.LOST_DEVICE


def test_a_terminal_that_is_not_there_is_named_with_those_that_are(channel: InProcessChannel) -> None:
    wiring = WIRING.model_copy(update={"drive_input": "cDAQ1Mod7/ai0"})
    with pytest.raises(DaqError, match="cDAQ1Mod1/ai0"):
        EndlessInputs(wiring, channel)


def test_reading_before_it_has_begun_is_a_mistake(channel: InProcessChannel) -> None:
    with EndlessInputs(WIRING, channel) as inputs, pytest.raises(ValueError, match="call begin first"):
        inputs.read(10)
