"""A plate during one sweep.

=====================  ================================================================
``plate_state``        fields over it, attachments to it, what its signals pass through
``field_basis``        smooth fields as Legendre polynomials
``extreme_states``     the edges of what effects may do
``certified_range``    where a reduced plate may be asked
``state_matrices``     sparse matrices of any state, fields taken as they are
``sensor_offset``      what moving the first sensor changes
``damaged_spots``      what discs of less stiffness take away
=====================  ================================================================
"""
