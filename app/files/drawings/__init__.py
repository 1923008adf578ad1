"""Outlines and meshes that other programs have drawn, named in a declaration.

===============  =========================================================
``drawing``      what is named in a declaration, turned into what it holds; a declared mesh, compared with its
                 plate
``curves``       curves of DXF and SVG files
``mesh_reader``  meshes, read in a process of their own
``exodus_mesh``  meshes of Exodus
===============  =========================================================
"""
