"""Plane curves and closed loops: what outlines, holes, patches and zones of a plate are made of.

==============  ================================================================
``curves``      segments, elliptic arcs and cubic Bezier curves
``loop``        closed chains of curves: area, centroid, what lies inside; loose curves put together
``shapes``      rectangles, circles, ellipses, polygons and closed splines
``relations``   where loops cross, overlap or touch
``fault``       what is wrong with a geometry, and where
==============  ================================================================
"""
