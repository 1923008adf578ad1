"""The window on a campaign being acquired: a process of its own, which only reads the campaign's folder.

=================  ==============================================================
``window``         all of it, with pause and stop
``hammer_window``  the same of a hammer test: what came of the last hit
=================  ==============================================================

It reads the folder through `app.watch.watched`. Requests to the runner go into ``control.json``
(`app.files.acquisition.events`); nothing else is written.
"""
