"""Heat in a plate, on the mesh of its twin.

==============  =====================================================================
``heat_model``  heat equation in the plane and through the thickness, as matrices
``marching``    temperatures over time, by an implicit rule of second order
``weathered``   temperatures of a declared plate in a declared weather
==============  =====================================================================
"""
