"""Which controllers and speeds of rotation meet an accuracy at a speed within a power, and with what probability."""
