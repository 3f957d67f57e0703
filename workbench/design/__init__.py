"""Which experiment to make next: the motion whose record tells hypotheses apart, or shows parameters, on this rig."""
