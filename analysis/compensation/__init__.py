"""Filters at any temperature, predicted from filters at a few training temperatures.

======================  ======================================================================
``settings``            settings of the training of networks
``study``               comparison of all methods over temperature, with a twin or with measured transfers
``rivals``              filters computed at every temperature, interpolation and principal filters: what networks
                        are compared with
``knots``               placement of training temperatures
``law_band``            contrast under the uncertainty of the material laws
``tilted``              contrast if one side of the panel is warmer than the other
``outcome``             result of the comparison, with memory and multiplications of every method
``network``             one network per actuator, a mean and a few principal filters; error of reconstructed
                        filters
``training``            training with restarts; the best is kept or refused; error where left out, over nodes and
                        spacing
``evidence_collapse``   error raised if no trained network is good enough
``bayesian``            Levenberg–Marquardt with MacKay's evidence
``linearised``          networks of one hidden layer: outputs, derivatives, their Gauss-Newton equations; arrays
                        of numpy or torch
======================  ======================================================================
"""
