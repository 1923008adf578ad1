"""A panel that watches itself: what has changed since a baseline, from patch-to-patch responses over weeks.

=================  ==================================================================================
``candidates``     changes that are looked for: effects of the library, and patches that lose polarization
``baseline``       twin and first recordings together: what the healthy panel answers; tested against itself
``recording``      one recording later, swept or played: its temperature, and normal equations of all candidates
``evidence``       weeks added up, and the limit that holds the rate of false alarms
``refined``        a candidate fitted with its place, by a twin that has it
``naming``         what the last dates show: every kind of change fitted
``watch``          all dates in turn: alarms, names, places; what comes out
=================  ==================================================================================
"""
