"""Heat in a plate, on the mesh of its twin.

==============  =====================================================================
``heat_model``  heat conduction in a plate, and its temperatures step by step
``weathered``   temperatures of a declared plate in a declared weather
==============  =====================================================================
"""
