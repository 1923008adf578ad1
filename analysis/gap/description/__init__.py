"""Description of a cause that no effect explains: where it acts, by which law, on what it depends.

=================  ===================================================================
``described``      forms, curves, dependences: the result
``place_map``      missing mass, stiffness and damping over the plate
``describing``     all forms fitted and compared; strength by temperature, ramp, level, channel and time
=================  ===================================================================
"""
