"""The watchdog: what supervises the oven of a campaign and brings it to rest, whatever happens to the campaign.

On a real rig it is a process of its own, which owns the oven's port and imports neither numpy nor HDF5, gRPC or
Qt. On a simulated rig, whose time is virtual, the same supervision runs inside the campaign's process.

================  =====================================================================
``guard``         what follows from a fault, as a table; whether an oven that was switched off cools
``supervision``   an oven that is polled, and brought to rest after a fault
``frames``        messages between the processes, and what the watchdog's is told when it starts
``process``       the watchdog's process
``remote_oven``   the oven as the campaign's process has it
``zero_drive``    brings the drive to 0 V after the campaign's process has died
================  =====================================================================
"""
