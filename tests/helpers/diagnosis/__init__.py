"""Records of a plant with effects that its experiment file does not declare, and how well diagnosis finds them."""
