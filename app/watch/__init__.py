"""A running campaign seen from outside: its folder is read, never written.

===================  ==================================================================================
``watched``          the folder as it grows: events, readings, last sweeps, whether it is silent; the temperature
                     programme and the set-point as lines over time
``watched_hits``     the folder of a hammer test as it grows
``words``            events in sentences, times of day where the reader is
``status``           how a campaign or a hammer test stands, in a line, with its exit status
``news``             what people are told, and how often at most
``notifiers``        Apprise and commands, in processes that are ended if they hang; addresses of messages and the
                     page's token: environment, or files of mode 600
``apprise_process``  the process that sends a message through Apprise
``watcher``          several campaigns, looked at again and again; what the page shows of each, as JSON
``server``           the page's server: a few addresses, read only
``watching``         the process of ``flexura watch``
``beside``           that process, started by ``flexura acquire``
===================  ==================================================================================

``page.html``, ``page.css`` and ``page.js`` are the page; ``page.js`` draws what `watcher` keeps. The window of
`app.view.live` reads the folder through ``watched``, too.
"""
