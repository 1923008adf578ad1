"""The window on a campaign being acquired: a process of its own, which only reads the campaign's folder.

=================  ==============================================================
``oven_chart``     temperatures against the programme, with the sweeps
``sweep_charts``   the repeat recorded last: signals, spectrum, levels
``frf_charts``     the last FRF over those before, and its coherence
``window``         all of it, with pause and stop
``hammer_window``  the same of a hammer test: what came of the last hit
=================  ==============================================================

It reads the folder through `app.watch.watched`. Requests to the runner go into ``control.json``
(`app.files.control`); nothing else is written.
"""
