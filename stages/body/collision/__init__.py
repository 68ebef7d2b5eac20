"""Self-collision of the posed body: found, parted by planes, judged (CLOTH3D, "Self-collision")."""
