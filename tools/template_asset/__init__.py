"""How the template garments are made: convex hulls of body parts with a tailor's ease, meshed isotropically."""
