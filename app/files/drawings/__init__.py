"""Outlines and meshes that other programs have drawn, named in a declaration.

===============  =========================================================
``drawing``      what is named in a declaration, turned into what it holds
``dxf_curves``   curves of DXF files
``svg_curves``   curves of SVG files
``mesh_reader``  meshes, read in a process of their own
``exodus_mesh``  meshes of Exodus
``mesh_check``   a declared mesh, compared with its plate
===============  =========================================================
"""
