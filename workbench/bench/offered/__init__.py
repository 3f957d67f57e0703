"""What each group of the bench offers: controller, machine, friction, belief, effects, motion, sensors."""
