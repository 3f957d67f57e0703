"""What is controlled: friction laws, hydraulics, the actuators, named parameter sets. Pure maths, SI units."""
