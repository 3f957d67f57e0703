"""Records of machines of many kinds and sizes, with effects that nobody declared, and how well diagnosis finds them."""
