"""A study rehearsed: the exported C of its controllers, in the loop."""
