"""Graph conditional variational autoencoders of garments bound to a body (CLOTH3D, Dressed Human Generation).

`hierarchy` builds clusters and Laplacians of the two topologies, `graphs` turns them into torch operators,
`network` holds SVAE and DVAE, `conditioning` the network Gamma, `losses` what they are trained on.
"""

LEVELS = 6
TOPOLOGIES = ("body", "skirt")
