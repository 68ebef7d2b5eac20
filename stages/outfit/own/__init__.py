"""Your own garment: an OBJ placed on the rest body, checked, resized and worn as any other."""
