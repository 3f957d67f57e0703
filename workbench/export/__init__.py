"""What goes on outside the program: controllers as C, linear models, notebooks."""
