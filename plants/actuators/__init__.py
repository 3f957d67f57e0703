"""What pushes a rod along, each as one object that a machine is made of."""
