"""Reports on the outfit stage."""
