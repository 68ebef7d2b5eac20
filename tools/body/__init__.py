"""Reports on the body stage."""
