"""Mode shapes of structures measured at many places, and how they are judged.

=========================  ==================================================================
``participation``          residues of one pole as shape times participation; repeated roots; MAC, AutoMAC and MPC;
                           lines and faces between measuring points
``stabilization``          drive points and reciprocity; CMIF at every line, and poles over the order of the model
=========================  ==================================================================
"""
