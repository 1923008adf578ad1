"""Description of a cause that no effect explains: where it acts, by which law, on what it depends.

=================  ===================================================================
``place_map``      missing mass, stiffness and damping over the plate
``describing``     what an unknown cause is like, as a value, and how that is found
=================  ===================================================================
"""
