"""Show: a finished ``Diagnosis`` as lines for a terminal (``words``), as a page (``page``), as a robot's description
with the effects in it (``apply``). Nothing is computed here.
"""
