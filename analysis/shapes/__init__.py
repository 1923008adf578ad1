"""Mode shapes of structures measured at many places, and how they are judged.

=========================  ==================================================================
``participation``          residues of one pole as shape times participation; repeated roots
``assurance``              MAC, AutoMAC and MPC
``stabilization``          CMIF at every line, and poles over the order of the model
``wire_frame``             lines and faces between measuring points
``frf_checks``             drive points and reciprocity
=========================  ==================================================================
"""
