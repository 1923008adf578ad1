"""Poles and residues of FRFs, tracked over temperature.

=========================  ==================================================================
``automatic``              identify FRFs that share their poles: search, order, judgement
``settings``               where the search begins and ends, residual terms, mains
``finishing``              the order settled, a last fit on all lines, a judgement of every pole
``peak_picking``           the paper's own recipe: local peaks, then wide-band refinement
``tracking``               one identification followed over temperature, both ways
``expected_modes``         sweeps fitted with the modes a twin expects, under its numbers
``following``              poles of one sweep followed to the others
``naming``                 names for the modes of sweeps that were identified one by one
``smooth_tracks``          what poles of all sweeps have in common: the prior of a fit together
``joint_fit``              poles and tracks of all sweeps found together, with their deviations
``sweeps_search``          sweeps at one place of their poles, and the step from there
``sweep_fits``             modes of every sweep from that fit, judged
``superfluous``            tracks for which the sweeps together do not pay
``unseen``                 modes that only all sweeps together show, and what hidden ones may move
``modes``                  what was identified; rebuilds its FRFs
``common_factor``          how far a change of temperature moves all frequencies
``tracked_modes``          the same over temperature
``reading``                frequency and damping of a pole, hysteretic or viscous
``status``                 which poles are modes of the plate, and why the others are not
``pole_residue``           the model: columns, derivatives, synthesis
``residual_terms``         what stands for the modes out of band
``measured``               FRFs as they come
``lines``                  measured lines with their weights
``room``                   memory that fits share
``averaging``              fewer lines for the search
``noise``                  weights of FRFs without a variance, and what responses share of them
``running_median``         a running median along frequency
``confirmation``           which modes are found again when band, lines or channels change
``alike_damping``          what modes tell of one another's damping
``parameters``             poles as numbers a search moves, with bounds
``variable_projection``    residues eliminated: misfit, gradient and Hessian of the poles alone
``normal_equations``       the triangular factor of a weighted least-squares problem
``pole_search``            least squares over the poles
``vector_fitting``         start poles from nothing
``order``                  backward elimination and residual terms by BIC
``bic``                    the criterion, and what it asks for a pole
``resolution``             what a record is too short to tell apart
``added_columns``          what columns added to a model would explain
``missing``                poles the residual asks for
``splitting``              one pole that stands for two
``harmonics``              lines the mains have spoilt
``synthetic``              R10, the hard case with its truth
=========================  ==================================================================
"""
