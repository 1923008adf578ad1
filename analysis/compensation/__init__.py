"""Filters at any temperature, learnt from filters at a few.

======================  ======================================================================
``settings``            how networks are trained
``study``               every method put to the test
``direct_filters``      filters computed at every temperature, and their energies
``rivals``              what networks are compared with, by name
``measured``            the same on filters of measured transfers, without a twin
``knots``               where to put training temperatures
``law_band``            what uncertain laws leave of the contrast
``tilted``              one side of the panel warmer than the other
``burden``              bytes and multiplications of every method
``outcome``             what came of it
``parameter_studies``   networks over nodes and spacing
``network``             trained networks: temperature in, taps out, clamped to their range
``training``            train, choose, refuse
``batch``               training data scaled and rotated, first weights
``evidence_collapse``   the refusal
``bayesian``            Levenberg–Marquardt with MacKay's evidence
``evidence``            weights of parameters and errors that the data ask for
``tensors``             arrays of numpy on the processor, tensors of torch on other devices
``linearised``          parameters and outputs of the networks, linearised
``schur_complement``    its normal matrix, a block arrow that is never formed
``interpolation``       the rivals: linear, cubic spline, equal reduced frequency
``low_rank``            a mean and a few principal filters
``leave_one_out``       how far a training filter is missed when it is left out
``relative_error``      paper eq. (13)
======================  ======================================================================
"""
