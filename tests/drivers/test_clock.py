import time

from drivers.clock import SystemClock, VirtualClock


def test_virtual_time_passes_only_by_sleeping():
    clock = VirtualClock(5.0)
    assert clock.now() == 5.0
    before = time.monotonic()
    clock.sleep(3600.0)
    clock.sleep(-1.0)
    assert clock.now() == 3605.0
    assert time.monotonic() - before < 60.0


def test_system_clock_sleeps_at_least_as_long_as_asked():
    clock = SystemClock()
    before = clock.now()
    clock.sleep(0.01)
    clock.sleep(-1.0)
    assert clock.now() - before >= 0.01
