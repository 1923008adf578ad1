"""State of a plate during one sweep.

=====================  ================================================================
``plate_state``        fields over the plate, attachments, and factors on its signals; errors of the declaration:
                       lengths, mass, patches, wiring, moduli of a sheet
``field_basis``        smooth fields as Legendre polynomials
``state_matrices``     sparse matrices of any state, without reduction
``patch_departures``   change of the matrices by an offset of the first sensor, and where a patch is not as
                       declared
``attached``           masses, springs and dashpots at any place
``damaged_spots``      change of the matrices by discs of reduced stiffness
=====================  ================================================================
"""
