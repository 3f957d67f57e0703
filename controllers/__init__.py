"""What controls: velocity estimators and control laws. Pure maths, SI units; a controller never sees a plant."""
