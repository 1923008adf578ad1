"""Heat in a plate, on the mesh of its twin.

==============  =====================================================================
``heat_model``  heat conduction in a plate, and its temperatures step by step, also in a declared weather
==============  =====================================================================
"""
