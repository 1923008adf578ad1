"""Plane curves and closed loops: what outlines, holes, patches and zones of a plate are made of.

==============  ================================================================
``loop``        segments, elliptic arcs and cubic Bezier curves; closed chains of them: area, centroid, what lies
                inside; rectangles, circles, ellipses, polygons and closed splines; loose curves put together;
                what is wrong with a geometry, and where
``relations``   where loops cross, overlap or touch
==============  ================================================================
"""
